#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dapple::scenegen {

/// Reorders triangles for a small vertex cache, then renumbers vertices by first use; the result maps new number → old
/// one. Equal input gives equal output; every vertex below `vertices` must be used.
std::vector<uint32_t> orderForVertexCache(std::vector<uint32_t>& indices, size_t vertices);

}  // namespace dapple::scenegen
