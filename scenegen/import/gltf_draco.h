#pragma once

#include "scenegen/import/gltf_document.h"

#include <memory>
#include <string>
#include <vector>

namespace draco {
class Mesh;
}

namespace dapple::scenegen {

/// What KHR_draco_mesh_compression holds of a primitive, decoded.
class DracoMesh {
public:
    /// Throws UsageError when the data cannot be decoded.
    DracoMesh(GltfDocument& document, const Json& primitive);
    ~DracoMesh();

    bool holds(const std::string& attribute) const;
    /// `components` floats per vertex.
    std::vector<float> floats(const std::string& attribute, size_t components) const;
    std::vector<uint32_t> indices() const;

private:
    GltfDocument& document_;
    const Json& primitive_;
    std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace dapple::scenegen
