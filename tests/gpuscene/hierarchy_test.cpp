#include "gpuscene/hierarchy.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <set>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace dapple::gpuscene {
namespace {

constexpr Hierarchy::Settings kSmallLeaves{2000, 24};

struct Items {
    std::vector<base::Box> boxes;
    std::vector<uint32_t> triangles;
    Hierarchy build(const Hierarchy::Settings& settings = kSmallLeaves) const { return Hierarchy(boxes, triangles, settings); }
};

base::Box boxAt(const glm::vec3& at, float size) { return {at - size, at + size}; }

Items strewn(size_t count, uint64_t seed) {
    Items items;
    base::Random random(seed, 0, 0);
    for (size_t i = 0; i < count; ++i) {
        const glm::vec3 at(random.next(-500, 500), random.next(-500, 500), random.next(0, 30));
        items.boxes.push_back(boxAt(at, random.next(0, 1) < 0.02f ? 80.0f : random.next(0.5f, 5)));
        items.triangles.push_back(uint32_t(random.next(1, 3000)));
    }
    return items;
}

bool same(const base::Box& a, const base::Box& b) { return a.lo == b.lo && a.hi == b.hi; }

/// Everything that the header promises of a hierarchy over these items.
void expectSound(const Hierarchy& hierarchy, const Items& items, const Hierarchy::Settings& settings = kSmallLeaves) {
    const auto nodes = hierarchy.nodes();
    std::vector<int> seen(items.boxes.size());
    for (const uint32_t item : hierarchy.items()) ++seen[item];
    for (size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], items.boxes[i].empty() ? 0 : 1) << i;
    size_t inLeaves = 0;
    std::vector<uint32_t> end(nodes.size());  // past the subtree
    for (uint32_t n = uint32_t(nodes.size()); n-- > 0;) {
        const Hierarchy::Node& node = nodes[n];
        ASSERT_GE(node.itemCount, 1u);
        base::Box box;
        uint64_t triangles = 0;
        for (const uint32_t item : hierarchy.items(n)) {
            box.extend(items.boxes[item]);
            triangles += items.triangles[item];
        }
        ASSERT_TRUE(same(box, node.box)) << n;
        ASSERT_EQ(triangles, node.triangles);
        ASSERT_EQ(node.parent == Hierarchy::kNone, n == 0);
        end[n] = n + 1;
        if (node.leaf()) {
            inLeaves += node.itemCount;
            continue;
        }
        ASSERT_GT(triangles, settings.leafTriangles);
        const Hierarchy::Node &left = nodes[n + 1], &right = nodes[node.right];
        ASSERT_EQ(left.parent, n);
        ASSERT_EQ(right.parent, n);
        ASSERT_EQ(end[n + 1], node.right);
        end[n] = end[node.right];
        ASSERT_EQ(left.firstItem, node.firstItem);
        ASSERT_EQ(right.firstItem, node.firstItem + left.itemCount);
        ASSERT_EQ(left.itemCount + right.itemCount, node.itemCount);
    }
    ASSERT_EQ(inLeaves, hierarchy.items().size());
    if (!nodes.empty()) { ASSERT_EQ(end[0], nodes.size()); }
}

TEST(Hierarchy, EveryItemOnceAndEveryBoxTight) {
    for (const size_t count : {1, 2, 3, 17, 20'000}) {
        const Items items = strewn(count, count);
        const Hierarchy hierarchy = items.build();
        expectSound(hierarchy, items);
        if (count == 20'000) { EXPECT_GT(hierarchy.nodes().size(), 10'000u); }
    }
}

/// Expected cost of a random ray or query (surface-area heuristic), by the definition.
double cost(const Hierarchy& hierarchy, const Hierarchy::Settings& settings) {
    double sum = 0;
    for (const Hierarchy::Node& node : hierarchy.nodes()) sum += surfaceArea(node.box) * (node.leaf() ? double(node.triangles) : settings.visitTriangles);
    return sum / surfaceArea(hierarchy.nodes()[0].box);
}

// Halving the items along the longest axis: what anybody would do without a heuristic.
TEST(Hierarchy, IsBetterThanAMedianSplit) {
    const Items items = strewn(5000, 3);
    const Hierarchy::Settings settings{1, 24};
    struct Median {
        const Items& items;
        const Hierarchy::Settings& settings;
        double area(std::span<uint32_t> range) const {
            base::Box box, centres;
            uint64_t triangles = 0;
            for (const uint32_t i : range) {
                box.extend(items.boxes[i]);
                centres.extend(items.boxes[i].centre());
                triangles += items.triangles[i];
            }
            if (range.size() == 1) return surfaceArea(box) * double(triangles);
            int axis = 0;
            for (int k = 1; k < 3; ++k)
                if (centres.size()[k] > centres.size()[axis]) axis = k;
            const size_t half = range.size() / 2;
            std::nth_element(range.begin(), range.begin() + ptrdiff_t(half), range.end(), [&](uint32_t a, uint32_t b) { return items.boxes[a].centre()[axis] < items.boxes[b].centre()[axis]; });
            return settings.visitTriangles * surfaceArea(box) + area(range.first(half)) + area(range.subspan(half));
        }
    };
    std::vector<uint32_t> order(items.boxes.size());
    for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    const Hierarchy hierarchy = items.build(settings);
    const Median median{items, settings};
    EXPECT_LT(cost(hierarchy, settings), median.area(order) / surfaceArea(hierarchy.nodes()[0].box));
}

TEST(Hierarchy, DegenerateInputs) {
    EXPECT_TRUE(Hierarchy({}, {}, {}).nodes().empty());
    Items onlyEmpty{{base::Box{}, base::Box{}}, {5, 5}};
    EXPECT_TRUE(onlyEmpty.build().nodes().empty());
    onlyEmpty.build().refit({}, {});

    Items gaps = strewn(1000, 4);
    for (size_t i = 0; i < 1000; i += 3) gaps.boxes[i] = {};
    expectSound(gaps.build(), gaps);

    // At one point: the same boxes (nothing can tell them apart), and nested ones; with and without extent.
    for (const float size : {0.0f, 2.0f})
        for (const bool nested : {false, true}) {
            Items pile;
            for (uint32_t i = 0; i < 100'000; ++i) {
                pile.boxes.push_back(boxAt({7, 8, 9}, nested ? size * float(i) : size));
                pile.triangles.push_back(100);
            }
            expectSound(pile.build(), pile);
        }
    // On a line, on a plane, and two piles that one bin would swallow.
    Items line, plane, piles;
    for (uint32_t i = 0; i < 5000; ++i) {
        line.boxes.push_back(boxAt({float(i), 0, 0}, 0));
        plane.boxes.push_back(boxAt({float(i % 70), float(i / 70), 0}, 0));
        piles.boxes.push_back(boxAt({i % 2 ? 1e6f : 1.0f, 0, 0}, i < 10 ? 1e6f : 0.5f));
    }
    for (Items* items : {&line, &plane, &piles}) {
        items->triangles.assign(5000, 1500);
        expectSound(items->build(), *items);
    }
    EXPECT_EQ(plane.build().nodes().size(), 9999u);  // a leaf each

    EXPECT_THROW(Hierarchy(line.boxes, std::vector<uint32_t>(3), {}), std::invalid_argument);
    line.boxes[7].hi.y = std::numeric_limits<float>::infinity();
    EXPECT_THROW(line.build(), std::invalid_argument);
}

TEST(Hierarchy, TheSameWhateverTheThreads) {
    const Items items = strewn(100'000, 5);
    std::vector<Hierarchy> built;
    for (const size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        built.push_back(items.build());
    }
    for (const Hierarchy& other : built) {
        ASSERT_EQ(other.nodes().size(), built[0].nodes().size());
        EXPECT_EQ(std::memcmp(other.nodes().data(), built[0].nodes().data(), other.nodes().size_bytes()), 0);
        EXPECT_TRUE(std::equal(other.items().begin(), other.items().end(), built[0].items().begin()));
    }
}

TEST(Hierarchy, RefitEqualsTheBoxesOfWhatMoved) {
    Items items = strewn(20'000, 6);
    items.boxes[5] = {};  // left out, and stays so
    Hierarchy hierarchy = items.build();
    base::Random random(7, 0, 0);
    for (int frame = 0; frame < 20; ++frame) {
        std::vector<uint32_t> moved;
        std::vector<base::Box> boxes;
        for (uint32_t i = 0; i < items.boxes.size(); ++i) {
            if (random.next() > (frame == 0 ? 1 : 0.01f)) continue;
            moved.push_back(i);
            boxes.push_back(boxAt({random.next(-900, 900), random.next(-900, 900), random.next(0, 90)}, random.next(0, 9)));
            if (i != 5) items.boxes[i] = boxes.back();
        }
        hierarchy.refit(moved, boxes);
        expectSound(hierarchy, items);
    }
    const uint32_t one[] = {0};
    EXPECT_THROW(hierarchy.refit(one, {}), std::invalid_argument);
}

TEST(Hierarchy, TightBoundsEncloseEverythingWithinTheirArea) {
    const Items items = strewn(5000, 8);
    const Hierarchy hierarchy = items.build({1, 24});
    const auto nodes = hierarchy.nodes();
    size_t opened = 0;
    for (uint32_t n = 0; n < nodes.size(); ++n)
        for (const int depth : {0, 1, 3}) {
            std::vector<uint32_t> bounds;
            hierarchy.tightBounds(n, depth, 1.4, bounds);
            double area = 0;
            size_t held = 0;  // disjoint subtrees of n that hold all of its items
            for (const uint32_t b : bounds) {
                area += surfaceArea(nodes[b].box);
                held += nodes[b].itemCount;
                int up = 0;
                for (uint32_t a = b; a != n; a = nodes[a].parent) ++up;
                ASSERT_LE(up, depth);
            }
            ASSERT_EQ(held, nodes[n].itemCount);
            ASSERT_LE(area, 1.4 * surfaceArea(nodes[n].box) * (1 + 1e-9));
            if (depth == 0) { ASSERT_EQ(bounds, std::vector<uint32_t>{n}); }
            opened += bounds.size() > 1;
        }
    EXPECT_GT(opened, 500u);
}

TEST(Hierarchy, SelectsWhatALinearLoopKeeps) {
    const Items items = strewn(5000, 13);
    base::Random random(14, 0, 0);
    for (const uint64_t leaf : {1, 10'000}) {
        const Hierarchy hierarchy = items.build({leaf, 24});
        for (int k = 0; k < 50; ++k) {
            const glm::vec3 normal(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1));
            const float limit = random.next(-1500, 1500);
            size_t asked = 0;
            const auto keep = [&](const base::Box& box) {
                ++asked;
                return glm::dot(normal, glm::mix(box.lo, box.hi, glm::greaterThan(normal, glm::vec3(0)))) >= limit;
            };
            std::vector<uint32_t> selected, expected, nodes;
            hierarchy.selectItems(keep, selected);
            EXPECT_LE(asked, 3 * selected.size() + 2000);
            for (const uint32_t item : hierarchy.items())
                if (keep(items.boxes[item])) expected.push_back(item);
            ASSERT_EQ(selected, expected);
            // Groups hold all of them, each once, and are as small as asked for unless they are leaves.
            hierarchy.select(keep, 20, nodes);
            std::vector<uint32_t> grouped;
            for (const uint32_t n : nodes) {
                EXPECT_TRUE(hierarchy.nodes()[n].itemCount <= 20 || hierarchy.nodes()[n].leaf());
                for (const uint32_t item : hierarchy.items(n)) grouped.push_back(item);
            }
            EXPECT_EQ(std::set<uint32_t>(grouped.begin(), grouped.end()).size(), grouped.size());
            std::erase_if(grouped, [&](uint32_t item) { return !keep(items.boxes[item]); });
            EXPECT_EQ(grouped, expected);
        }
    }
    std::vector<uint32_t> none;
    Hierarchy().selectItems([](const base::Box&) { return true; }, none);
    EXPECT_TRUE(none.empty());
}

TEST(Hierarchy, SupportIsThatOfAllBoxes) {
    const Items items = strewn(3000, 11);
    const Hierarchy hierarchy = items.build();
    base::Random random(12, 0, 0);
    for (int k = 0; k < 50; ++k) {
        const glm::dvec3 direction(random.next(-1, 1), random.next(-1, 1), k == 0 ? 0 : random.next(-1, 1));
        double most = -1e300;
        for (const base::Box& box : items.boxes)
            for (int corner = 0; corner < 8; ++corner) most = std::max(most, glm::dot(direction, glm::dvec3(box.corner(corner))));
        EXPECT_NEAR(hierarchy.support(direction), most, 1e-9);
    }
    EXPECT_EQ(Hierarchy().support({1, 0, 0}), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace dapple::gpuscene
