#include "scenegen/import/prototypes.h"

#include "scenegen/import/orientation.h"
#include "scenegen/lod/connectivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace dapple::scenegen {
namespace {

constexpr size_t kMaxStaticPrototypes = 64;  ///< as many draws are cheap; beyond, statics are merged
constexpr double kFarFromOwnSpace = 1000;    ///< metres; beyond, float positions lose tenths of a millimetre
constexpr double kSliver = 1e-7;             ///< height over longest edge below which float has no normal

/// L = scale · Rz(yaw) · baked.
struct Similarity {
    double scale = 1, yaw = 0;
    glm::dmat3 baked{1};
};

Similarity decompose(const glm::dmat3& linear) {
    Similarity result;
    const double scale = std::cbrt(std::abs(glm::determinant(linear)));
    if (scale > 1e-9) result.scale = scale;  // flattened to a plane: nothing to share, all is baked
    result.baked = linear / result.scale;
    // The first column that is not nearly vertical, so that tiny differences pick the same one.
    int column = 0;
    while (column < 2 && glm::length(glm::dvec2(result.baked[column])) < 0.1) ++column;
    const glm::dvec2 d(result.baked[column]);
    if (glm::length(d) < 1e-9) return result;
    result.yaw = std::atan2(d.y, d.x);
    const double c = std::cos(result.yaw), s = std::sin(result.yaw);
    if (result.yaw != 0) result.baked = glm::dmat3({c, -s, 0}, {s, c, 0}, {0, 0, 1}) * result.baked;
    if (std::abs(result.scale - 1) < 1e-6) result.scale = 1;  // float matrices of pure rotations
    return result;
}

/// Meshes, casting, and the baked matrix to five digits.
using ShapeKey = std::tuple<std::vector<uint32_t>, bool, std::array<long long, 9>>;

ShapeKey shapeKey(const FileScene::Object& object, const glm::dmat3& baked) {
    std::array<long long, 9> digits;
    for (int i = 0; i < 9; ++i) digits[size_t(i)] = std::llround(baked[i / 3][i % 3] * 1e5);
    return {object.meshes, object.castsShadow, digits};
}

struct Shape {
    std::string name;
    std::vector<uint32_t> meshes;
    bool castsShadow;
    glm::dmat3 baked;
    std::vector<Placed> places;
};

std::vector<Shape> findShapes(const FileScene& file) {
    std::vector<Shape> shapes;
    std::map<ShapeKey, size_t> known;
    for (const FileScene::Object& object : file.objects) {
        const Similarity s = decompose(glm::dmat3(object.worldFromObject));
        const auto [it, isNew] = known.emplace(shapeKey(object, s.baked), shapes.size());
        if (isNew) shapes.push_back({object.name, object.meshes, object.castsShadow, s.baked, {}});
        shapes[it->second].places.push_back({glm::dvec3(object.worldFromObject[3]), s.scale, s.yaw});
    }
    return shapes;
}

bool isDegenerate(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    return !(glm::length(glm::cross(b - a, c - a)) > kSliver * longest * longest);
}

struct TransformedMesh {
    std::vector<glm::dvec3> positions, normals;
    std::vector<glm::uvec3> triangles;
};

/// `mesh` under x ↦ linear·x + translation, without degenerate triangles (which are counted).
TransformedMesh transformed(const Mesh& mesh, const glm::dmat3& linear, const glm::dvec3& translation, size_t& degenerate) {
    TransformedMesh out;
    const bool mirrored = glm::determinant(linear) < 0;
    // Cofactors: the inverse transpose up to a factor, and defined for flattened meshes too.
    const glm::dmat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]), glm::cross(linear[0], linear[1]));
    const double sign = mirrored ? -1 : 1;
    for (const glm::vec3& p : mesh.positions) out.positions.push_back(linear * glm::dvec3(p) + translation);
    for (const glm::vec3& n : mesh.normals) out.normals.push_back(sign * (cofactor * glm::dvec3(n)));
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t a = mesh.indices[i], b = mesh.indices[i + (mirrored ? 2 : 1)], c = mesh.indices[i + (mirrored ? 1 : 2)];
        const glm::dvec3 normal = glm::cross(out.positions[b] - out.positions[a], out.positions[c] - out.positions[a]);
        if (isDegenerate(out.positions[a], out.positions[b], out.positions[c])) {
            ++degenerate;
            continue;
        }
        for (const uint32_t v : {a, b, c})
            if (!(glm::length(out.normals[v]) > 1e-12)) out.normals[v] = normal;
        out.triangles.emplace_back(a, b, c);
    }
    for (glm::dvec3& n : out.normals) n = glm::length(n) > 1e-12 ? glm::normalize(n) : glm::dvec3(0, 0, 1);
    return out;
}

/// Appends triangles of a transformed mesh to `target`, relative to `centre`, with the vertices they use.
void append(Mesh& target, const Mesh& source, const TransformedMesh& mesh, const std::vector<uint32_t>& triangles, const glm::dvec3& centre) {
    std::unordered_map<uint32_t, uint32_t> targetOf;
    for (const uint32_t t : triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t v = mesh.triangles[t][k];
            const auto [it, isNew] = targetOf.emplace(v, uint32_t(target.positions.size()));
            if (isNew) {
                target.positions.emplace_back(mesh.positions[v] - centre);
                target.normals.emplace_back(mesh.normals[v]);
                if (!source.uvs.empty()) target.uvs.push_back(source.uvs[v]);
            }
            target.indices.push_back(it->second);
        }
}

base::DBox boxOf(const TransformedMesh& mesh, const std::vector<uint32_t>& triangles) {
    base::DBox box;
    for (const uint32_t t : triangles)
        for (int k = 0; k < 3; ++k) box.extend(mesh.positions[mesh.triangles[t][k]]);
    return box;
}

std::vector<uint32_t> allTriangles(const TransformedMesh& mesh) {
    std::vector<uint32_t> all(mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

void addInstanced(const FileScene& file, const Shape& shape, std::vector<Draft>& drafts, size_t& degenerate) {
    Draft draft{{shape.name, {}, shape.castsShadow, false}, shape.places};
    std::map<uint32_t, Mesh> byMaterial;
    std::vector<std::pair<const Mesh*, TransformedMesh>> parts;
    base::DBox box;
    size_t dropped = 0;
    for (const uint32_t m : shape.meshes) {
        parts.emplace_back(&file.meshes[m], transformed(file.meshes[m], shape.baked, glm::dvec3(0), dropped));
        box.extend(boxOf(parts.back().second, allTriangles(parts.back().second)));
    }
    degenerate += dropped * shape.places.size();
    if (box.empty()) return;
    const glm::dvec3 centre = glm::length(box.centre()) > kFarFromOwnSpace ? glm::round(box.centre()) : glm::dvec3(0);
    for (const auto& [source, mesh] : parts) append(byMaterial[source->material], *source, mesh, allTriangles(mesh), centre);
    for (Placed& p : draft.places) p.translation = p(centre);
    for (auto& [material, mesh] : byMaterial) {
        mesh.material = material;
        if (!mesh.indices.empty()) draft.prototype.meshes.push_back(std::move(mesh));
    }
    drafts.push_back(std::move(draft));
}

using Cell = std::pair<long long, long long>;

/// Static shapes merged by material within cells. A mesh goes whole into the cell of its centre, which
/// keeps closed meshes closed; open ones that are larger than a cell (terrain, roads) are cut at triangles.
void addMerged(const FileScene& file, const std::vector<const Shape*>& shapes, double cell, std::vector<Draft>& drafts, size_t& degenerate) {
    const auto cellOf = [&](const glm::dvec3& p) { return Cell{std::llround(std::floor(p.x / cell)), std::llround(std::floor(p.y / cell))}; };
    std::map<std::tuple<Cell, bool, uint32_t>, Mesh> merged;
    for (const Shape* shape : shapes) {
        const Placed& place = shape->places.front();
        const double c = std::cos(place.yaw) * place.scale, s = std::sin(place.yaw) * place.scale;
        const glm::dmat3 linear = glm::dmat3({c, s, 0}, {-s, c, 0}, {0, 0, place.scale}) * shape->baked;
        for (const uint32_t m : shape->meshes) {
            const Mesh& source = file.meshes[m];
            const TransformedMesh mesh = transformed(source, linear, place.translation, degenerate);
            std::map<Cell, std::vector<uint32_t>> parts;
            const base::DBox box = boxOf(mesh, allTriangles(mesh));
            if (box.empty()) continue;
            if (std::max(box.size().x, box.size().y) <= cell || isClosed(source)) {
                parts[cellOf(box.centre())] = allTriangles(mesh);
            } else {
                for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                    const glm::uvec3 v = mesh.triangles[t];
                    parts[cellOf((mesh.positions[v.x] + mesh.positions[v.y] + mesh.positions[v.z]) / 3.0)].push_back(t);
                }
            }
            for (const auto& [at, triangles] : parts) {
                const glm::dvec3 centre((double(at.first) + 0.5) * cell, (double(at.second) + 0.5) * cell, 0);
                append(merged[{at, shape->castsShadow, source.material}], source, mesh, triangles, centre);
            }
        }
    }
    std::map<std::pair<Cell, bool>, Draft> byCell;
    for (auto& [key, mesh] : merged) {
        const auto& [at, casts, material] = key;
        Draft& draft = byCell[{at, casts}];
        if (draft.places.empty()) {
            draft.prototype.name = fmt::format("static {} {}{}", at.first, at.second, casts ? "" : " receivers");
            draft.prototype.castsShadow = casts;
            draft.places.push_back({{(double(at.first) + 0.5) * cell, (double(at.second) + 0.5) * cell, 0}, 1, 0});
        }
        mesh.material = material;
        draft.prototype.meshes.push_back(std::move(mesh));
    }
    for (auto& [key, draft] : byCell) drafts.push_back(std::move(draft));
}

/// World coordinates beyond half a kilometre go into the double origin; small scenes keep theirs.
glm::dvec3 chooseOrigin(const std::vector<Draft>& drafts) {
    base::DBox box;
    for (const Draft& draft : drafts)
        for (const Placed& p : draft.places) box.extend(p.translation);
    return box.empty() ? glm::dvec3(0) : glm::round(box.centre() / 1000.0) * 1000.0;
}

/// Textures and materials that no mesh uses are left out.
void keepUsedMaterials(FileScene& file, Scene& scene) {
    std::vector<int> newMaterial(file.materials.size(), -1), newTexture(file.textures.size(), -1);
    for (Prototype& prototype : scene.prototypes)
        for (Mesh& mesh : prototype.meshes) {
            int& material = newMaterial[mesh.material];
            if (material < 0) {
                material = int(scene.materials.size());
                scene.materials.push_back(file.materials[mesh.material]);
                if (int& t = scene.materials.back().texture; t >= 0) {
                    int& texture = newTexture[size_t(t)];
                    if (texture < 0) {
                        texture = int(scene.textures.size());
                        scene.textures.push_back(std::move(file.textures[size_t(t)]));
                    }
                    t = texture;
                }
            }
            mesh.material = uint32_t(material);
        }
}

}  // namespace

CutCounts cutIntoPrototypes(FileScene& file, double cell, Scene& scene) {
    CutCounts counts;
    const std::vector<Shape> shapes = findShapes(file);
    std::vector<const Shape*> statics;
    for (const Shape& shape : shapes)
        if (shape.places.size() == 1) statics.push_back(&shape);
    const bool merge = statics.size() > kMaxStaticPrototypes;

    std::vector<Draft> drafts;
    for (const Shape& shape : shapes)
        if (!merge || shape.places.size() > 1) addInstanced(file, shape, drafts, counts.degenerate);
    if (merge) addMerged(file, statics, cell, drafts, counts.degenerate);
    counts.turned = orientClosed(drafts, file.views);

    scene.origin = chooseOrigin(drafts);
    for (Draft& draft : drafts) {
        for (const Placed& p : draft.places)
            scene.instances.push_back({glm::vec3(p.translation - scene.origin), float(p.scale), float(p.yaw), uint32_t(scene.prototypes.size())});
        scene.prototypes.push_back(std::move(draft.prototype));
    }
    keepUsedMaterials(file, scene);

    std::vector<bool> allClosed(scene.materials.size(), true);
    for (const Prototype& prototype : scene.prototypes)
        for (const Mesh& mesh : prototype.meshes)
            if (!prototype.closed) allClosed[mesh.material] = false;
    for (size_t m = 0; m < scene.materials.size(); ++m) scene.materials[m].doubleSided = !allClosed[m] || scene.materials[m].alphaTested;
    return counts;
}

}  // namespace dapple::scenegen
