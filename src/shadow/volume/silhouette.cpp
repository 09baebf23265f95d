#include "shadow/volume/silhouette.h"

#include "base/error.h"
#include "scenegen/lod/half_edges.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace dapple::shadow {
namespace {

/// One face's side of an edge between corners lo < hi.
struct Side {
    uint32_t lo, hi, face;
    bool upwards;  ///< the face runs from lo to hi
};

}  // namespace

Silhouettes::Range Silhouettes::add(const scenegen::Prototype& prototype) {
    if (!prototype.closed) throw base::UsageError(fmt::format("silhouettes need closed casters; {} is open", prototype.name));
    Range range{uint32_t(faces.size()), 0};
    for (const scenegen::Mesh& mesh : prototype.meshes) {
        const auto base = uint32_t(corners.size());
        for (const glm::vec3& p : mesh.positions) corners.emplace_back(p, 0);
        const std::vector<uint32_t> welded = scenegen::weldedVertices(mesh.positions);
        std::vector<Side> sides;
        for (size_t i = 0; i < mesh.indices.size(); i += 3) {
            const auto face = uint32_t(faces.size());
            glm::uvec4 c(0);
            for (int k = 0; k < 3; ++k) c[k] = base + welded[mesh.indices[i + size_t(k)]];
            const glm::dvec3 p(corners[c.x]), q(corners[c.y]), r(corners[c.z]);
            faces.push_back({glm::vec4(glm::normalize(glm::cross(q - p, r - p)), 0), c});
            for (int k = 0; k < 3; ++k) {
                const uint32_t from = c[k], to = c[(k + 1) % 3];
                sides.push_back({std::min(from, to), std::max(from, to), face, from < to});
            }
        }
        // A closed mesh has each edge in either direction once: equal ones become neighbours, that which runs upwards first.
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return std::tuple(a.lo, a.hi, b.upwards) < std::tuple(b.lo, b.hi, a.upwards); });
        for (size_t i = 0; i < sides.size(); i += 2) edges.push_back({sides[i].lo, sides[i].hi, sides[i].face, sides[i + 1].face});
    }
    range.faces = uint32_t(faces.size()) - range.firstFace;
    return range;
}

}  // namespace dapple::shadow
