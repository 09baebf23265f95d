#include "shadow/map/caster_cull.h"

#include <algorithm>

namespace dapple::shadow {

std::vector<glm::dvec2> convexHull(std::vector<glm::dvec2> points) {
    std::vector<glm::dvec2> hull;
    std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    const auto turnsRight = [&](const glm::dvec2& p) {
        const glm::dvec2 a = hull[hull.size() - 2], b = hull.back();
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) <= 0;
    };
    for (int half = 0; half < 2 && !points.empty(); ++half) {
        const size_t start = hull.size();
        for (const glm::dvec2& p : points) {
            while (hull.size() >= start + 2 && turnsRight(p)) hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

CasterCull::CasterCull(const LightBasis& basis, const frame::Camera& camera, const std::vector<glm::dvec3>& body, double margin) {
    double extent = 0;
    for (const glm::dvec3& p : body) extent = std::max(extent, glm::length(p));
    margin += 1e-6 * extent;  // vertices are transformed in float
    // What the sweep moves inward does not separate.
    const auto addSide = [&](const glm::dvec3& direction) {
        const double length = glm::length(direction);
        if (length < 1e-9 || glm::dot(direction, basis.l) < -1e-9 * length) return;
        Side side{direction / length, -1e300};
        for (const glm::dvec3& p : body) side.limit = std::max(side.limit, glm::dot(side.outward, p) + margin);
        sides_.push_back(side);
    };
    addSide(basis.l);
    for (const glm::dvec4& plane : camera.planes()) addSide(-glm::dvec3(plane));
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            glm::dvec3 e(0);
            e[axis] = sign;
            addSide(e);
            addSide(glm::cross(e, basis.l));  // across the edges of the box's silhouette
        }
    std::vector<glm::dvec2> points;
    for (const glm::dvec3& p : body) points.emplace_back(basis.toLight(p));
    const std::vector<glm::dvec2> hull = convexHull(std::move(points));
    for (size_t i = 0; i < hull.size(); ++i) {
        const glm::dvec2 edge = hull[(i + 1) % hull.size()] - hull[i];
        addSide(basis.u * edge.y - basis.v * edge.x);
    }
}

bool CasterCull::keep(const base::DBox& box) const {
    if (box.empty()) return false;
    const glm::dvec3 centre = box.centre(), half = box.halfSize();
    return std::none_of(sides_.begin(), sides_.end(), [&](const Side& side) {
        return glm::dot(side.outward, centre) - glm::dot(glm::abs(side.outward), half) > side.limit;
    });
}

void CasterCull::appendPlanes(std::vector<glm::dvec4>& planes) const {
    for (const Side& side : sides_) planes.emplace_back(-side.outward, side.limit);
}

std::vector<uint32_t> CasterCull::kept(const gpuscene::Hierarchy& hierarchy, std::span<const base::Box> boxes, const glm::dvec3& eye) const {
    const auto relative = [&](const base::Box& box) { return base::DBox{glm::dvec3(box.lo) - eye, glm::dvec3(box.hi) - eye}; };
    std::vector<uint32_t> result, nodes;
    hierarchy.select([&](const base::Box& nodeBox) {
        base::DBox box = relative(nodeBox);
        const double slack = 1e-12 * (glm::length(box.lo) + glm::length(box.hi));  // what the test of a box within may round otherwise
        box.lo -= slack;
        box.hi += slack;
        return keep(box);
    }, 1, nodes);
    for (const uint32_t n : nodes)
        for (const uint32_t i : hierarchy.items(n))
            if (!boxes[i].empty() && keep(relative(boxes[i]))) result.push_back(i);
    std::ranges::sort(result);
    return result;
}

}  // namespace dapple::shadow
