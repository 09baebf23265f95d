#include "scenegen/city/solid.h"

#include "base/detmath.h"

#include <array>

namespace dapple::scenegen::city {
namespace {

uint32_t addVertex(Mesh& mesh, const glm::dvec3& p, const glm::vec3& normal) {
    mesh.positions.emplace_back(p);
    mesh.normals.push_back(normal);
    return uint32_t(mesh.positions.size() - 1);
}

/// Without corners that lie on the line between their neighbours: they would make triangles without area.
std::vector<glm::dvec2> tidied(const Region& region) {
    std::vector<glm::dvec2> out;
    for (size_t i = 0; i < region.size(); ++i) {
        const glm::dvec2 before = out.empty() ? region.corners.back() : out.back(), p = region.corners[i], after = region.next(i);
        const glm::dvec2 d = after - before;
        const double height = std::abs(d.x * (p.y - before.y) - d.y * (p.x - before.x)) / std::sqrt(glm::dot(d, d));
        if (height > 1e-3 && glm::distance(before, p) > 5e-3) out.push_back(p);
    }
    return out;
}

}  // namespace

void addFace(Mesh& mesh, std::span<const glm::dvec3> corners) {
    glm::dvec3 normal(0);
    for (size_t i = 1; i + 1 < corners.size(); ++i) normal += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
    const glm::vec3 n(normal / std::sqrt(glm::dot(normal, normal)));
    const uint32_t base = addVertex(mesh, corners[0], n);
    for (size_t i = 1; i < corners.size(); ++i) addVertex(mesh, corners[i], n);
    for (uint32_t i = 1; i + 1 < corners.size(); ++i) {
        mesh.indices.push_back(base);
        mesh.indices.push_back(base + i);
        mesh.indices.push_back(base + i + 1);
    }
}

void addLoft(Mesh& mesh, std::span<const glm::dvec3> low, std::span<const glm::dvec3> high) {
    const size_t n = low.size();
    addFace(mesh, std::vector<glm::dvec3>(low.rbegin(), low.rend()));
    addFace(mesh, high);
    for (size_t i = 0, j = n - 1; i < n; j = i++) addFace(mesh, {low[j], low[i], high[i], high[j]});
}

void addFrustum(Mesh& mesh, const glm::dvec4& lo, double zLo, const glm::dvec4& hi, double zHi) {
    const std::array<glm::dvec3, 4> low{{{lo.x, lo.y, zLo}, {lo.z, lo.y, zLo}, {lo.z, lo.w, zLo}, {lo.x, lo.w, zLo}}};
    const std::array<glm::dvec3, 4> high{{{hi.x, hi.y, zHi}, {hi.z, hi.y, zHi}, {hi.z, hi.w, zHi}, {hi.x, hi.w, zHi}}};
    addLoft(mesh, low, high);
}

void addBox(Mesh& mesh, const glm::dvec3& lo, const glm::dvec3& hi) { addFrustum(mesh, {lo.x, lo.y, hi.x, hi.y}, lo.z, {lo.x, lo.y, hi.x, hi.y}, hi.z); }

void addCone(Mesh& mesh, const glm::dvec3& a, double radiusA, const glm::dvec3& b, double radiusB, int sides) {
    const glm::dvec3 axis = (b - a) / std::sqrt(glm::dot(b - a, b - a));
    const glm::dvec3 helper = std::abs(axis.z) > 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
    glm::dvec3 u = glm::cross(helper, axis);
    u /= std::sqrt(glm::dot(u, u));
    const glm::dvec3 v = glm::cross(axis, u);
    std::vector<glm::dvec3> low, high;
    for (int k = 0; k < sides; ++k) {
        const base::det::SinCos t = base::det::sinCos(2 * base::det::kPi * (k + 0.5) / sides);
        low.push_back(a + (u * t.cos + v * t.sin) * radiusA);
        high.push_back(b + (u * t.cos + v * t.sin) * radiusB);
    }
    addLoft(mesh, low, high);
}

void addPrism(Mesh& mesh, const Region& region, const Prism& prism) {
    const std::vector<glm::dvec2> outline = tidied(region);
    if (outline.size() < 3) return;
    const auto rise = [&](const glm::dvec2& p) {
        if (!prism.eaves) return 0.0;
        const double d = prism.eaves->distance(p);
        return prism.fold > 0 && d > prism.fold ? 2 * prism.fold - d : d;
    };
    const auto low = [&](const glm::dvec2& p) { return glm::dvec3(p, prism.floor + prism.floorSlope * rise(p)); };
    const auto high = [&](const glm::dvec2& p) { return glm::dvec3(p, prism.roof + prism.slope * rise(p)); };

    // The outline with the two points where the ridge crosses it, and its two sides.
    std::vector<glm::dvec2> ring, front, back;
    const auto side = [&](const glm::dvec2& p) {
        if (!(prism.eaves && prism.fold > 0)) return -1;
        const double d = prism.eaves->distance(p) - prism.fold;
        return std::abs(d) < 0.02 ? 0 : d > 0 ? 1 : -1;
    };
    for (size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 p = outline[i], q = outline[(i + 1) % outline.size()];
        const int here = side(p), there = side(q);
        ring.push_back(p);
        if (here <= 0) front.push_back(p);
        if (here >= 0) back.push_back(p);
        if (here * there >= 0) continue;
        const double a = prism.eaves->distance(p) - prism.fold, b = prism.eaves->distance(q) - prism.fold;
        const glm::dvec2 m = p + (q - p) * (a / (a - b));
        ring.push_back(m), front.push_back(m), back.push_back(m);
    }
    std::vector<glm::dvec3> face;
    for (const std::vector<glm::dvec2>& half : {front, back}) {
        if (half.size() < 3) continue;
        face.clear();
        for (const glm::dvec2& p : half) face.push_back(high(p));
        addFace(mesh, face);
        face.clear();
        for (size_t i = half.size(); i-- > 0;) face.push_back(low(half[i]));
        addFace(mesh, face);
    }
    for (size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) addFace(mesh, {low(ring[j]), low(ring[i]), high(ring[i]), high(ring[j])});
}

void addRing(Mesh& mesh, const glm::dvec2& lo, const glm::dvec2& hi, double thickness, double floor, double roof) {
    const std::array<glm::dvec2, 4> outer{{lo, {hi.x, lo.y}, hi, {lo.x, hi.y}}};
    std::array<glm::dvec2, 4> inner;
    const glm::dvec2 sign[4] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    for (size_t i = 0; i < 4; ++i) inner[i] = outer[i] + thickness * sign[i];
    const auto at = [](const glm::dvec2& p, double z) { return glm::dvec3(p, z); };
    for (size_t i = 0, j = 3; i < 4; j = i++) {
        addFace(mesh, {at(outer[j], floor), at(outer[i], floor), at(outer[i], roof), at(outer[j], roof)});
        addFace(mesh, {at(inner[i], floor), at(inner[j], floor), at(inner[j], roof), at(inner[i], roof)});
        addFace(mesh, {at(outer[j], roof), at(outer[i], roof), at(inner[i], roof), at(inner[j], roof)});
        addFace(mesh, {at(outer[i], floor), at(outer[j], floor), at(inner[j], floor), at(inner[i], floor)});
    }
}

}  // namespace dapple::scenegen::city
