#pragma once

#include "base/math.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace dapple::gpuscene {

/// A bounding volume hierarchy over items: instances, or clusters of their triangles; an item is an index, its user knows of
/// what. Binned surface-area heuristic (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies") with an
/// item's triangles as its cost. The same bytes whatever the number of threads.
class Hierarchy {
public:
    static constexpr uint32_t kNone = ~0u;
    struct Node {
        base::Box box;            ///< of everything below; metres from Scene::origin
        uint32_t parent = kNone;  ///< kNone: the root
        uint32_t right = kNone;   ///< second child, the first being the next node; kNone: a leaf
        uint32_t firstItem = 0, itemCount = 0;  ///< range of items(), for inner nodes too
        uint64_t triangles = 0;   ///< of everything below

        bool leaf() const { return right == kNone; }
    };
    struct Settings {
        uint64_t leafTriangles = 10'000;  ///< a node of no more is not split
        /// What visiting a node costs in triangles: a node that no split makes cheaper than that stays a leaf.
        double visitTriangles = 24;
    };

    Hierarchy() = default;
    /// `boxes` (metres from Scene::origin) and `triangles` are parallel, one entry per item. Items with an empty box are left
    /// out, for ever. Throws std::invalid_argument when the lengths differ or a box is not finite.
    Hierarchy(std::span<const base::Box> boxes, std::span<const uint32_t> triangles, const Settings& settings);

    /// Depth first: the root is 0, a parent stands before its children, a subtree is contiguous. Empty when no item has a box.
    std::span<const Node> nodes() const { return nodes_; }
    /// The items in the order of the leaves, each once; Node::firstItem counts here.
    std::span<const uint32_t> items() const { return items_; }
    std::span<const uint32_t> items(uint32_t node) const { return items().subspan(nodes_[node].firstItem, nodes_[node].itemCount); }

    /// Gives the named items new boxes and enlarges or shrinks the nodes above them, along the touched paths only; which
    /// items a leaf holds stays. `items` (each at most once) and `boxes` are parallel. Items that were left out are ignored.
    void refit(std::span<const uint32_t> items, std::span<const base::Box> boxes);

    /// Appends, depth first, the nodes that `keep` accepts with all above them, and no farther down than to leaves or nodes of
    /// at most `mostItems` items. `keep` gets a box, and must reject whatever lies within a box that it rejects.
    template <class Keep>
    void select(const Keep& keep, uint32_t mostItems, std::vector<uint32_t>& nodes) const {
        std::vector<uint32_t> open;
        if (!nodes_.empty()) open.push_back(0);
        while (!open.empty()) {
            const uint32_t n = open.back();
            const Node& node = nodes_[n];
            open.pop_back();
            if (!keep(node.box)) continue;
            if (node.leaf() || node.itemCount <= mostItems) {
                nodes.push_back(n);
                continue;
            }
            open.push_back(node.right);
            open.push_back(n + 1);
        }
    }
    /// Appends, in the order of the leaves, the items whose boxes `keep` accepts: as if it were asked of each.
    template <class Keep>
    void selectItems(const Keep& keep, std::vector<uint32_t>& items) const {
        std::vector<uint32_t> nodes;
        select(keep, 1, nodes);
        for (const uint32_t n : nodes)
            for (uint32_t i = nodes_[n].firstItem; i < nodes_[n].firstItem + nodes_[n].itemCount; ++i)
                if (nodes_[n].itemCount == 1 || keep(boxes_[i])) items.push_back(items_[i]);
    }

    /// Largest dot(direction, p) over the points p of all items' boxes, metres from Scene::origin times the length of
    /// `direction`; −infinity where there is no item. Visits few nodes.
    double support(const glm::dvec3& direction) const;

    /// Appends nodes whose boxes together enclose all of `node`, more tightly than its own (CHC++, section 4.4): breadth first
    /// at most `depth` levels down, as long as the sum of their surface areas is ≤ `areaRatio` × that of the node. Empty ones are left out.
    void tightBounds(uint32_t node, int depth, double areaRatio, std::vector<uint32_t>& into) const;

private:
    std::vector<Node> nodes_;
    std::vector<uint32_t> items_, slotOf_, leafOf_;  // slot in items_, leaf: by item; kNone: left out
    std::vector<base::Box> boxes_;                   // parallel to items_
    std::vector<uint8_t> pending_;                   // touched children, by node; 0 between refits
};

/// Surface area of a box, m²; 0 when it is empty.
double surfaceArea(const base::Box& box);

}  // namespace dapple::gpuscene
