#pragma once

#include "scenegen/terrain/height_field.h"

#include <filesystem>

namespace dapple::scenegen {

/// A height map as a field, its values times `vertical` as metres. North is the image's top row.
/// .png: 8 or 16 bits, grey or the first channel (0 … 65535; 8-bit values count 257 each); .exr: the first channel;
/// .npz (numpy): its first two-dimensional array of integers or floats. Throws UsageError with the file and the reason.
HeightField readHeights(const std::filesystem::path& file, double spacing, double vertical);

}  // namespace dapple::scenegen
