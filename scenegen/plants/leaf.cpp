#include "scenegen/plants/leaf.h"

#include <algorithm>
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
    std::span<const glm::dvec2> rim;
    glm::dvec2 heart;
};

constexpr glm::dvec2 kDiamond[] = {{0, 0}, {0.5, 0.45}, {0, 1}, {-0.5, 0.45}};
constexpr glm::dvec2 kOval[] = {{0, 0}, {0.46, 0.24}, {0.5, 0.6}, {0, 1}, {-0.5, 0.6}, {-0.46, 0.24}};
constexpr glm::dvec2 kTriangle[] = {{0, 0}, {0.5, 0.12}, {0, 1}, {-0.5, 0.12}};
constexpr glm::dvec2 kOak3[] = {{0, 0}, {0.5, 0.42}, {0.24, 0.52}, {0.3, 0.86}, {0, 1}, {-0.3, 0.86}, {-0.24, 0.52}, {-0.5, 0.42}};
constexpr glm::dvec2 kMaple3[] = {{0, 0}, {0.5, 0.55}, {0.17, 0.5}, {0, 1}, {-0.17, 0.5}, {-0.5, 0.55}};
constexpr glm::dvec2 kMaple5[] = {{0, 0}, {0.4, 0.1}, {0.2, 0.23}, {0.5, 0.6}, {0.16, 0.52}, {0, 1}, {-0.16, 0.52}, {-0.5, 0.6}, {-0.2, 0.23}, {-0.4, 0.1}};
constexpr glm::dvec2 kMiddle[] = {{0, 0}, {0.16, 0.6}, {0, 1}, {-0.16, 0.6}};
// Apart from the middle leaflet: where vertices are welded, surfaces that touch in a point are no manifold.
constexpr glm::dvec2 kRight[] = {{0.03, 0.02}, {0.42, 0.22}, {0.5, 0.5}, {0.2, 0.38}};
constexpr glm::dvec2 kLeft[] = {{-0.03, 0.02}, {-0.2, 0.38}, {-0.5, 0.5}, {-0.42, 0.22}};

constexpr Piece kPieces[] = {
    {kDiamond, {0, 0.45}}, {kOval, {0, 0.45}}, {kTriangle, {0, 0.3}}, {kOak3, {0, 0.45}}, {kMaple3, {0, 0.4}}, {kMaple5, {0, 0.2}},
    {kMiddle, {0, 0.6}}, {kRight, {0.31, 0.3}}, {kLeft, {-0.31, 0.3}},
};

/// A leaf of three leaflets has the last three.
std::span<const Piece> piecesOf(LeafShape shape) {
    const auto first = size_t(shape);
    return std::span(kPieces).subspan(first, shape == LeafShape::three ? 3 : 1);
}
static_assert(std::size(kPieces) == size_t(LeafShape::three) + 3);

glm::dvec3 pointOf(const Blade& b, const glm::dvec2& p) {
    return b.root + b.along * (p.y * b.length) + b.normal * (kFold * std::abs(p.x) * b.width) + b.across * (p.x * b.width);
}

/// The halves lean towards the midrib: normals 0.96² + 0.28² = 1.
glm::dvec3 normalOf(const Blade& b, double x) {
    if (x == 0) return b.normal;
    return 0.96 * b.normal + (x < 0 ? 0.28 : -0.28) * b.across;
}

void setVertex(Mesh& mesh, size_t at, const glm::dvec3& position, const glm::dvec3& normal) {
    mesh.positions[at] = glm::vec3(position);
    mesh.normals[at] = glm::vec3(normal);
}

void setFlat(Mesh& mesh, size_t& vertex, uint32_t*& index, const Piece& piece, const Blade& b) {
    const auto first = uint32_t(vertex), corners = uint32_t(piece.rim.size());
    glm::vec3 *position = &mesh.positions[vertex], *normal = &mesh.normals[vertex];
    const glm::vec3 middle(b.normal), sides[2] = {glm::vec3(normalOf(b, -1)), glm::vec3(normalOf(b, 1))};
    for (const glm::dvec2& p : piece.rim) {
        *position++ = glm::vec3(pointOf(b, p));
        *normal++ = p.x == 0 ? middle : sides[p.x > 0];
    }
    vertex += corners;
    for (uint32_t i = 1; i + 1 < corners; ++i, index += 3) index[0] = first, index[1] = first + i, index[2] = first + i + 1;
}

/// The outline, and a point above and below its heart. The rim stands twice, for normals of both sides.
void setSolid(Mesh& mesh, size_t& vertex, uint32_t*& index, const Piece& piece, const Blade& b) {
    const auto corners = uint32_t(piece.rim.size());
    const glm::dvec3 heart = pointOf(b, piece.heart), thick = b.normal * (0.5 * kThickness * b.width);
    for (const double up : {1, -1}) {
        const auto first = uint32_t(vertex);
        for (const glm::dvec2& p : piece.rim) setVertex(mesh, vertex++, pointOf(b, p), up * normalOf(b, p.x));
        setVertex(mesh, vertex++, heart + up * thick, up * normalOf(b, piece.heart.x));
        for (uint32_t i = 0; i < corners; ++i) {
            const uint32_t next = (i + 1) % corners;
            for (const uint32_t v : {up > 0 ? i : next, up > 0 ? next : i, corners}) *index++ = first + v;
        }
    }
}

void setCard(Mesh& mesh, size_t vertex, size_t firstIndex, const Blade& b) {
    const glm::dvec3 side = b.across * (0.5 * b.width), tip = b.root + b.along * b.length;
    const glm::dvec3 corners[4] = {b.root - side, b.root + side, tip + side, tip - side};
    for (size_t i = 0; i < 4; ++i) setVertex(mesh, vertex + i, corners[i], b.normal);
    const glm::vec2 uvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    std::copy_n(uvs, 4, &mesh.uvs[vertex]);
    uint32_t* index = &mesh.indices[firstIndex];
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) *index++ = uint32_t(vertex) + i;
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

void setLeaf(Mesh& mesh, LeafShape shape, LeafMode mode, size_t vertex, size_t firstIndex, const Blade& blade) {
    if (mode == LeafMode::card) return setCard(mesh, vertex, firstIndex, blade);
    uint32_t* index = &mesh.indices[firstIndex];
    for (const Piece& piece : piecesOf(shape))
        if (mode == LeafMode::solid)
            setSolid(mesh, vertex, index, piece, blade);
        else
            setFlat(mesh, vertex, index, piece, blade);
}

}  // namespace dapple::scenegen
