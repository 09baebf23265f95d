#include "scenegen/import/polygon_object.h"

#include "base/hash.h"
#include "scenegen/import/normals.h"
#include "scenegen/import/polygons.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>

namespace dapple::scenegen {
namespace {

constexpr double kFar = 1000;  ///< metres; beyond, float positions lose tenths of a millimetre

struct VertexHash {
    size_t operator()(const std::array<float, 8>& key) const {
        uint64_t h = 0;
        for (const float f : key) h = base::mix64(h ^ std::bit_cast<uint32_t>(f));
        return h;
    }
};

/// Vertices of a mesh, equal ones once.
class Vertices {
public:
    Vertices(Mesh& mesh, bool textured) : mesh_(mesh), textured_(textured) {}

    void add(const glm::vec3& p, const glm::vec3& n, const glm::vec2& uv) {
        const auto [it, isNew] =
            known_.emplace(std::array{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f, n.x, n.y, n.z, uv.x, uv.y},
                           uint32_t(mesh_.positions.size()));
        if (isNew) {
            mesh_.positions.push_back(p);
            mesh_.normals.push_back(n);
            if (textured_) mesh_.uvs.push_back(uv);
        }
        mesh_.indices.push_back(it->second);
    }

private:
    Mesh& mesh_;
    bool textured_;
    std::unordered_map<std::array<float, 8>, uint32_t, VertexHash> known_;
};

class Converter {
public:
    Converter(SceneBuilder& builder, const Budget& budget, const PolygonData& data, const std::string& name)
        : builder_(builder), budget_(budget), data_(data), name_(name) {}

    void add(const std::vector<ObjectPart>& parts) {
        base::DBox box;
        for (const ObjectPart& part : parts)
            for (const Faces::Corner& c : part.faces->corners) box.extend(position(c));
        if (box.empty()) return;
        const glm::dvec3 centre = box.centre();
        if (glm::length(builder_.position(centre)) > kFar) offset_ = glm::round(centre);
        std::vector<uint32_t> meshes;
        for (const ObjectPart& part : parts) {
            const bool hasUv =
                std::ranges::any_of(part.faces->corners, [&](const auto& c) { return has(data_.uvs, c.uv); });
            const int material = hasUv ? part.look.textured : part.look.flat;
            if (!hasUv && part.look.textured >= 0 && texture(part.look.textured) >= 0)
                builder_.scene.notes.add("textures are left out where faces have no texture coordinates", name_);
            if (material >= 0) meshes.push_back(builder_.addMesh(convert(*part.faces, part.look, uint32_t(material))));
        }
        if (meshes.empty()) return;
        builder_.addObject(builder_.child({}, name_, glm::translate(glm::dmat4(1), offset_)), std::move(meshes));
    }

private:
    template <class T>
    static bool has(const std::vector<T>& list, int64_t index) {
        return index >= 0 && index < int64_t(list.size());
    }

    int texture(int material) const { return builder_.scene.materials[size_t(material)].texture; }

    const glm::dvec3& position(const Faces::Corner& c) const {
        if (!has(data_.positions, c.position))
            builder_.fail(
                fmt::format("node '{}': a face names vertex {} of {}", name_, c.position + 1, data_.positions.size()));
        const glm::dvec3& p = data_.positions[size_t(c.position)];
        if (!base::allFinite(p))
            builder_.fail(fmt::format("node '{}': vertex {} is not finite", name_, c.position + 1));
        return p;
    }

    Mesh convert(const Faces& faces, const Look& look, uint32_t material) {
        Mesh mesh;
        mesh.material = material;
        const bool textured = texture(int(material)) >= 0;
        Vertices vertices(mesh, textured);
        const auto addVertex = [&](const Faces::Corner& c) {
            glm::dvec3 normal =
                has(data_.normals, c.normal) ? builder_.direction(data_.normals[size_t(c.normal)]) : glm::dvec3(0);
            if (!base::allFinite(glm::vec3(normal))) normal = glm::dvec3(0);
            const glm::dvec2 t =
                (has(data_.uvs, c.uv) ? data_.uvs[size_t(c.uv)] : glm::dvec2(0)) * look.scale + look.offset;
            const glm::vec2 uv(t.x, 1 - t.y);
            const bool hasUv = textured && base::allFinite(glm::vec3(uv, 0));
            vertices.add(glm::vec3(builder_.position(position(c) - offset_)), glm::vec3(normal),
                         hasUv ? uv : glm::vec2(0));
        };
        std::vector<glm::dvec3> polygon;
        std::vector<std::array<uint32_t, 3>> triangles;
        for (size_t at = 0, f = 0; f < faces.sizes.size(); at += faces.sizes[f++]) {
            if (f % 1024 == 0) budget_.time();
            polygon.clear(), triangles.clear();
            for (size_t k = 0; k < faces.sizes[f]; ++k) polygon.push_back(position(faces.corners[at + k]));
            if (!cutPolygon(polygon, triangles)) builder_.scene.notes.add(kCutAsFan, name_);
            for (const auto& t : triangles)
                for (const uint32_t k : t) addVertex(faces.corners[at + k]);
        }
        if (!std::ranges::any_of(faces.corners, [&](const auto& c) { return has(data_.normals, c.normal); }))
            generateNormals(mesh, kCreaseDegrees);
        return mesh;
    }

    SceneBuilder& builder_;
    const Budget& budget_;
    const PolygonData& data_;
    const std::string& name_;
    glm::dvec3 offset_{0};  ///< in the file's axes and units
};

}  // namespace

void addPolygonObject(SceneBuilder& builder, const Budget& budget, const PolygonData& data, const std::string& name,
                      const std::vector<ObjectPart>& parts) {
    Converter(builder, budget, data, name).add(parts);
}

}  // namespace dapple::scenegen
