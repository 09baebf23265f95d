#include "scenegen/import/gltf_draco.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wshadow"
#include <draco/compression/decode.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <new>

// Khronos, "KHR_draco_mesh_compression".
namespace dapple::scenegen {
namespace {

/// Largest value of the integers of an accessor; 1 for floats.
float wholeOf(size_t componentType) {
    switch (componentType) {
        case 5120: return 127;
        case 5121: return 255;
        case 5122: return 32767;
        case 5123: return 65535;
        default: return 1;
    }
}

const Json& dracoOf(const Json& primitive) { return extension(primitive, "KHR_draco_mesh_compression"); }

}  // namespace

DracoMesh::DracoMesh(GltfDocument& document, const Json& primitive) : document_(document), primitive_(primitive) {
    if (valueOf(primitive, "mode", 4) != 4) document.fail("asks for Draco data that are no list of triangles, which is not read");
    const std::span<const uint8_t> bytes = document.view(document.index(dracoOf(primitive), "bufferView"));
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::string why;
    try {
        auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
        why = decoded.status().error_msg_string();
        if (decoded.ok()) mesh_ = std::move(decoded).value();
    } catch (const std::bad_alloc&) {
        why = "they ask for more memory than there is";
    }
    if (!mesh_) document.fail("is damaged: its Draco data cannot be decoded: " + why);
    document.expand(size_t(mesh_->num_points()) * 32 + size_t(mesh_->num_faces()) * 12);
}

DracoMesh::~DracoMesh() = default;

bool DracoMesh::holds(const std::string& attribute) const { return !member(member(dracoOf(primitive_), "attributes"), attribute.c_str()).is_null(); }

std::vector<float> DracoMesh::floats(const std::string& name, size_t components) const {
    const draco::PointAttribute* values = mesh_->GetAttributeByUniqueId(uint32_t(document_.index(member(dracoOf(primitive_), "attributes"), name.c_str())));
    if (!values) document_.fail(fmt::format("is damaged: its Draco data lack {}", name));
    const Json& accessor = document_.item("accessors", document_.index(member(primitive_, "attributes"), name.c_str()));
    const bool divides = valueOf(accessor, "normalized", false) && !values->normalized();
    const float scale = divides ? 1 / wholeOf(document_.index(accessor, "componentType")) : 1.0f;
    std::vector<float> out(size_t(mesh_->num_points()) * components);
    for (draco::PointIndex i(0); i < mesh_->num_points(); ++i) {
        float* v = &out[i.value() * components];
        if (!values->ConvertValue<float>(values->mapped_index(i), int8_t(components), v)) document_.fail(fmt::format("is damaged: its Draco data hold no {}", name));
        for (size_t k = 0; k < components; ++k) v[k] *= scale;
    }
    return out;
}

std::vector<uint32_t> DracoMesh::indices() const {
    std::vector<uint32_t> out;
    for (draco::FaceIndex f(0); f < mesh_->num_faces(); ++f)
        for (size_t k = 0; k < 3; ++k) out.push_back(mesh_->face(f)[k].value());
    return out;
}

}  // namespace dapple::scenegen
