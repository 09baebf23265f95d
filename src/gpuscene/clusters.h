#pragma once

#include "gpuscene/items.h"

namespace dapple::gpuscene {

struct GpuPrototype;

/// Divides a prototype in space: clusters of at most `triangles` triangles, or as few more as no plane tells apart, every
/// triangle in one of them, quads whole. Their meshes are pieces of the prototype's, with indices of their own, which are
/// appended to `indices` (bytes, multiples of 4): offsets count from the beginning of `indices` plus `offset`.
std::vector<Part> clusters(const scenegen::Prototype& prototype, const GpuPrototype& gpu, uint32_t index, uint32_t triangles, size_t offset, std::vector<uint8_t>& indices);

}  // namespace dapple::gpuscene
