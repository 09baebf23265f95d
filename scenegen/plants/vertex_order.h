#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dapple::scenegen {

/// Reorders triangles for a FIFO vertex cache of 16 entries, greedily: the next triangle is the one with the
/// fewest misses among those that touch a cached vertex. Vertices are then renumbered by first use; the result
/// maps new number → old one. Equal input gives equal output; every vertex below `vertices` must be used.
std::vector<uint32_t> orderForVertexCache(std::vector<uint32_t>& indices, size_t vertices);

}  // namespace dapple::scenegen
