#pragma once

#include "bench/picture.h"

namespace dapple::bench {

/// The .json beside a picture: camera, suns, light matrices, passes, and what the numbers mean. With it and the .exr of
/// depth, normals and map somebody can look every pixel up again.
std::string sidecar(SharedFrame& shared, const shadow::Renderer& renderer, const PointSpec& spec, const PictureKind& kind);

}  // namespace dapple::bench
