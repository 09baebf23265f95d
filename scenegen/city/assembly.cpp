#include "scenegen/city/assembly.h"

#include "scenegen/city/region.h"
#include "scenegen/lod/connectivity.h"

namespace dapple::scenegen::city {

uint32_t addMaterial(Scene& scene, const std::string& name, const glm::vec3& albedo, float specular, float shininess) {
    scene.materials.push_back({.name = name, .albedo = albedo, .specular = specular, .shininess = shininess, .doubleSided = false});
    return uint32_t(scene.materials.size() - 1);
}

uint32_t addPrototype(Scene& scene, const std::string& name, std::vector<Mesh> meshes, bool castsShadow) {
    std::erase_if(meshes, [](const Mesh& m) { return m.indices.empty(); });
    Prototype prototype{name, std::move(meshes), castsShadow, false};
    prototype.closed = isClosed(prototype);
    scene.prototypes.push_back(std::move(prototype));
    return uint32_t(scene.prototypes.size() - 1);
}

void addInstance(Scene& scene, uint32_t prototype, const glm::dvec3& position, const glm::dvec2& direction, double scale) {
    scene.instances.push_back({glm::vec3(position), float(scale), float(angleOf(direction)), prototype});
}

void append(Mesh& to, const Mesh& mesh) {
    const auto base = uint32_t(to.positions.size());
    to.positions.insert(to.positions.end(), mesh.positions.begin(), mesh.positions.end());
    to.normals.insert(to.normals.end(), mesh.normals.begin(), mesh.normals.end());
    for (const uint32_t i : mesh.indices) to.indices.push_back(base + i);
}

Mesh of(Mesh mesh, uint32_t material) {
    mesh.material = material;
    return mesh;
}

}  // namespace dapple::scenegen::city
