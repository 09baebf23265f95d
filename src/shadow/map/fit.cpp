#include "shadow/map/fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

base::DBox boundsIn(const LightBasis& basis, const std::vector<glm::dvec3>& points) {
    base::DBox bounds;
    for (const glm::dvec3& p : points) bounds.extend(basis.toLight(p));
    return bounds;
}

/// A window that a single point or a flat body leaves without extent gets a millionth of its distance.
void widen(double& lo, double& hi) {
    const double least = std::max(1e-6 * std::max(std::abs(lo), std::abs(hi)), 1e-9);
    if (hi - lo < least) {
        lo -= least / 2;
        hi += least / 2;
    }
}

/// Row-major 4×4 from light coordinates (u, v, l, 1), composed with the basis.
glm::dmat4 compose(const LightBasis& b, const glm::dvec4& rowX, const glm::dvec4& rowY, const glm::dvec4& rowZ, const glm::dvec4& rowW) {
    const auto row = [&](const glm::dvec4& r) { return glm::dvec4(b.u * r.x + b.v * r.y + b.l * r.z, r.w); };
    return glm::transpose(glm::dmat4(row(rowX), row(rowY), row(rowZ), row(rowW)));
}

/// Fraction of the window that stays for the receivers once `padTexels` surround it; tiny maps keep half.
double usableShare(int size, double padTexels) { return std::max(0.5, 1.0 - 2.0 * padTexels / size); }

/// Texels along the light by which the bias moves a receiver, at most: both axes of a plane at truth::kGrazing (lib/bias.glsl).
/// Within them casters must have their depths, and not that of the near plane.
double biasTexels(double padTexels) { return padTexels * std::numbers::sqrt2 / 0.02; }

LightFit orthographic(const LightBasis& basis, base::DBox window, const base::DBox& depthBounds, int size, double padTexels) {
    widen(window.lo.x, window.hi.x);
    widen(window.lo.y, window.hi.y);
    double zNear = depthBounds.lo.z, zFar = depthBounds.hi.z;
    widen(zNear, zFar);
    const double share = usableShare(size, padTexels);
    const glm::dvec2 half = glm::dvec2(window.halfSize()) / share, centre(window.centre());
    LightFit fit;
    fit.maxTexel = 2 * std::max(half.x, half.y) / size;
    zNear -= biasTexels(padTexels) * fit.maxTexel;
    zFar += fit.maxTexel;
    fit.depthRange = zFar - zNear;
    fit.clipFromRelative = compose(basis, {1 / half.x, 0, 0, -centre.x / half.x}, {0, 1 / half.y, 0, -centre.y / half.y},
                                   {0, 0, 1 / fit.depthRange, -zNear / fit.depthRange}, {0, 0, 0, 1});
    return fit;
}

/// Light-space perspective shadow map (Wimmer, Scherzer, Purgathofer 2004), with n_opt from the nearest visible
/// depth z₀ and z₁ = z₀ + d sin γ: n = (z₀ + √(z₀ z₁)) / sin γ. On a degenerate view `fallback` says why.
LightFit lispsm(const LightBasis& basis, const frame::Camera& camera, const std::vector<glm::dvec3>& body, int size, double padTexels) {
    LightFit fit;
    const auto giveUp = [&](const std::string& why) {
        fit.fallback = "lispsm → frustum: " + why;
        return fit;
    };
    const double cosGamma = glm::dot(camera.forward, basis.l), sinGamma = glm::length(glm::cross(camera.forward, basis.l));
    if (std::abs(cosGamma) > 0.9997) return giveUp(fmt::format("view and light are parallel within {:.3g} rad", sinGamma));

    const base::DBox bounds = boundsIn(basis, body);
    const auto eyeDepth = [&](const glm::dvec3& p) { return glm::dot(p, camera.forward); };
    const auto nearest = *std::min_element(body.begin(), body.end(), [&](const auto& a, const auto& b) { return eyeDepth(a) < eyeDepth(b); });
    const double d = bounds.hi.y - bounds.lo.y;
    const double z0 = eyeDepth(nearest), z1 = z0 + d * sinGamma;
    if (!(z0 > 0) || !(z1 > 0)) return giveUp("a visible point is not in front of the eye");
    if (!(z1 / z0 > 1 + 1e-3)) return giveUp("the depth range is too small to warp");
    double n = (z0 + std::sqrt(z0 * z1)) / sinGamma;
    if (!std::isfinite(n) || n > 1e4 * d) return giveUp("the warp is too weak to matter");
    n = std::max(n, 0.02 * d);

    // x' = (x − x_e)/w, y' = (f+n)/(f−n) − 2fn/((f−n) w), z' = (z − z_c)/w with w = y − C_y.
    const double f = n + d, xe = basis.toLight(nearest).x, cy = bounds.lo.y - n, zc = bounds.centre().z;
    const glm::dvec4 w{0, 1, 0, -cy};
    const glm::dvec4 x{1, 0, 0, -xe}, y = w * ((f + n) / (f - n)) - glm::dvec4(0, 0, 0, 2 * f * n / (f - n)), z{0, 0, 1, -zc};
    base::DBox projected;
    double minW = 1e300, maxW = 0;
    for (const glm::dvec3& p : body) {
        const glm::dvec4 q(basis.toLight(p), 1);
        const double pw = glm::dot(w, q);
        minW = std::min(minW, pw);
        maxW = std::max(maxW, pw);
        projected.extend(glm::dvec3(glm::dot(x, q), glm::dot(y, q), glm::dot(z, q)) / pw);
    }
    if (!(minW > 0) || !base::allFinite(projected.lo) || !base::allFinite(projected.hi)) return giveUp("a visible point has w ≤ 0");
    widen(projected.lo.x, projected.hi.x);
    widen(projected.lo.y, projected.hi.y);
    widen(projected.lo.z, projected.hi.z);
    const double share = usableShare(size, padTexels);
    const glm::dvec3 half = projected.halfSize() / glm::dvec3(share, share, 1), centre = projected.centre();
    // Footprints grow with w across the warp and with w² along it; both are largest at the far end.
    const double along = half.y * 2 / size * maxW * maxW * (f - n) / (2 * f * n), across = half.x * 2 / size * maxW;
    fit.maxTexel = std::max(along, across);
    // A texel over w is largest at the far end, too.
    const double texel = fit.maxTexel / maxW, zLo = projected.lo.z - biasTexels(padTexels) * texel, zRange = projected.hi.z + texel - zLo;
    fit.depthRange = zRange * maxW;
    fit.leastW = minW;
    fit.clipFromRelative = compose(basis, (x - w * centre.x) / half.x, (y - w * centre.y) / half.y, (z - w * zLo) / zRange, w);
    return fit;
}

}  // namespace

LightBasis lightBasis(const glm::dvec3& light, const glm::dvec3& viewForward) {
    glm::dvec3 reference = viewForward;
    if (std::abs(glm::dot(viewForward, light)) >= 0.9997) reference = std::abs(light.z) < 0.99 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    const glm::dvec3 v = glm::normalize(reference - light * glm::dot(reference, light));
    return {glm::cross(light, v), v, light};
}

std::vector<glm::dvec3> viewBody(const frame::Camera& camera, double near, double far, const base::DBox& box) {
    if (box.empty()) return {};
    std::vector<glm::dvec4> planes;
    for (const glm::dvec4& plane : camera.planes()) planes.push_back(plane);
    planes[0].w = -near;
    planes[1].w = far;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec4 lower(0), upper(0);
        lower[axis] = 1;
        lower.w = -box.lo[axis];
        upper[axis] = -1;
        upper.w = box.hi[axis];
        planes.push_back(lower);
        planes.push_back(upper);
    }
    // Twelve half-spaces: every vertex of their intersection is where three planes meet and none excludes it.
    std::vector<glm::dvec3> vertices;
    for (size_t i = 0; i < planes.size(); ++i)
        for (size_t j = i + 1; j < planes.size(); ++j)
            for (size_t k = j + 1; k < planes.size(); ++k) {
                const glm::dvec3 a(planes[i]), b(planes[j]), c(planes[k]);
                const double det = glm::dot(a, glm::cross(b, c));
                if (std::abs(det) < 1e-12) continue;
                const glm::dvec3 p = -(planes[i].w * glm::cross(b, c) + planes[j].w * glm::cross(c, a) + planes[k].w * glm::cross(a, b)) / det;
                const double slack = 1e-9 * (glm::length(p) + near);
                const bool inside = std::all_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) {
                    return glm::dot(glm::dvec3(plane), p) + plane.w >= -slack;
                });
                if (inside) vertices.push_back(p);
            }
    return vertices;
}

std::vector<glm::dvec3> visibleBody(const frame::Camera& camera, double near, double far, std::span<const base::DBox> boxes) {
    std::array<glm::dvec4, 6> planes = camera.planes();
    planes[0].w = -near;
    planes[1].w = far;
    std::vector<glm::dvec3> body;
    for (const base::DBox& box : boxes) {
        bool meets = !box.empty(), whole = meets;
        for (const glm::dvec4& plane : planes) {
            const glm::dvec3 n(plane);
            const double centre = glm::dot(n, box.centre()) + plane.w, reach = glm::dot(glm::abs(n), box.halfSize());
            meets &= centre + reach >= 0;
            whole &= centre - reach >= 0;
        }
        if (whole) {
            for (int corner = 0; corner < 8; ++corner)
                body.emplace_back(corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y, corner & 4 ? box.hi.z : box.lo.z);
        } else if (meets) {
            const std::vector<glm::dvec3> part = viewBody(camera, near, far, box);
            body.insert(body.end(), part.begin(), part.end());
        }
    }
    return body;
}

LightFit fitLight(FitKind kind, const LightBasis& basis, const frame::Camera& camera, const std::vector<glm::dvec3>& body,
                  const base::DBox& sceneBounds, int size, double padTexels) {
    LightFit fit;
    if (body.empty()) {
        fit.empty = true;
        return fit;
    }
    const base::DBox bodyBounds = boundsIn(basis, body);
    if (kind == FitKind::scene) return orthographic(basis, sceneBounds, bodyBounds, size, padTexels);
    if (kind == FitKind::lispsm) {
        fit = lispsm(basis, camera, body, size, padTexels);
        if (fit.fallback.empty()) return fit;
    }
    const std::string fallback = fit.fallback;
    fit = orthographic(basis, bodyBounds, bodyBounds, size, padTexels);
    fit.fallback = fallback;
    return fit;
}

std::vector<double> practicalSplits(double near, double far, int count, double lambda) {
    near = std::max(near, far * 1e-4);
    std::vector<double> splits;
    for (int i = 0; i <= count; ++i) {
        const double t = double(i) / count;
        splits.push_back(lambda * near * std::pow(far / near, t) + (1 - lambda) * (near + t * (far - near)));
    }
    return splits;
}

}  // namespace dapple::shadow
