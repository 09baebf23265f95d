#pragma once

#include <optional>
#include <set>
#include <tuple>
#include <vector>

namespace dapple::shadow {

/// Squares in the pages of an atlas: a buddy allocator whose blocks split into four (Knowlton 1965, "A fast storage
/// allocator", in two dimensions). Sides are the page's over a power of two. Squares that are asked for largest first leave
/// no gap.
class SquareAllocator {
public:
    struct Place {
        int page = 0, x = 0, y = 0, side = 0;  ///< texels
        bool operator==(const Place&) const = default;
    };
    SquareAllocator() = default;
    SquareAllocator(int pageSide, int pages);
    /// Nothing when no square of that side is free, or none can be.
    std::optional<Place> allocate(int side);
    void release(const Place& place);
    int pageSide() const { return pageSide_; }
    int pages() const { return pages_; }

private:
    using Corner = std::tuple<int, int, int>;  ///< page, y, x
    int pageSide_ = 0, pages_ = 0;
    std::vector<std::set<Corner>> free_;       ///< by level: squares of side pageSide / 2^level
};

}  // namespace dapple::shadow
