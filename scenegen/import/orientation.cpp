#include "scenegen/import/orientation.h"

#include "scenegen/lod/connectivity.h"
#include "scenegen/lod/half_edges.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>

namespace dapple::scenegen {
namespace {

constexpr double kFlat =
    1e-9;  ///< volume over the cube of the box's diagonal: both sides are there, neither is outside
constexpr size_t kMostParts = 5'000'000;      ///< over all places; beyond, no part is turned
constexpr size_t kMostPairs = 1'000'000'000;  ///< boxes of parts compared, per draft: about 5 s
constexpr size_t kMostAngles = 100'000'000;   ///< triangles seen from points, per draft: about 5 s

/// A connected part of a closed mesh.
struct Part {
    size_t mesh;
    std::vector<uint32_t> triangles;
    base::DBox box;
    double volume = 0;  ///< negative: faces inwards
};

std::array<glm::dvec3, 3> corners(const Mesh& mesh, uint32_t triangle) {
    const uint32_t* v = &mesh.indices[size_t(triangle) * 3];
    return {glm::dvec3(mesh.positions[v[0]]), glm::dvec3(mesh.positions[v[1]]), glm::dvec3(mesh.positions[v[2]])};
}

/// Parts of a closed mesh: triangles that share an edge belong together. (Those that share a corner only need not.)
std::vector<Part> partsOf(const Prototype& prototype, size_t index) {
    const Mesh& mesh = prototype.meshes[index];
    const std::vector<uint32_t> welded = weldedVertices(mesh.positions);
    std::vector<std::pair<uint64_t, uint32_t>> edges;  // lower and higher vertex, and the triangle
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        const uint64_t a = welded[mesh.indices[i]], b = welded[mesh.indices[i % 3 == 2 ? i - 2 : i + 1]];
        edges.emplace_back(std::min(a, b) << 32 | std::max(a, b), uint32_t(i / 3));
    }
    std::ranges::sort(edges);
    std::vector<uint32_t> parent(mesh.triangles());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](uint32_t t) {
        while (parent[t] != t) t = parent[t] = parent[parent[t]];
        return t;
    };
    for (size_t i = 1; i < edges.size(); ++i)
        if (edges[i].first == edges[i - 1].first) parent[root(edges[i].second)] = root(edges[i - 1].second);

    std::vector<Part> parts;
    std::vector<size_t> partOfRoot(mesh.triangles(), ~size_t{0});
    for (uint32_t t = 0; t < mesh.triangles(); ++t) {
        size_t& part = partOfRoot[root(t)];
        if (part == ~size_t{0}) {
            part = parts.size();
            parts.push_back({index, {}, {}, 0});
        }
        parts[part].triangles.push_back(t);
        for (const glm::dvec3& p : corners(mesh, t)) parts[part].box.extend(p);
    }
    for (Part& part : parts) {
        const glm::dvec3 centre = part.box.centre();
        for (const uint32_t t : part.triangles) {
            const auto [a, b, c] = corners(mesh, t);
            part.volume += glm::dot(a - centre, glm::cross(b - centre, c - centre)) / 6;
        }
        const double diagonal = glm::length(part.box.size());
        if (std::abs(part.volume) < kFlat * diagonal * diagonal * diagonal) part.volume = 0;
    }
    return parts;
}

bool holds(const base::DBox& outer, const base::DBox& inner) {
    return glm::all(glm::lessThanEqual(outer.lo, inner.lo)) && glm::all(glm::greaterThanEqual(outer.hi, inner.hi));
}

/// Whether a point lies in a part: the solid angle of all its triangles is then 4π or -4π, else 0.
/// Van Oosterom and Strackee (1983), The Solid Angle of a Plane Triangle, equation 8.
bool lieIn(const Prototype& prototype, const Part& part, const glm::dvec3& point) {
    double angle = 0;
    for (const uint32_t t : part.triangles) {
        const auto p = corners(prototype.meshes[part.mesh], t);
        const glm::dvec3 a = p[0] - point, b = p[1] - point, c = p[2] - point;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        angle += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                                la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return std::abs(angle) > glm::two_pi<double>();
}

/// The parts of a closed prototype that face inwards and are no cavity; nothing when that is unclear.
std::optional<std::vector<size_t>> inwardParts(const Prototype& prototype, const std::vector<Part>& parts) {
    std::vector<size_t> inward;
    const auto negative = size_t(std::ranges::count_if(parts, [](const Part& p) { return p.volume < 0; }));
    if (negative * parts.size() > kMostPairs) return std::nullopt;
    size_t angles = 0;
    for (size_t i = 0; i < parts.size(); ++i) {
        if (!(parts[i].volume < 0)) continue;
        bool cavity = false;
        for (size_t k = 0; k < parts.size(); ++k) {
            if (k == i || parts[k].volume == 0) continue;
            const bool around = holds(parts[k].box, parts[i].box), within = holds(parts[i].box, parts[k].box);
            if (!around && !within) continue;
            const Part &outer = parts[around ? k : i], &inner = parts[around ? i : k];
            if ((angles += outer.triangles.size()) > kMostAngles) return std::nullopt;
            if (!lieIn(prototype, outer, corners(prototype.meshes[inner.mesh], inner.triangles[0])[0])) continue;
            if (within || outer.volume < 0) return std::nullopt;
            cavity = true;
        }
        if (!cavity) inward.push_back(i);
    }
    return inward;
}

/// Turns parts of one mesh, and their normals where these agree with the triangles.
void turn(Mesh& mesh, const std::vector<const Part*>& parts) {
    constexpr uint32_t kNone = ~0u, kSeveral = ~0u - 1;
    std::vector<uint32_t> partOf(mesh.triangles(), kNone - 2), user(mesh.positions.size(), kNone);
    for (uint32_t p = 0; p < parts.size(); ++p)
        for (const uint32_t t : parts[p]->triangles) partOf[t] = p;
    for (size_t i = 0; i < mesh.indices.size(); ++i) {
        uint32_t& u = user[mesh.indices[i]];
        u = u == kNone || u == partOf[i / 3] ? partOf[i / 3] : kSeveral;
    }
    for (const Part* part : parts) {
        double agreement = 0;
        std::map<uint32_t, uint32_t> own;  // a part's vertices; those that others use too are copied
        for (const uint32_t t : part->triangles) {
            const auto [a, b, c] = corners(mesh, t);
            uint32_t* v = &mesh.indices[size_t(t) * 3];
            for (int k = 0; k < 3; ++k) {
                agreement += glm::dot(glm::cross(b - a, c - a), glm::dvec3(mesh.normals[v[k]]));
                own.emplace(v[k], v[k]);
            }
            std::swap(v[1], v[2]);
        }
        if (agreement < 0) continue;
        for (auto& [v, to] : own) {
            if (user[v] == kSeveral) {
                to = uint32_t(mesh.positions.size());
                mesh.positions.push_back(mesh.positions[v]);
                mesh.normals.push_back(mesh.normals[v]);
                if (!mesh.uvs.empty()) mesh.uvs.push_back(mesh.uvs[v]);
            }
            mesh.normals[to] = -mesh.normals[to];
        }
        for (const uint32_t t : part->triangles)
            for (size_t i = size_t(t) * 3; i < size_t(t) * 3 + 3; ++i) mesh.indices[i] = own.at(mesh.indices[i]);
    }
}

/// Boxes in the file's world, found through a grid of cells seen from above.
class BoxGrid {
public:
    struct Item {
        base::DBox box;
        size_t draft;
        bool facesOutwards;  ///< a closed part that another one can lie in
    };
    explicit BoxGrid(std::vector<Item> items) : items_(std::move(items)) {
        for (const Item& item : items_) all_.extend(item.box.lo), all_.extend(item.box.hi);
        for (uint32_t i = 0; i < items_.size(); ++i)
            forCells(items_[i].box, [&](std::vector<uint32_t>& cell) {
                cell.push_back(i);
                return false;
            });
    }
    /// Whether another draft has something in `box`, or a closed part around it.
    bool isInOrAround(const base::DBox& box, size_t draft) {
        return forCells(box, [&](const std::vector<uint32_t>& cell) {
            return std::ranges::any_of(cell, [&](uint32_t i) {
                const Item& item = items_[i];
                return item.draft != draft && (holds(box, item.box) || (item.facesOutwards && holds(item.box, box)));
            });
        });
    }

private:
    static constexpr int kSide = 64;

    template <class F>
    bool forCells(const base::DBox& box, F f) {
        const auto cellOf = [&](double p, int axis) {
            const double size = all_.size()[axis];
            return size > 0 ? std::clamp(int((p - all_.lo[axis]) / size * kSide), 0, kSide - 1) : 0;
        };
        for (int y = cellOf(box.lo.y, 1); y <= cellOf(box.hi.y, 1); ++y)
            for (int x = cellOf(box.lo.x, 0); x <= cellOf(box.hi.x, 0); ++x)
                if (f(cells_[size_t(y * kSide + x)])) return true;
        return false;
    }

    std::vector<Item> items_;
    base::DBox all_;
    std::array<std::vector<uint32_t>, size_t(kSide* kSide)> cells_;
};

base::DBox boxAt(const Placed& place, const base::DBox& box) {
    base::DBox out;
    for (int k = 0; k < 8; ++k)
        out.extend(place({k & 1 ? box.hi.x : box.lo.x, k & 2 ? box.hi.y : box.lo.y, k & 4 ? box.hi.z : box.lo.z}));
    return out;
}

base::DBox boxOf(const Prototype& prototype) {
    const base::Box box = prototype.box();
    return {glm::dvec3(box.lo), glm::dvec3(box.hi)};
}

/// All that can lie in a part or around it; nothing when that is too much.
std::optional<BoxGrid> boxesOf(const std::vector<Draft>& drafts, const std::vector<std::vector<Part>>& parts,
                               const std::vector<View>& views) {
    std::vector<BoxGrid::Item> items;
    for (const View& view : views) items.push_back({{view.eye, view.eye}, drafts.size(), false});
    for (size_t d = 0; d < drafts.size(); ++d) {
        if (items.size() + (parts[d].size() + 1) * drafts[d].places.size() > kMostParts) return std::nullopt;
        for (const Placed& place : drafts[d].places) {
            items.push_back({boxAt(place, boxOf(drafts[d].prototype)), d, false});
            for (const Part& part : parts[d])
                if (part.volume > 0) items.push_back({boxAt(place, part.box), d, true});
        }
    }
    return BoxGrid(std::move(items));
}

}  // namespace

glm::dvec3 Placed::operator()(const glm::dvec3& p) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    return translation + scale * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
}

size_t orientClosed(std::vector<Draft>& drafts, const std::vector<View>& views) {
    std::vector<std::vector<Part>> parts(drafts.size());
    std::vector<std::vector<size_t>> inward(drafts.size());
    bool anyInward = false;
    for (size_t d = 0; d < drafts.size(); ++d) {
        Prototype& prototype = drafts[d].prototype;
        prototype.closed = std::ranges::all_of(prototype.meshes, [](const Mesh& m) { return isClosed(m); });
        if (!prototype.closed) continue;
        for (size_t m = 0; m < prototype.meshes.size(); ++m)
            std::ranges::move(partsOf(prototype, m), std::back_inserter(parts[d]));
        const auto found = inwardParts(prototype, parts[d]);
        prototype.closed = found.has_value();
        inward[d] = found.value_or(std::vector<size_t>{});
        anyInward = anyInward || !inward[d].empty();
    }
    if (!anyInward) return 0;

    std::optional<BoxGrid> boxes = boxesOf(drafts, parts, views);
    size_t turned = 0;
    for (size_t d = 0; d < drafts.size(); ++d) {
        const bool unclear =
            !inward[d].empty() && (!boxes || std::ranges::any_of(drafts[d].places, [&](const Placed& place) {
                return std::ranges::any_of(
                    inward[d], [&](size_t i) { return boxes->isInOrAround(boxAt(place, parts[d][i].box), d); });
            }));
        if (unclear) drafts[d].prototype.closed = false;
        if (!drafts[d].prototype.closed) continue;
        std::map<size_t, std::vector<const Part*>> byMesh;
        for (const size_t i : inward[d]) byMesh[parts[d][i].mesh].push_back(&parts[d][i]);
        for (const auto& [mesh, turnedParts] : byMesh) turn(drafts[d].prototype.meshes[mesh], turnedParts);
        turned += inward[d].size();
    }
    return turned;
}

}  // namespace dapple::scenegen
