#include "shadow/instanced/map_atlas.h"

#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace dapple::shadow {
namespace {

size_t area(std::span<const int> sides) {
    return std::accumulate(sides.begin(), sides.end(), size_t(0), [](size_t sum, int side) { return sum + size_t(side) * size_t(side); });
}

}  // namespace

std::optional<Pages> pagesWithin(std::span<const int> sides, int maxSide, int maxPages) {
    const int largest = sides.empty() ? 0 : *std::max_element(sides.begin(), sides.end());
    for (int side = largest; side > 0 && side <= maxSide; side *= 2) {
        const size_t page = size_t(side) * size_t(side), pages = (area(sides) + page - 1) / page;
        if (pages <= size_t(maxPages)) return Pages{side, int(pages)};
    }
    return largest == 0 ? std::optional(Pages{}) : std::nullopt;
}

Pages pagesFor(std::span<const int> sides, int maxSide, int maxPages) {
    if (const auto pages = pagesWithin(sides, maxSide, maxPages)) return *pages;
    throw base::Error(base::ExitCode::failed, fmt::format("{} maps of {} Mi texels are more than this GL's {} layers of {}² hold: fewer rotations or own maps, or smaller ones",
                                                          sides.size(), area(sides) >> 20, maxPages, maxSide));
}

size_t MapAtlas::texelsInUse() const {
    return std::accumulate(places_.begin(), places_.end(), size_t(0), [](size_t sum, const Place& p) { return sum + size_t(p.side) * size_t(p.side); });
}

void MapAtlas::arrange(std::span<const int> sides, std::set<int>& due) {
    GLint maxSide = 0, maxPages = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &maxSide);
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &maxPages);
    const Pages least = pagesFor(sides, maxSide, maxPages);
    bool fits = places_.size() == sides.size() && 2 * least.texels() > size_t(squares_.pageSide()) * size_t(squares_.pageSide()) * size_t(squares_.pages());
    std::vector<size_t> changed;
    for (size_t i = 0; fits && i < sides.size(); ++i)
        if (places_[i].side != sides[i]) changed.push_back(i);
    if (fits) {
        SquareAllocator squares = squares_;
        std::vector<Place> places = places_;
        for (const size_t i : changed) squares.release(places[i]);
        std::stable_sort(changed.begin(), changed.end(), [&](size_t a, size_t b) { return sides[a] > sides[b]; });
        for (const size_t i : changed) {
            const auto place = fits ? squares.allocate(sides[i]) : std::nullopt;
            fits = place.has_value();
            if (fits) places[i] = *place;
        }
        if (fits) {
            squares_ = std::move(squares);
            places_ = std::move(places);
            for (const size_t i : changed) due.insert(int(i));
            return;
        }
    }
    squares_ = SquareAllocator(least.side, least.count);
    repack(sides, due);
}

void MapAtlas::repack(std::span<const int> sides, std::set<int>& due) {
    const gl::Texture old = std::exchange(texture_, gl::Texture(GL_DEPTH_COMPONENT32F, squares_.pageSide(), squares_.pageSide(), squares_.pages()));
    targets_.clear();
    for (int page = 0; page < squares_.pages(); ++page) {
        targets_.push_back(gl::makeFramebuffer({}, &texture_, page));
        const float one = 1;
        glClearNamedFramebufferfv(targets_.back().name(), GL_DEPTH, 0, &one);  // gaps, too: nothing in a picture is undefined
    }
    std::vector<size_t> order(sides.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return sides[a] > sides[b]; });
    places_.resize(sides.size());
    for (const size_t i : order) {
        const Place from = std::exchange(places_[i], squares_.allocate(sides[i]).value());
        const Place& to = places_[i];
        if (from.side == to.side && !due.contains(int(i)))
            glCopyImageSubData(old.name(), GL_TEXTURE_2D_ARRAY, 0, from.x, from.y, from.page, texture_.name(), GL_TEXTURE_2D_ARRAY, 0, to.x, to.y, to.page, to.side, to.side, 1);
        else due.insert(int(i));
    }
}

void MapAtlas::target(int map) const {
    const Place& place = places_[size_t(map)];
    glBindFramebuffer(GL_FRAMEBUFFER, targets_[size_t(place.page)].name());
    glViewport(place.x, place.y, place.side, place.side);
    glEnable(GL_SCISSOR_TEST);
    glScissor(place.x, place.y, place.side, place.side);
}

}  // namespace dapple::shadow
