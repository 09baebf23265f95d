#include "scenegen/views/quick_render.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr int kWidth = 64, kHeight = 48, kMapSize = 2048;
constexpr size_t kMostTriangles = 3'000'000;  ///< kept of a scene
constexpr float kNear = 10;                   ///< metres: a wall before the eye
constexpr float kSteep = 0.7f;                ///< greatest |z| of the normal of a wall, a trunk, most leaves; least of the ground's

/// Calls f(x, y, z) for each pixel centre in a triangle; x and y of its corners are in pixels, z is linear over it.
template <class F>
void fill(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, int width, int height, const F& f) {
    const float area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::abs(area) > 1e-12f)) return;
    const auto clampTo = [](float v, int most) { return int(std::clamp(v, 0.0f, float(most))); };
    const int x0 = clampTo(std::ceil(std::min({a.x, b.x, c.x}) - 0.5f), width), x1 = clampTo(std::floor(std::max({a.x, b.x, c.x}) + 0.5f), width);
    const int y0 = clampTo(std::ceil(std::min({a.y, b.y, c.y}) - 0.5f), height), y1 = clampTo(std::floor(std::max({a.y, b.y, c.y}) + 0.5f), height);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const float px = float(x) + 0.5f, py = float(y) + 0.5f;
            const float u = ((b.x - px) * (c.y - py) - (c.x - px) * (b.y - py)) / area;
            const float v = ((c.x - px) * (a.y - py) - (a.x - px) * (c.y - py)) / area;
            if (u < 0 || v < 0 || u + v > 1) continue;
            f(x, y, u * a.z + v * b.z + (1 - u - v) * c.z);
        }
}

/// Corners of the part of a triangle that lies beyond the near plane; none if there is no such part.
struct Clipped {
    std::array<glm::vec3, 4> at;
    size_t count = 0;
};
Clipped clip(const std::array<glm::vec3, 3>& triangle, float near) {
    Clipped part;
    for (size_t i = 0; i < 3; ++i) {
        const glm::vec3 &a = triangle[i], &b = triangle[(i + 1) % 3];
        if (a.z > near) part.at[part.count++] = a;
        if ((a.z > near) != (b.z > near)) part.at[part.count++] = glm::mix(a, b, (near - a.z) / (b.z - a.z));
    }
    return part;
}

}  // namespace

double Sight::score() const {
    const double facing = shadowed + lit;
    // Most telling is a ground half in shadow; more casters than a third of the picture only hide it.
    const double balance = facing > 0 ? 4 * shadowed * lit / facing : 0;
    return std::min(casters, 0.35) + 1.5 * balance + std::min({sky, 0.25, casters + shadowed}) - 2 * std::max(0.0, near - 0.1) - std::max(0.0, sky - 0.5) - 2 * std::max(0.0, casters - 0.5);
}

QuickRender::QuickRender(const Scene& scene) : toSun_(-scene.sun.direction()) {
    const size_t all = scene.facts().triangles;
    const size_t stride = 1 + all / kMostTriangles;
    for (const Instance& instance : scene.instances) addItem(scene, instance, stride);
    drawSunMap(scene);
}

void QuickRender::addItem(const Scene& scene, const Instance& instance, size_t stride) {
    const Prototype& prototype = scene.prototypes[instance.prototype];
    const float c = std::cos(instance.yaw) * instance.scale, s = std::sin(instance.yaw) * instance.scale;
    const auto place = [&](const glm::vec3& p) {
        return instance.translation + glm::vec3(c * p.x - s * p.y, s * p.x + c * p.y, instance.scale * p.z);
    };
    Item item{glm::vec3(1e30f), glm::vec3(-1e30f), uint32_t(corners_.size()), 0, prototype.castsShadow};
    for (const Mesh& mesh : prototype.meshes)
        for (size_t t = 0; t < mesh.triangles(); t += stride)
            for (size_t k = 0; k < 3; ++k) {
                corners_.push_back(place(mesh.positions[mesh.indices[3 * t + k]]));
                item.lo = glm::min(item.lo, corners_.back());
                item.hi = glm::max(item.hi, corners_.back());
            }
    item.count = uint32_t(corners_.size()) - item.first;
    if (item.count == 0) return;
    items_.push_back(item);
}

void QuickRender::drawSunMap(const Scene& scene) {
    sunMap_.assign(size_t(kMapSize) * kMapSize, -1e30f);
    const glm::vec3 side = glm::normalize(std::abs(toSun_.z) < 0.99f ? glm::cross(glm::vec3(0, 0, 1), toSun_) : glm::vec3(1, 0, 0));
    const glm::vec3 up = glm::cross(toSun_, side);
    const base::Box box = scene.facts().box;
    const glm::vec3 centre = box.centre();
    const float radius = std::max(glm::length(box.halfSize()), 1e-3f), scale = 0.5f * kMapSize / radius;
    sunTexel_ = 1 / scale;
    sunFromWorld_ = glm::transpose(glm::mat4(glm::vec4(scale * side, 0.5f * kMapSize - scale * glm::dot(side, centre)),
                                             glm::vec4(scale * up, 0.5f * kMapSize - scale * glm::dot(up, centre)), glm::vec4(toSun_, 0), glm::vec4(0, 0, 0, 1)));
    const auto project = [&](const glm::vec3& p) { return glm::vec3(sunFromWorld_ * glm::vec4(p, 1)); };
    for (size_t i = 0; i < corners_.size(); i += 3)
        fill(project(corners_[i]), project(corners_[i + 1]), project(corners_[i + 2]), kMapSize, kMapSize, [&](int x, int y, float z) {
            float& texel = sunMap_[size_t(y) * kMapSize + size_t(x)];
            texel = std::max(texel, z);
        });
}

bool QuickRender::inShadow(const glm::vec3& p, float cosine) const {
    const glm::vec3 t = sunFromWorld_ * glm::vec4(p, 1);
    const auto x = size_t(std::clamp(t.x, 0.0f, kMapSize - 1.0f)), y = size_t(std::clamp(t.y, 0.0f, kMapSize - 1.0f));
    return sunMap_[y * kMapSize + x] > t.z + 2 * sunTexel_ / std::max(cosine, 0.01f);  // a texel is that long on the surface
}

Sight QuickRender::look(const View& view) const {
    struct Pixel {
        float distance = 0;  ///< 1 / metres along the view; 0: sky
        glm::vec3 normal{0};
        bool caster = false;
    };
    const glm::vec3 eye(view.eye), forward(view.forward), right = glm::normalize(glm::cross(forward, glm::vec3(view.up))), up = glm::cross(right, forward);
    const float focal = 0.5f * kHeight / std::tan(glm::radians(0.5f * float(view.fovY)));
    std::vector<Pixel> pixels(size_t(kWidth) * kHeight);
    for (const Item& item : items_) {
        // The sphere around the box, against the planes of the picture's pyramid.
        const glm::vec3 toCentre = 0.5f * (item.lo + item.hi) - eye;
        const float radius = 0.5f * glm::length(item.hi - item.lo), depth = glm::dot(toCentre, forward);
        const float reachX = 0.5f * kWidth / focal, reachY = 0.5f * kHeight / focal;
        if (depth < -radius || std::abs(glm::dot(toCentre, right)) > depth * reachX + radius * std::sqrt(1 + reachX * reachX) ||
            std::abs(glm::dot(toCentre, up)) > depth * reachY + radius * std::sqrt(1 + reachY * reachY))
            continue;
        for (uint32_t i = item.first; i < item.first + item.count; i += 3) {
            const auto inView = [&](const glm::vec3& p) { return glm::vec3(glm::dot(p - eye, right), glm::dot(p - eye, up), glm::dot(p - eye, forward)); };
            const auto onPicture = [&](const glm::vec3& p) { return glm::vec3(0.5f * kWidth + focal * p.x / p.z, 0.5f * kHeight - focal * p.y / p.z, 1 / p.z); };
            const Clipped part = clip({inView(corners_[i]), inView(corners_[i + 1]), inView(corners_[i + 2])}, float(view.near));
            for (size_t k = 2; k < part.count; ++k)
                fill(onPicture(part.at[0]), onPicture(part.at[k - 1]), onPicture(part.at[k]), kWidth, kHeight, [&](int x, int y, float inverse) {
                    Pixel& pixel = pixels[size_t(y) * kWidth + size_t(x)];
                    if (inverse <= pixel.distance) return;
                    pixel = {inverse, glm::cross(corners_[i + 1] - corners_[i], corners_[i + 2] - corners_[i]), item.caster};
                });
        }
    }
    Sight sight;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const Pixel& pixel = pixels[size_t(y) * kWidth + size_t(x)];
            if (pixel.distance == 0) {
                sight.sky += 1;
                continue;
            }
            const float z = 1 / pixel.distance;
            const glm::vec3 ray = forward + right * ((float(x) + 0.5f - 0.5f * kWidth) / focal) - up * ((float(y) + 0.5f - 0.5f * kHeight) / focal);
            const bool steep = std::abs(pixel.normal.z) < kSteep * glm::length(pixel.normal);
            // What stands in the middle counts three times as much as what stands at the edge.
            if (pixel.caster && steep) sight.casters += 1.5 - std::abs((double(x) + 0.5) / (0.5 * kWidth) - 1);
            sight.near += steep && z < kNear;
            const float cosine = glm::dot(glm::normalize(glm::dot(pixel.normal, ray) < 0 ? pixel.normal : -pixel.normal), toSun_);
            if (!steep && cosine > 0 && toSun_.z > 0) (inShadow(eye + z * ray, cosine) ? sight.shadowed : sight.lit) += 1;
        }
    for (double* share : {&sight.casters, &sight.shadowed, &sight.lit, &sight.near, &sight.sky}) *share /= kWidth * kHeight;
    return sight;
}

}  // namespace dapple::scenegen
