#include "visibility/view.h"

#include <algorithm>
#include <cmath>

namespace dapple::visibility {
namespace {

/// Half-space row · (p, 1) ≥ 0 with a unit normal, or nothing where the row has no direction (it bounds nothing).
void addPlane(std::vector<glm::dvec4>& planes, const glm::dvec4& row) {
    const double length = glm::length(glm::dvec3(row));
    if (length > 0) planes.push_back(row / length);
}

glm::dvec4 row(const glm::dmat4& m, int i) { return {m[0][i], m[1][i], m[2][i], m[3][i]}; }

void addSides(CullView& view) {
    const glm::dvec4 w = row(view.clipFromRelative, 3);
    for (int i = 0; i < 2; ++i)
        for (const double sign : {1.0, -1.0}) addPlane(view.planes, w + row(view.clipFromRelative, i) * sign);
}

/// Greatest distance of a corner from the eye: what the rounding of floats is proportional to.
double reach(const base::DBox& box) { return glm::length(glm::max(glm::abs(box.lo), glm::abs(box.hi))); }

/// Largest singular value of the inverse: metres per pixel in the direction that a pixel spans most.
double longestPixel(const glm::dvec2& x, const glm::dvec2& y) {
    const double det = std::abs(x.x * y.y - x.y * y.x), squares = glm::dot(x, x) + glm::dot(y, y);
    const double largest = std::sqrt((squares + std::sqrt(std::max(0.0, squares * squares - 4 * det * det))) / 2);
    return largest / det;  // smallest = det / largest
}

}  // namespace

CullView CullView::camera(const glm::dvec3& eye, const glm::dmat4& clipFromRelative, double near) {
    CullView view{eye, clipFromRelative, {}, false, glm::normalize(glm::dvec3(row(clipFromRelative, 3))), near};
    addSides(view);
    const glm::dvec4 z = row(clipFromRelative, 2);
    addPlane(view.planes, z);
    addPlane(view.planes, row(clipFromRelative, 3) - z);
    return view;
}

CullView CullView::sun(const glm::dvec3& eye, const glm::dmat4& clipFromRelative, const glm::dvec3& direction) {
    CullView view{eye, clipFromRelative, {}, true, direction, 0};
    addSides(view);
    addPlane(view.planes, row(clipFromRelative, 3) - row(clipFromRelative, 2));
    return view;
}

bool CullView::mayContain(const base::DBox& box) const {
    if (box.empty()) return false;
    const double slack = 1e-6 * reach(box);  // vertices are transformed in float
    return std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
        const glm::dvec3 n(plane);
        const glm::dvec3 farthest(n.x > 0 ? box.hi.x : box.lo.x, n.y > 0 ? box.hi.y : box.lo.y, n.z > 0 ? box.hi.z : box.lo.z);
        return glm::dot(n, farthest) + plane.w >= -slack;
    });
}

double CullView::key(const base::DBox& box) const {
    if (!parallel) return glm::length(glm::clamp(glm::dvec3(0), box.lo, box.hi));
    return glm::dot(axis, box.centre()) - glm::dot(glm::abs(axis), box.halfSize());
}

bool CullView::certainlyVisible(const base::DBox& box) const {
    const glm::dvec4 w = row(clipFromRelative, 3);
    const glm::dvec3 gradient(w);
    if (gradient == glm::dvec3(0)) return false;  // orthographic: w is 1
    const double nearest = glm::dot(gradient, box.centre()) - glm::dot(glm::abs(gradient), box.halfSize()) + w.w;
    // A thousandth of the way from w = 0: there an enlarged box still keeps its distance.
    const double farthest = glm::dot(gradient, box.centre()) + glm::dot(glm::abs(gradient), box.halfSize()) + w.w;
    if (nearest <= 1e-3 * std::max(farthest, 0.0)) return true;
    if (parallel) return false;
    const double depth = nearest / glm::length(gradient);
    return depth <= near * (1 + 1e-6) || key(box) <= near;
}

double CullView::footprint(const base::DBox& box, int width, int height) const {
    // Two directions across the rays, or along the image plane, on which a pixel's span is measured.
    const glm::dvec3 a = glm::normalize(glm::cross(axis, std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0))), b = glm::cross(axis, a);
    const glm::dvec4 rowX = row(clipFromRelative, 0), rowY = row(clipFromRelative, 1), rowW = row(clipFromRelative, 3);
    const auto along = [&](const glm::dvec4& r) { return glm::dvec2(glm::dot(glm::dvec3(r), a), glm::dot(glm::dvec3(r), b)); };
    const glm::dvec2 x = along(rowX), y = along(rowY), w = along(rowW);
    // Derivatives of x/w and y/w. A camera's image plane leaves w alone, so that the span grows with w; in a sun's warped map
    // it grows with w and with the distance across from the middle: the corners hold the longest.
    double longest = 0;
    for (int i = 0; i < 8; ++i) {
        const glm::dvec4 p(box.corner(i), 1);
        const double pw = glm::dot(rowW, p);
        longest = std::max(longest, longestPixel((x - w * (glm::dot(rowX, p) / pw)) * (0.5 * width / pw), (y - w * (glm::dot(rowY, p) / pw)) * (0.5 * height / pw)));
    }
    return longest;
}

}  // namespace dapple::visibility
