#pragma once

#include "scenegen/import/gltf_accessors.h"
#include "scenegen/import/gltf_materials.h"
#include "scenegen/import/scene_builder.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dapple::scenegen {

/// The joints of a skinned node, as they stand in the file's world.
struct GltfPose {
    std::vector<glm::dmat4> worldFromBind;  ///< per joint: its world transform · its inverse bind matrix
};

/// The meshes of a document as those of a scene: triangles of any mode, morphed, skinned, with normals and texture coordinates.
class GltfMeshes {
public:
    GltfMeshes(GltfDocument& document, const GltfMaterials& materials, SceneBuilder& builder);

    /// Indices into FileScene::meshes for a node's mesh under its morph weights; one per primitive that has triangles.
    const std::vector<uint32_t>& of(size_t mesh, const std::vector<double>& weights);
    /// The same in the file's world, bent by the joints.
    std::vector<uint32_t> skinned(size_t mesh, const std::vector<double>& weights, const GltfPose& pose);

    /// A node's morph weights, or its mesh's.
    std::vector<double> weightsOf(const Json& node, size_t mesh) const;

private:
    std::vector<uint32_t> read(size_t mesh, const std::vector<double>& weights, const GltfPose* pose);
    std::optional<Mesh> readPrimitive(const Json& primitive, const std::string& name, const std::vector<double>& weights, const GltfPose* pose);
    std::vector<glm::dmat4> bonesOf(const GltfPrimitive& source, size_t vertices, const std::string& name, const GltfPose& pose) const;
    template <class Vec>
    void morph(std::vector<Vec>& values, const Json& primitive, const char* attribute, const std::vector<double>& weights);

    GltfDocument& document_;
    const GltfMaterials& materials_;
    SceneBuilder& builder_;
    std::map<std::pair<size_t, std::vector<double>>, std::vector<uint32_t>> known_;
};

}  // namespace dapple::scenegen
