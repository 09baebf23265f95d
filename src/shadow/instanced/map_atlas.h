#pragma once

#include "gl/objects.h"
#include "shadow/instanced/square_allocator.h"

#include <set>
#include <span>

namespace dapple::shadow {

/// Square depth maps of several sizes in the pages of one array texture. A page is as large as the largest map, or larger
/// where GL has too few layers for that.
class MapAtlas {
public:
    using Place = SquareAllocator::Place;

    /// Gives every map a square of the side that it is to have, all equal or powers of two. Maps whose side stays keep their
    /// depths, though not their place; the others' indices are added to `due`, and what was in their squares is lost.
    /// Throws base::Error(failed) when this GL has no texture for so many texels, or no memory.
    void arrange(std::span<const int> sides, std::set<int>& due);
    /// For rendering into a map's square and nowhere else: framebuffer, viewport, scissor.
    void target(int map) const;

    const std::vector<Place>& places() const { return places_; }  ///< by map
    const gl::Texture& texture() const { return texture_; }       ///< D32F array of pages
    size_t texelsInUse() const;

private:
    void repack(std::span<const int> sides, std::set<int>& due);

    SquareAllocator squares_;
    std::vector<Place> places_;
    gl::Texture texture_;
    std::vector<gl::Framebuffer> targets_;  ///< by page
};

/// Side and number of the pages for maps of these sides.
struct Pages {
    int side = 0, count = 0;
    size_t texels() const { return size_t(side) * size_t(side) * size_t(count); }
};
/// Nothing beyond the limits.
std::optional<Pages> pagesWithin(std::span<const int> sides, int maxSide, int maxPages);
/// Throws base::Error(failed) beyond the limits.
Pages pagesFor(std::span<const int> sides, int maxSide, int maxPages);

}  // namespace dapple::shadow
