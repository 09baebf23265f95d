#pragma once

#include "scenegen/scene.h"

#include <embree3/rtcore.h>

#include <array>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace dapple::truth {

struct ReleaseEmbree {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseEmbree>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseEmbree>;

/// Which texels of a texture block light under an alpha cut-off.
struct OpacityMask {
    int width = 0, height = 0;
    scenegen::Wrap wrapU, wrapV;
    std::vector<uint8_t> opaque;  ///< width · height, rows from the top
    bool everywhere = true;

    OpacityMask(const scenegen::Texture& texture, float cutoff);
    /// GL_NEAREST of level 0 with the texture's wraps (OpenGL 4.5, §8.14.3 and table 8.19).
    bool at(glm::vec2 uv) const;
};

/// A casting mesh inside Embree. positions and indices are Embree's own buffers, in prototype space.
struct OccluderMesh {
    const glm::vec3* positions = nullptr;
    const glm::uvec3* triangles = nullptr;
    const OpacityMask* mask = nullptr;                ///< null: every point blocks
    std::vector<std::array<glm::vec2, 3>> cornerUvs;  ///< per triangle; empty without a mask

    float longestEdge(size_t triangle) const;  ///< metres, prototype space
    bool opaque(size_t triangle, float u, float v) const;
};

/// The casters of a scene in Embree's two levels: one acceleration structure per prototype, built once,
/// and one over the instances, built per eye.
class Occluders {
public:
    /// Throws base::Error when Embree cannot run here or has no memory left.
    explicit Occluders(const scenegen::Scene& scene);

    /// Scene::moveTo has moved instances: placements from now on have them where they are.
    void instancesMoved(const scenegen::Scene& scene);

    struct Instance {
        glm::vec3 translation;  ///< relative to the eye, metres
        float scale;
        uint32_t prototype;
    };
    struct Placement {
        SceneHandle scene;
        std::vector<Instance> instances;  ///< by Embree's instance id
    };
    /// The instances in eye-relative coordinates. Embree computes in floats: with the eye as origin, its
    /// rounding is proportional to the distance from the eye, as the G-buffer's is, however far the eye
    /// is from Scene::origin and however large the scene. `eye`: metres from Scene::origin.
    Placement placeAround(const glm::dvec3& eye) const;

    /// Product of the transmittances of the instances that the ray meets, each counted once; 1 if it meets none.
    float transmitted(const Placement& placement, const glm::vec3& start, const glm::vec3& direction) const;
    /// Adds every instance that the ray meets to `met`, as Placement::instances counts them, each once.
    void blockers(const Placement& placement, const glm::vec3& start, const glm::vec3& direction, std::vector<uint32_t>& met) const;
    /// Index into Scene::instances of one of Placement::instances.
    uint32_t sceneInstance(uint32_t placed) const { return sceneInstances_[placed]; }
    bool translucent() const { return translucent_; }

    bool empty() const { return instances_.empty(); }
    const OccluderMesh& mesh(uint32_t prototype, uint32_t geometry) const { return prototypes_[prototype].meshes[geometry]; }
    float reach() const { return reach_; }              ///< largest scaled coordinate of a prototype, metres
    float longestEdge() const { return longestEdge_; }  ///< of all instances, metres

private:
    struct Prototype {
        SceneHandle scene;
        std::vector<OccluderMesh> meshes;
    };
    void build(const scenegen::Scene& scene, uint32_t prototype);
    const OpacityMask* maskOf(const scenegen::Scene& scene, const scenegen::Material& material);
    void requireNoError() const;

    DeviceHandle device_;
    std::map<std::pair<int, float>, OpacityMask> masks_;  ///< by texture and cut-off
    std::vector<Prototype> prototypes_;  ///< one per prototype of the scene; no scene where it casts nothing
    std::vector<scenegen::Instance> instances_;
    std::vector<uint32_t> sceneInstances_;  ///< parallel to instances_
    float reach_ = 0, longestEdge_ = 0;
    std::vector<float> transmittances_;  ///< by prototype
    bool translucent_ = false;
};

}  // namespace dapple::truth
