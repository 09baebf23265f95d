#pragma once

#include "base/config.h"
#include "scenegen/scene.h"

namespace dapple::scenegen {

/// Axis-aligned box about the origin with flat faces; `size` in metres.
Mesh boxMesh(const glm::vec3& size);

/// Sphere about the origin: an icosahedron divided `refine` times, 20·4^refine triangles, vertices on the sphere.
Mesh sphereMesh(float radius, int refine);

/// `count` triangles of no area, at random in a box about the origin: on two points, on one, and on a line.
Mesh sliverMesh(const glm::vec3& size, size_t count, uint64_t seed);

/// The key `albedo` of a table: three numbers from 0 to 1; `fallback` if missing. Throws UsageError.
glm::vec3 readAlbedo(base::ConfigTable& table, const glm::vec3& fallback);

/// The key `transmittance` of a table, 0 ≤ t < 1; 0 if missing. Throws UsageError.
float readTransmittance(base::ConfigTable& table);

/// A [[primitive]] of a recipe with its instances. Throws UsageError with file, line and key.
void addPrimitive(Scene& scene, base::ConfigTable& table, uint64_t seed);

}  // namespace dapple::scenegen
