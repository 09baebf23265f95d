#include "frame/camera.h"

namespace dapple::frame {

Camera::Camera(const scenegen::View& view, int w, int h)
    : eye(view.eye), right(glm::normalize(glm::cross(view.forward, view.up))), up(glm::cross(right, glm::normalize(view.forward))),
      forward(glm::normalize(view.forward)), near(view.near), far(view.far), tanX(0),
      tanY(std::tan(glm::radians(view.fovY) / 2)), width(w), height(h) {
    tanX = tanY * w / h;
    shiftBy({0, 0});
}

void Camera::shiftBy(const glm::dvec2& pixels) {
    shift = pixels;
    const glm::dvec2 ndc = 2.0 * shift / glm::dvec2(width, height);
    const double a = -near / (far - near), b = near * far / (far - near);
    // Rows of the matrix; glm stores columns, hence the transpose.
    clipFromRelative = glm::transpose(glm::dmat4(glm::dvec4(right / tanX - ndc.x * forward, 0), glm::dvec4(up / tanY - ndc.y * forward, 0),
                                                 glm::dvec4(forward * a, b), glm::dvec4(forward, 0)));
}

glm::dvec3 Camera::relativePoint(int x, int y, double depth) const {
    const double ndcX = 2 * (x + 0.5 + shift.x) / width - 1, ndcY = 2 * (y + 0.5 + shift.y) / height - 1;
    return (right * (ndcX * tanX) + up * (ndcY * tanY) + forward) * eyeDepth(depth);
}

std::array<glm::dvec4, 6> Camera::planes() const {
    const auto side = [&](const glm::dvec3& axis, double tangent) {
        return glm::dvec4(glm::normalize(forward * tangent + axis), 0);
    };
    const glm::dvec2 ndc = 2.0 * shift / glm::dvec2(width, height);
    return {glm::dvec4(forward, -near), glm::dvec4(-forward, far), side(right, tanX * (1 - ndc.x)), side(-right, tanX * (1 + ndc.x)),
            side(up, tanY * (1 - ndc.y)), side(-up, tanY * (1 + ndc.y))};
}

bool Camera::mayContain(const base::DBox& box) const {
    if (box.empty()) return false;
    // A millionth of slack: the vertices are transformed in float. Of the whole box, so that no part of it is kept alone.
    const double slack = 1e-6 * glm::length(glm::max(glm::abs(box.lo), glm::abs(box.hi)));
    for (const glm::dvec4& plane : planes()) {
        const glm::dvec3 n(plane);
        const glm::dvec3 farthest(n.x > 0 ? box.hi.x : box.lo.x, n.y > 0 ? box.hi.y : box.lo.y, n.z > 0 ? box.hi.z : box.lo.z);
        if (glm::dot(n, farthest) + plane.w < -slack) return false;
    }
    return true;
}

}  // namespace dapple::frame
