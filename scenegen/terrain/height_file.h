#pragma once

#include "scenegen/import/notes.h"
#include "scenegen/terrain/height_field.h"

#include <filesystem>

namespace dapple::scenegen {

/// A height map as a field, its values times `vertical` as metres. North is the image's top row.
/// .png: 8 or 16 bits of grey (0 … 65535; 8-bit values count 257 each); .exr: one channel, or equal ones;
/// .npz (numpy): its first two-dimensional array of integers or floats. Samples that were not measured
/// (terrain/holes.h, and transparent ones) are filled from their surroundings and counted in `notes`. Throws UsageError with the file and
/// the reason: no such file, damaged, coloured, no height in it.
HeightField readHeights(const std::filesystem::path& file, double spacing, double vertical, Notes& notes);

}  // namespace dapple::scenegen
