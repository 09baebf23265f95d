#include "shadow/instanced/square_allocator.h"

namespace dapple::shadow {

SquareAllocator::SquareAllocator(int pageSide, int pages) : pageSide_(pageSide), pages_(pages), free_(1) {
    for (int page = 0; page < pages; ++page) free_[0].insert({page, 0, 0});
    for (int side = pageSide; side % 2 == 0; side /= 2) free_.emplace_back();
}

std::optional<SquareAllocator::Place> SquareAllocator::allocate(int side) {
    size_t wanted = 0;
    while (wanted < free_.size() && pageSide_ >> wanted != side) ++wanted;
    if (wanted == free_.size()) return std::nullopt;
    size_t level = wanted + 1;  // one too far: the smallest free square that is large enough is sought
    while (level > 0 && free_[level - 1].empty()) --level;
    if (level == 0) return std::nullopt;
    --level;
    const auto [page, y, x] = *free_[level].begin();
    free_[level].erase(free_[level].begin());
    for (; level < wanted; ++level) {
        const int half = pageSide_ >> (level + 1);
        free_[level + 1].insert({{page, y, x + half}, {page, y + half, x}, {page, y + half, x + half}});
    }
    return Place{page, x, y, side};
}

void SquareAllocator::release(const Place& place) {
    size_t level = 0;
    while (pageSide_ >> level != place.side) ++level;
    int x = place.x, y = place.y;
    for (; level > 0; --level) {
        // With its three buddies free, a square is the quarter of one that is.
        const int side = pageSide_ >> level, left = x / (2 * side) * 2 * side, top = y / (2 * side) * 2 * side;
        std::vector<Corner> buddies;
        for (const int dy : {0, side})
            for (const int dx : {0, side})
                if (left + dx != x || top + dy != y) buddies.emplace_back(place.page, top + dy, left + dx);
        for (const Corner& buddy : buddies)
            if (!free_[level].contains(buddy)) {
                free_[level].insert({place.page, y, x});
                return;
            }
        for (const Corner& buddy : buddies) free_[level].erase(buddy);
        x = left;
        y = top;
    }
    free_[0].insert({place.page, y, x});
}

}  // namespace dapple::shadow
