#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// Axis-aligned box about the origin with flat faces; `size` in metres.
Mesh boxMesh(const glm::vec3& size);

/// Sphere about the origin: an icosahedron divided `refine` times, 20·4^refine triangles, vertices on the sphere.
Mesh sphereMesh(float radius, int refine);

}  // namespace dapple::scenegen
