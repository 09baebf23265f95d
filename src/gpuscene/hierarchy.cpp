#include "gpuscene/hierarchy.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace dapple::gpuscene {
namespace {

constexpr size_t kParallelItems = 4096;  // a subtree of fewer is built by one thread

struct Item {
    base::Box box;
    uint32_t triangles, index;
};

/// Twice the centre: no rounding where lo and hi are of one magnitude, and no need to halve.
float position(const base::Box& box, int axis) { return box.lo[axis] + box.hi[axis]; }

struct Bin {
    base::Box box;
    uint64_t triangles = 0;
    uint32_t count = 0;
    /// What the heuristic charges for it: area · triangles.
    double cost() const {
        const glm::vec3 size = box.size();
        return 2 * double(size.x * size.y + size.y * size.z + size.z * size.x) * double(triangles);
    }
    void add(const Bin& other) {
        box.lo = glm::min(box.lo, other.box.lo);  // an empty one changes nothing
        box.hi = glm::max(box.hi, other.box.hi);
        triangles += other.triangles;
        count += other.count;
    }
};

/// As many as tell a few items apart: half of all nodes hold less than three.
size_t binsFor(size_t items) { return items < 8 ? 4 : items < 64 ? 8 : 16; }

/// Of an axis: which bin an item falls into.
struct Binning {
    Binning(const base::Box& centres, int along, size_t bins) : axis(along), lo(centres.lo[along]), last(bins - 1) {
        const float extent = centres.hi[along] - lo;
        scale = extent > 0 ? float(bins) / extent : 0;
        if (!std::isfinite(scale)) scale = 0;  // denormal extent
    }
    size_t of(const Item& item) const { return std::min(size_t((position(item.box, axis) - lo) * scale), last); }
    int axis;
    float lo, scale;
    size_t last;
};

struct Split {
    int axis = -1;  // none
    size_t bin = 0; // the first on the right
    double cost = std::numeric_limits<double>::infinity();  // area · triangles of both sides
};

/// Builds into slots that depend on nothing but the items: a subtree over n items takes at most 2n − 1 of them.
class Builder {
public:
    Builder(std::vector<Item>& items, const Hierarchy::Settings& settings) : settings_(settings), items_(items), slots_(2 * items.size() - 1) { build(0, Hierarchy::kNone, 0, items_.size()); }

    /// The nodes without the unused slots.
    std::vector<Hierarchy::Node> compact() const {
        std::vector<uint32_t> moved(slots_.size());
        uint32_t used = 0;
        for (size_t i = 0; i < slots_.size(); ++i) {
            moved[i] = used;
            used += slots_[i].itemCount > 0;
        }
        std::vector<Hierarchy::Node> nodes;
        nodes.reserve(used);
        for (const Hierarchy::Node& slot : slots_) {
            if (slot.itemCount == 0) continue;
            nodes.push_back(slot);
            if (slot.parent != Hierarchy::kNone) nodes.back().parent = moved[slot.parent];
            if (slot.right != Hierarchy::kNone) nodes.back().right = moved[slot.right];
        }
        return nodes;
    }

private:
    void build(size_t slot, uint32_t parent, size_t begin, size_t end) {
        Hierarchy::Node& node = slots_[slot];
        base::Box centres;
        for (size_t i = begin; i < end; ++i) {
            const base::Box& box = items_[i].box;
            node.box.lo = glm::min(node.box.lo, box.lo);
            node.box.hi = glm::max(node.box.hi, box.hi);
            node.triangles += items_[i].triangles;
            centres.extend(box.lo + box.hi);
        }
        node.parent = parent;
        node.firstItem = uint32_t(begin);
        node.itemCount = uint32_t(end - begin);
        if (end - begin == 1 || node.triangles <= settings_.leafTriangles) return;
        const size_t bins = binsFor(end - begin);
        const Split split = bins == 4 ? bestSplit<4>(begin, end, centres) : bins == 8 ? bestSplit<8>(begin, end, centres) : bestSplit<16>(begin, end, centres);
        if (split.axis < 0) return;
        const double area = surfaceArea(node.box);
        // Points on a line have no area that could tell what a split is worth.
        if (area > 0 && split.cost + settings_.visitTriangles * area >= area * double(node.triangles)) return;
        const Binning binning(centres, split.axis, bins);
        const auto middle = std::partition(items_.begin() + ptrdiff_t(begin), items_.begin() + ptrdiff_t(end), [&](const Item& item) { return binning.of(item) < split.bin; });
        const auto at = size_t(middle - items_.begin());
        const size_t right = slot + 2 * (at - begin);
        node.right = uint32_t(right);
        const auto goLeft = [&] { build(slot + 1, uint32_t(slot), begin, at); };
        const auto goRight = [&] { build(right, uint32_t(slot), at, end); };
        if (end - begin >= kParallelItems) {
            tbb::parallel_invoke(goLeft, goRight);
        } else {
            goLeft();
            goRight();
        }
    }

    template <size_t kBins>
    Split bestSplit(size_t begin, size_t end, const base::Box& centres) const {
        std::array<std::array<Bin, kBins>, 3> bins;
        const std::array<Binning, 3> binnings{Binning(centres, 0, kBins), Binning(centres, 1, kBins), Binning(centres, 2, kBins)};
        for (size_t i = begin; i < end; ++i)
            for (const Binning& binning : binnings) {
                if (binning.scale == 0) continue;
                Bin& bin = bins[size_t(binning.axis)][binning.of(items_[i])];
                bin.box.lo = glm::min(bin.box.lo, items_[i].box.lo);
                bin.box.hi = glm::max(bin.box.hi, items_[i].box.hi);
                bin.triangles += items_[i].triangles;
                ++bin.count;
            }
        Split best;
        for (const Binning& binning : binnings) {
            if (binning.scale == 0) continue;
            const auto& of = bins[size_t(binning.axis)];
            std::array<Bin, kBins> fromRight = of;
            for (size_t b = kBins - 1; b-- > 0;) fromRight[b].add(fromRight[b + 1]);
            Bin left;
            for (size_t b = 1; b < kBins; ++b) {
                left.add(of[b - 1]);
                if (left.count == 0 || fromRight[b].count == 0) continue;
                const double cost = left.cost() + fromRight[b].cost();
                if (cost < best.cost) best = {binning.axis, b, cost};
            }
        }
        return best;
    }

    const Hierarchy::Settings settings_;
    std::vector<Item>& items_;
    std::vector<Hierarchy::Node> slots_;
};

}  // namespace

double surfaceArea(const base::Box& box) {
    if (box.empty()) return 0;
    const glm::dvec3 size = glm::dvec3(box.hi) - glm::dvec3(box.lo);
    return 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

Hierarchy::Hierarchy(std::span<const base::Box> boxes, std::span<const uint32_t> triangles, const Settings& settings)
    : slotOf_(boxes.size(), kNone), leafOf_(boxes.size(), kNone) {
    if (boxes.size() != triangles.size()) throw std::invalid_argument("Hierarchy: a box for each item's triangles");
    std::vector<Item> items;
    items.reserve(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].empty()) continue;
        if (!base::allFinite(boxes[i].lo) || !base::allFinite(boxes[i].hi)) throw std::invalid_argument("Hierarchy: a box is not finite");
        items.push_back({boxes[i], triangles[i], uint32_t(i)});
    }
    if (items.empty()) return;
    nodes_ = Builder(items, settings).compact();
    pending_.resize(nodes_.size());
    items_.reserve(items.size());
    boxes_.reserve(items.size());
    for (const Item& item : items) {
        slotOf_[item.index] = uint32_t(items_.size());
        items_.push_back(item.index);
        boxes_.push_back(item.box);
    }
    for (uint32_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].leaf())
            for (const uint32_t item : this->items(n)) leafOf_[item] = n;
}

void Hierarchy::refit(std::span<const uint32_t> items, std::span<const base::Box> boxes) {
    if (items.size() != boxes.size()) throw std::invalid_argument("Hierarchy: a box for each item that moved");
    std::vector<uint32_t> leaves;
    leaves.reserve(items.size());
    for (size_t i = 0; i < items.size(); ++i) {
        if (slotOf_[items[i]] == kNone) continue;
        boxes_[slotOf_[items[i]]] = boxes[i];
        leaves.push_back(leafOf_[items[i]]);
    }
    // In the order of memory, each once.
    std::sort(leaves.begin(), leaves.end());
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    // A node waits for as many children as are touched: the last one to arrive goes on upwards.
    for (const uint32_t leaf : leaves)
        for (uint32_t n = nodes_[leaf].parent; n != kNone && pending_[n]++ == 0;) n = nodes_[n].parent;
    for (const uint32_t leaf : leaves) {
        Node& node = nodes_[leaf];
        node.box = {};
        for (uint32_t i = 0; i < node.itemCount; ++i) node.box.extend(boxes_[node.firstItem + i]);
        for (uint32_t n = node.parent; n != kNone && --pending_[n] == 0; n = nodes_[n].parent) {
            nodes_[n].box = nodes_[n + 1].box;
            nodes_[n].box.extend(nodes_[nodes_[n].right].box);
        }
    }
}

void Hierarchy::tightBounds(uint32_t node, int depth, double areaRatio, std::vector<uint32_t>& into) const {
    const double limit = areaRatio * surfaceArea(nodes_[node].box);
    double area = surfaceArea(nodes_[node].box);
    std::vector<uint32_t> level{node}, next;
    for (; !level.empty(); --depth) {
        next.clear();
        for (const uint32_t n : level) {
            const Node& parent = nodes_[n];
            if (parent.box.empty()) continue;
            const double opened = depth <= 0 || parent.leaf() ? std::numeric_limits<double>::infinity() : area - surfaceArea(parent.box) + surfaceArea(nodes_[n + 1].box) + surfaceArea(nodes_[parent.right].box);
            if (opened > limit) {
                into.push_back(n);
                continue;
            }
            area = opened;
            for (const uint32_t child : {n + 1, parent.right}) next.push_back(child);
        }
        level.swap(next);
    }
}

}  // namespace dapple::gpuscene
