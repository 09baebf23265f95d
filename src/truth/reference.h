#pragma once

#include "scenegen/scene.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace dapple::truth {

/// Receiver points of one view, as the G-buffer holds them. All arrays are width · height, rows from the top.
struct Receivers {
    int width = 0, height = 0;
    std::vector<glm::vec3> position;  ///< metres, relative to the eye, world axes
    std::vector<glm::vec3> normal;    ///< geometric, unit, on the viewer's side
    std::vector<uint8_t> present;     ///< 0 = sky
};

enum class Label : uint8_t {
    excluded,   ///< sky, or N_geo · (−l) ≤ 0.02: the surface looks away from the sun or grazes it
    lit,
    shadowed,
    ambiguous,  ///< offsets ε, 4ε and 16ε of the ray's start disagree: no reference can decide
};

/// The truth for one view and sun, rows from the top.
struct Reference {
    int width = 0, height = 0;
    std::vector<Label> label;
    /// Share of the sun's light, the product of the transmittances of the distinct instances in its way; labels are then those
    /// of a threshold of ½. Empty where no caster lets light through: the labels say it all.
    std::vector<float> transmitted = {};

    /// G of a pixel that is lit or shadowed.
    float value(size_t pixel) const { return transmitted.empty() ? float(label[pixel] == Label::lit) : transmitted[pixel]; }
};

/// Ray-traces shadows of one scene with Embree. Building it costs the acceleration structures of the casting
/// prototypes; trace() may then be called for any number of views and suns, from several threads. The scene
/// need not outlive it. Alpha-tested triangles block only where the texture's alpha, sampled as GL_NEAREST
/// of level 0 with the texture's wraps, reaches the material's alphaCutoff. Throws base::Error when Embree cannot run or has no memory.
///
/// Rays run from the receiver to the sun, the start offset along the geometric normal by
///     ε = 8 ulp(max |p|) + 1e-6 · edge + 2e-6 · distance from the eye
/// (rounding of the receiver's coordinates; of Embree's hit with the receiver's own triangle, whose longest edge
/// it is; of the depth buffer the receiver came from), by 4 ε and by 16 ε. A receiver on a caster starts one ulp of its
/// distance to that instance's origin farther in all three cases, because Embree rounds in the prototype's space.
/// 3 m from the eye ε is some 10 µm and 16 ε 0.2 mm, well below a pixel: contact shadows are kept.
class Tracer {
public:
    explicit Tracer(const scenegen::Scene& scene);
    ~Tracer();
    Tracer(Tracer&&) noexcept;
    Tracer& operator=(Tracer&&) noexcept;

    /// To be called when Scene::moveTo has moved instances of the scene that it was made from.
    void instancesMoved(const scenegen::Scene& scene);

    /// `eye`: metres from Scene::origin; `light`: unit direction in which the light travels, any. With the
    /// sun on or below the horizon (light.z ≥ 0) there is no direct light: what faces it is shadowed. A
    /// receiver that is not finite is excluded.
    Reference trace(const Receivers& receivers, const glm::dvec3& eye, const glm::dvec3& light) const;
    /// The casters that shadow some receiver, nearest to it or not: those that a ray to the sun meets from a receiver that faces
    /// it (trace()'s rays at 4 ε). Indices into Scene::instances, ascending.
    std::vector<uint32_t> contributors(const Receivers& receivers, const glm::dvec3& eye, const glm::dvec3& light) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Reference from the cache folder, or traced and stored there. The key is the content: scene hash,
/// receivers, eye, light and the version of the tracer. A damaged entry is traced anew with a warning; a
/// folder that cannot be written costs one warning per process and nothing else.
Reference cachedReference(const Tracer& tracer, uint64_t sceneHash, const Receivers& receivers, const glm::dvec3& eye,
                          const glm::dvec3& light, const std::filesystem::path& cacheFolder);

}  // namespace dapple::truth
