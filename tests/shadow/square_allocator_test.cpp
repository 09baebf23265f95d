// The atlas's allocator against a picture of every texel.
#include "shadow/instanced/square_allocator.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace dapple::shadow {
namespace {

using Place = SquareAllocator::Place;

/// How many squares cover each texel of all pages.
class Cover {
public:
    Cover(int side, int pages) : side_(side), count_(size_t(side) * size_t(side) * size_t(pages)) {}
    void add(const Place& p, int by) {
        for (int y = p.y; y < p.y + p.side; ++y)
            for (int x = p.x; x < p.x + p.side; ++x) count_.at((size_t(p.page) * size_t(side_) + size_t(y)) * size_t(side_) + size_t(x)) += by;
    }
    int most() const { return *std::ranges::max_element(count_); }
    long sum() const { return std::accumulate(count_.begin(), count_.end(), 0L); }

private:
    int side_;
    std::vector<int> count_;
};

TEST(SquareAllocator, NoTwoSquaresOverlapAndReleasedOnesComeBack) {
    SquareAllocator squares(256, 2);
    Cover cover(256, 2);
    std::vector<Place> held;
    base::Random random(7, 0, 0);
    size_t refused = 0;
    for (int i = 0; i < 2000; ++i) {
        if (held.empty() || random.next() < 0.55f) {
            const int side = 4 << int(random.next(0, 6.99f));
            const std::optional<Place> place = squares.allocate(side);
            refused += !place;
            if (!place) continue;
            ASSERT_EQ(place->side, side);
            ASSERT_EQ(place->x % side + place->y % side, 0);
            cover.add(*place, 1);
            held.push_back(*place);
        } else {
            const auto which = held.begin() + int(random.next(0, float(held.size())));
            cover.add(*which, -1);
            squares.release(*which);
            held.erase(which);
        }
        if (i % 50 == 0) {
            ASSERT_LE(cover.most(), 1) << i;
        }
    }
    EXPECT_GT(refused, 10u);  // it was full now and then
    for (const Place& place : held) squares.release(place);
    EXPECT_TRUE(squares.allocate(256) && squares.allocate(256));  // everything has grown together again
    EXPECT_FALSE(squares.allocate(4));
}

TEST(SquareAllocator, LargestFirstLeavesNoGap) {
    SquareAllocator squares(128, 1);
    Cover cover(128, 1);
    for (const auto& [side, count] : {std::pair{64, 3}, {32, 3}, {16, 3}, {8, 4}})
        for (int i = 0; i < count; ++i) cover.add(squares.allocate(side).value(), 1);
    EXPECT_EQ(cover.most(), 1);
    EXPECT_EQ(cover.sum(), 128 * 128);
    EXPECT_FALSE(squares.allocate(1));
}

TEST(SquareAllocator, OddPagesHoldTheirOwnSideAlone) {
    SquareAllocator squares(75, 2);
    EXPECT_FALSE(squares.allocate(37));
    EXPECT_EQ(squares.allocate(75).value(), (Place{0, 0, 0, 75}));
    EXPECT_EQ(squares.allocate(75).value(), (Place{1, 0, 0, 75}));
    EXPECT_FALSE(squares.allocate(75));
    EXPECT_FALSE(squares.allocate(150));
}

}  // namespace
}  // namespace dapple::shadow
