#pragma once

#include "base/random.h"
#include "frame/camera.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

/// A hand-made scene, and a ray caster that knows nothing of the renderer: every triangle, in doubles.
namespace dapple::frame {

inline void addQuad(scenegen::Mesh& mesh, const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
    const auto first = uint32_t(mesh.positions.size());
    for (const glm::vec2 t : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        mesh.positions.push_back(corner + u * t.x + v * t.y);
        mesh.normals.push_back(glm::normalize(glm::cross(u, v)));
        mesh.uvs.push_back(t * 2.0f);  // the texture twice across
    }
    for (const uint32_t i : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + i);
}

inline constexpr uint32_t kGround = 0, kBox = 1, kFence = 2;

/// A ground of 60 m, boxes strewn on it, two fences of alpha-tested texels in front.
inline scenegen::Scene yard(int boxes) {
    scenegen::Scene scene;
    scene.name = "yard";
    base::Random random(11, 0, 0);
    scenegen::Texture lattice{"lattice", {8, 8, 4, {}}};
    for (int i = 0; i < 64; ++i) {
        for (int k = 0; k < 3; ++k) lattice.image.texels.push_back(uint8_t(random.next(0, 256)));
        // Both sides of the threshold, as near to it as 8 bits allow: 127/255 < 0.5 < 128/255.
        lattice.image.texels.push_back(std::array<uint8_t, 4>{0, 127, 128, 255}[size_t(random.next(0, 4))]);
    }
    scene.textures.push_back(lattice);
    scene.materials.resize(3);
    scene.materials[kBox].doubleSided = false;
    scene.materials[kFence].texture = 0;
    scene.materials[kFence].alphaTested = true;

    scene.prototypes.resize(3);
    for (uint32_t p = 0; p < 3; ++p) scene.prototypes[p].meshes.emplace_back().material = p;
    addQuad(scene.prototypes[kGround].meshes[0], {-30, -30, 0}, {60, 0, 0}, {0, 60, 0});
    scene.prototypes[kBox].closed = true;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-0.5f, 0.5f}) {
            glm::vec3 corner(-0.5f, -0.5f, 0), u(0), v(0);
            corner[axis] = axis == 2 ? side + 0.5f : side;
            u[(axis + (side > 0 ? 1 : 2)) % 3] = 1;
            v[(axis + (side > 0 ? 2 : 1)) % 3] = 1;
            addQuad(scene.prototypes[kBox].meshes[0], corner, u, v);
        }
    addQuad(scene.prototypes[kFence].meshes[0], {-1, 0, 0}, {2, 0, 0}, {0, 0, 2});

    scene.instances.push_back({{0, 0, 0}, 1, 0, kGround});
    scene.instances.push_back({{-1.3f, -10.1f, 0.1f}, 1.1f, 0.4f, kFence});
    scene.instances.push_back({{1.9f, -9.2f, 0.3f}, 1.3f, 2.9f, kFence});
    for (int i = 0; i < boxes; ++i)
        scene.instances.push_back({{random.next(-25, 25), random.next(-7, 25), 0}, random.next(0.5f, 3), random.next(0, 6.28f), kBox});
    scene.views.push_back({"yard", {0.3, -15.7, 2.4}, glm::normalize(glm::dvec3(0.02, 1, -0.12)), {0, 0, 1}, 55, 0.3, 300});
    scene.sun = {200, 40};
    return scene;
}

struct Hit {
    double distance = std::numeric_limits<double>::infinity();  ///< in units of the ray's direction
    glm::dvec3 normal{0};                                       ///< geometric, unit, on the viewer's side
    glm::dvec2 uv{0};
    size_t surface = 0;                                         ///< the same for the two triangles of one quad
};

/// Every triangle of the scene, relative to an eye.
class RayCaster {
public:
    RayCaster(const scenegen::Scene& scene, const glm::dvec3& eye) : scene_(&scene) {
        for (size_t i = 0; i < scene.instances.size(); ++i) {
            const scenegen::Instance& instance = scene.instances[i];
            const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw)), k = double(instance.scale);
            for (const scenegen::Mesh& mesh : scene.prototypes[instance.prototype].meshes)
                for (size_t t = 0; t < mesh.indices.size(); t += 3) {
                    Triangle triangle{{}, {}, mesh.material, i * 100 + t / 6};
                    for (size_t j = 0; j < 3; ++j) {
                        const glm::dvec3 p(mesh.positions[mesh.indices[t + j]]);
                        triangle.p[j] = glm::dvec3(instance.translation) - eye + k * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
                        triangle.uv[j] = glm::dvec2(mesh.uvs[mesh.indices[t + j]]);
                    }
                    triangles_.push_back(triangle);
                }
        }
    }

    /// Alpha of the texel under `uv`: nearest, repeated; rows from the top.
    double alpha(uint32_t material, glm::dvec2 uv) const {
        const base::Image8& image = scene_->textures[size_t(scene_->materials[material].texture)].image;
        uv -= glm::floor(uv);
        return image.at(int(uv.x * image.width), int(uv.y * image.height))[3] / 255.0;
    }

    /// The closest hit from the eye along `ray`. `solid`: fences have no holes.
    Hit closest(const glm::dvec3& ray, bool solid = false) const {
        Hit best;
        for (const Triangle& t : triangles_) {
            const glm::dvec3 e1 = t.p[1] - t.p[0], e2 = t.p[2] - t.p[0], n = glm::cross(e1, e2);
            const double facing = glm::dot(n, ray);
            if (facing == 0) continue;
            const double distance = glm::dot(n, t.p[0]) / facing;
            if (distance <= 0 || distance >= best.distance) continue;
            const glm::dvec3 q = ray * distance - t.p[0];
            const double u = glm::dot(glm::cross(q, e2), n) / glm::dot(n, n), v = glm::dot(glm::cross(e1, q), n) / glm::dot(n, n);
            if (u < 0 || v < 0 || u + v > 1) continue;
            const glm::dvec2 uv = t.uv[0] * (1 - u - v) + t.uv[1] * u + t.uv[2] * v;
            if (!solid && scene_->materials[t.material].alphaTested && alpha(t.material, uv) < 0.5) continue;
            best = {distance, glm::normalize(facing > 0 ? -n : n), uv, t.surface};
        }
        return best;
    }

private:
    struct Triangle {
        std::array<glm::dvec3, 3> p;
        std::array<glm::dvec2, 3> uv;
        uint32_t material;
        size_t surface;
    };
    const scenegen::Scene* scene_;
    std::vector<Triangle> triangles_;
};

/// Ray through the centre of a pixel, rows from the top; eye depth 1.
inline glm::dvec3 pixelRay(const scenegen::View& view, int width, int height, int x, int y) {
    const glm::dvec3 right = glm::normalize(glm::cross(view.forward, view.up)), up = glm::cross(right, view.forward);
    const double t = std::tan(glm::radians(view.fovY) / 2);
    return view.forward + right * (t * width / height * ((2.0 * x + 1) / width - 1)) - up * (t * ((2.0 * y + 1) / height - 1));
}

}  // namespace dapple::frame
