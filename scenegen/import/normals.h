#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

inline constexpr double kCreaseDegrees = 45;  ///< where a file has no normals; AC3D's default crease angle

/// Replaces the mesh's normals by area-weighted means over the faces around each position, leaving out those
/// that meet at more than `creaseDegrees`; vertices on a crease are split. Degenerate faces count for nothing.
void generateNormals(Mesh& mesh, double creaseDegrees);

}  // namespace dapple::scenegen
