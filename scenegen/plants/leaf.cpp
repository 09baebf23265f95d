#include "scenegen/plants/leaf.h"

#include "scenegen/plants/lanes.h"

#include <span>

namespace dapple::scenegen {
namespace {

/// Thickness of a solid leaf over its width: far more than a real one's, so that depth maps can tell its sides apart.
constexpr double kThickness = 0.04;
/// Height of a point over the midrib, per distance from it: the halves rise.
constexpr double kFold = 0.24;

/// Of an outline: x in widths across the leaf, y in lengths along it, the root first, counter-clockwise. Every point is
/// in sight of the root and of the heart, from which the triangles of flat and of solid leaves fan out.
struct Piece {
    std::span<const glm::vec2> rim;
    glm::vec2 heart;
};

constexpr glm::vec2 kDiamond[] = {{0, 0}, {0.5f, 0.45f}, {0, 1}, {-0.5f, 0.45f}};
constexpr glm::vec2 kOval[] = {{0, 0}, {0.46f, 0.24f}, {0.5f, 0.6f}, {0, 1}, {-0.5f, 0.6f}, {-0.46f, 0.24f}};
constexpr glm::vec2 kTriangle[] = {{0, 0}, {0.5f, 0.12f}, {0, 1}, {-0.5f, 0.12f}};
constexpr glm::vec2 kOak3[] = {{0, 0}, {0.5f, 0.42f}, {0.24f, 0.52f}, {0.3f, 0.86f}, {0, 1}, {-0.3f, 0.86f}, {-0.24f, 0.52f}, {-0.5f, 0.42f}};
constexpr glm::vec2 kMaple3[] = {{0, 0}, {0.5f, 0.55f}, {0.17f, 0.5f}, {0, 1}, {-0.17f, 0.5f}, {-0.5f, 0.55f}};
constexpr glm::vec2 kMaple5[] = {{0, 0}, {0.4f, 0.1f}, {0.2f, 0.23f}, {0.5f, 0.6f}, {0.16f, 0.52f}, {0, 1}, {-0.16f, 0.52f}, {-0.5f, 0.6f}, {-0.2f, 0.23f}, {-0.4f, 0.1f}};
constexpr glm::vec2 kMiddle[] = {{0, 0}, {0.16f, 0.6f}, {0, 1}, {-0.16f, 0.6f}};
// Apart from the middle leaflet: where vertices are welded, surfaces that touch in a point are no manifold.
constexpr glm::vec2 kRight[] = {{0.03f, 0.02f}, {0.42f, 0.22f}, {0.5f, 0.5f}, {0.2f, 0.38f}};
constexpr glm::vec2 kLeft[] = {{-0.03f, 0.02f}, {-0.2f, 0.38f}, {-0.5f, 0.5f}, {-0.42f, 0.22f}};

constexpr Piece kPieces[] = {
    {kDiamond, {0, 0.45f}}, {kOval, {0, 0.45f}}, {kTriangle, {0, 0.3f}}, {kOak3, {0, 0.45f}}, {kMaple3, {0, 0.4f}}, {kMaple5, {0, 0.2f}},
    {kMiddle, {0, 0.6f}}, {kRight, {0.31f, 0.3f}}, {kLeft, {-0.31f, 0.3f}},
};

/// A leaf of three leaflets has the last three.
std::span<const Piece> piecesOf(LeafShape shape) {
    const auto first = size_t(shape);
    return std::span(kPieces).subspan(first, shape == LeafShape::three ? 3 : 1);
}
static_assert(std::size(kPieces) == size_t(LeafShape::three) + 3);

/// A blade as single-precision vectors in metres, whose sums are the leaf's points.
struct Frame {
    Float4 root, along, across, fold, normal, thick;
    Float4 sides[3];  ///< unit normals of the left half, the midrib, and the right half

    explicit Frame(const Blade& b)
        : root(float4(b.root)), along(float4(b.along * b.length)), across(float4(b.across * b.width)), fold(float4(b.normal * (kFold * b.width))),
          normal(float4(b.normal)), thick(float4(b.normal * (0.5 * kThickness * b.width))) {
        // The halves lean towards the midrib: 0.96² + 0.28² = 1.
        const Float4 lean = 0.28f * float4(b.across);
        sides[0] = 0.96f * normal + lean, sides[1] = normal, sides[2] = 0.96f * normal - lean;
    }
    Float4 point(const glm::vec2& p) const { return root + along * p.y + across * p.x + fold * std::abs(p.x); }
    const Float4& side(float x) const { return sides[x < 0 ? 0 : x == 0 ? 1 : 2]; }
};

void setFlat(glm::vec3*& position, glm::vec3*& normal, uint32_t& vertex, uint32_t*& index, const Piece& piece, const Frame& f) {
    const auto corners = uint32_t(piece.rim.size());
    for (const glm::vec2& p : piece.rim) {
        store3(*position++, f.point(p));
        store3(*normal++, f.side(p.x));
    }
    for (uint32_t i = 1; i + 1 < corners; ++i, index += 3) index[0] = vertex, index[1] = vertex + i, index[2] = vertex + i + 1;
    vertex += corners;
}

/// The outline, and a point above and below its heart. The rim stands twice, for normals of both sides.
void setSolid(glm::vec3*& position, glm::vec3*& normal, uint32_t& vertex, uint32_t*& index, const Piece& piece, const Frame& f) {
    const auto corners = uint32_t(piece.rim.size());
    for (const float up : {1.0f, -1.0f}) {
        for (const glm::vec2& p : piece.rim) {
            store3(*position++, f.point(p));
            store3(*normal++, up * f.side(p.x));
        }
        store3(*position++, f.point(piece.heart) + up * f.thick);
        store3(*normal++, up * f.side(piece.heart.x));
        for (uint32_t i = 0; i < corners; ++i, index += 3) {
            const uint32_t next = i + 1 < corners ? i + 1 : 0;
            index[0] = vertex + (up > 0 ? i : next), index[1] = vertex + (up > 0 ? next : i), index[2] = vertex + corners;
        }
        vertex += corners + 1;
    }
}

void setCard(glm::vec3* position, glm::vec3* normal, glm::vec2* uv, uint32_t vertex, uint32_t* index, const Frame& f) {
    constexpr glm::vec2 kUvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    for (size_t i = 0; i < 4; ++i) {
        store3(position[i], f.root + f.across * (kUvs[i].x - 0.5f) + f.along * (1 - kUvs[i].y));
        store3(normal[i], f.normal);
        uv[i] = kUvs[i];
    }
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) *index++ = vertex + i;
}

}  // namespace

size_t leafVertices(LeafShape shape, LeafMode mode) {
    if (mode == LeafMode::card) return 4;
    size_t count = 0;
    for (const Piece& p : piecesOf(shape)) count += mode == LeafMode::solid ? 2 * p.rim.size() + 2 : p.rim.size();
    return count;
}

size_t leafTriangles(LeafShape shape, LeafMode mode) {
    if (mode == LeafMode::card) return 2;
    size_t count = 0;
    for (const Piece& p : piecesOf(shape)) count += mode == LeafMode::solid ? 2 * p.rim.size() : p.rim.size() - 2;
    return count;
}

void setLeaf(Mesh& mesh, LeafShape shape, LeafMode mode, size_t vertex, size_t firstIndex, uint32_t shift, const Blade& blade) {
    const Frame frame(blade);
    glm::vec3 *position = &mesh.positions[vertex], *normal = &mesh.normals[vertex];
    uint32_t* index = &mesh.indices[firstIndex];
    auto next = uint32_t(vertex) + shift;
    if (mode == LeafMode::card) return setCard(position, normal, &mesh.uvs[vertex], next, index, frame);
    for (const Piece& piece : piecesOf(shape))
        if (mode == LeafMode::solid)
            setSolid(position, normal, next, index, piece, frame);
        else
            setFlat(position, normal, next, index, piece, frame);
}

}  // namespace dapple::scenegen
