#pragma once

#include "scenegen/scene.h"

#include <span>
#include <string>

namespace dapple::scenegen::city {

/// Adds a single-sided material; the result is its index.
uint32_t addMaterial(Scene& scene, const std::string& name, const glm::vec3& albedo, float specular = 0, float shininess = 16);

/// Adds a prototype of the meshes that are not empty, whose `material` is set; whether it is closed is tested.
uint32_t addPrototype(Scene& scene, const std::string& name, std::vector<Mesh> meshes, bool castsShadow = true);

/// Adds an instance whose local x points along `direction` (unit).
void addInstance(Scene& scene, uint32_t prototype, const glm::dvec3& position, const glm::dvec2& direction, double scale = 1);

/// Appends the triangles of one mesh to another.
void append(Mesh& to, const Mesh& mesh);

/// `mesh` with that material.
Mesh of(Mesh mesh, uint32_t material);

}  // namespace dapple::scenegen::city
