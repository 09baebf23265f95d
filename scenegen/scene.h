#pragma once

#include "base/image.h"
#include "base/math.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// The scene: what a recipe or a file becomes, and all that the renderer and the reference read.
///
/// Space. World is right-handed, metres, z up. World point of a prototype's vertex p under an instance:
///     scene.origin + instance.translation + scale · Rz(yaw) · p
/// `origin` alone is double: moving a scene 1,000 km changes only it, so nothing else loses a bit.
/// Texture coordinates: (0,0) is the first texel of the image's top row, v grows downwards.
namespace dapple::scenegen {

/// What a texture shows beyond [0, 1]: glTF's and GL's REPEAT, CLAMP_TO_EDGE and MIRRORED_REPEAT.
enum class Wrap { repeat, clamp, mirror };

struct Texture {
    std::string name;
    base::Image8 image;  ///< RGBA, sRGB colour, linear alpha
    Wrap wrapU = Wrap::repeat, wrapV = Wrap::repeat;
};

/// Camera, maps and reference use the same cut-off: a difference would be booked as aliasing.
inline constexpr float kAlphaCutoff = 0.5f;

struct Material {
    std::string name;
    glm::vec3 albedo{0.5f};      ///< linear, multiplies the texture
    float specular = 0.0f;       ///< strength of the highlight, 0…1
    float shininess = 16.0f;     ///< Blinn-Phong exponent
    int texture = -1;            ///< index into Scene::textures; -1 = none
    bool alphaTested = false;    ///< fragments whose texture's alpha is below alphaCutoff do not exist
    float alphaCutoff = kAlphaCutoff;  ///< (0, 1]; a file's cut-off divided by its opacity factor
    bool doubleSided = true;     ///< false: back faces are never seen, the mesh is closed
};
/// Triangles of one material, in the prototype's space. positions, normals and uvs are parallel.
struct Mesh {
    std::vector<glm::vec3> positions;  ///< metres
    std::vector<glm::vec3> normals;    ///< unit length, outward
    std::vector<glm::vec2> uvs;        ///< empty when the material has no texture
    std::vector<uint32_t> indices;     ///< 3 per triangle, counter-clockwise seen from outside
    uint32_t material = 0;             ///< index into Scene::materials

    size_t triangles() const { return indices.size() / 3; }
};

/// What is drawn once per instance: a tree, a house, the ground.
struct Prototype {
    std::string name;
    std::vector<Mesh> meshes;
    bool castsShadow = true;  ///< false: a receiver only (ground, sky-facing terrain without overhangs)
    bool closed = false;      ///< every mesh is a closed, oriented 2-manifold (tested, not declared by hand)
    bool moving = false;      ///< its shape is that of one moment
    float transmittance = 0;  ///< share of the sun's light that its shadow lets through, [0, 1); its picture is opaque

    size_t triangles() const;
    base::Box box() const;  ///< prototype space; empty when there is no vertex
};

/// A similarity about the vertical: what an instanced shadow map can share.
struct Instance {
    glm::vec3 translation{0};  ///< metres from Scene::origin
    float scale = 1;           ///< > 0, uniform
    float yaw = 0;             ///< radians about +z, counter-clockwise seen from above
    uint32_t prototype = 0;
};
static_assert(sizeof(Instance) <= 32);

/// A named camera pose. `eye` is in metres from Scene::origin.
struct View {
    std::string name;
    glm::dvec3 eye{0};
    glm::dvec3 forward{0, 1, 0};  ///< unit
    glm::dvec3 up{0, 0, 1};       ///< unit, not parallel to forward
    double fovY = 60;             ///< vertical field of view, degrees
    double near = 0.3, far = 300; ///< metres
};

/// A light so far off that its rays are parallel.
struct Sun {
    double azimuth = 135;    ///< degrees, direction TO the sun, clockwise from north (+y) seen from above
    double elevation = 45;   ///< degrees above the horizon; ≤ 0: no direct light
    double strength = 1;     ///< of its light, the noon sun's being 1; that of Scene::sun is 1

    /// Unit direction in which the light travels (away from the sun).
    glm::dvec3 direction() const;
};

/// The shading adds up so many.
inline constexpr size_t kMostSuns = 4;

/// A lamp, as KHR_lights_punctual has it: of `intensity` / d² at the distance d on a surface that faces it, fading to 0 at
/// `range`, and from the inner to the outer angle about its axis.
struct LocalLight {
    glm::vec3 position{0};          ///< metres from Scene::origin
    glm::vec3 direction{0, 0, -1};  ///< unit, axis of the cone
    glm::vec3 intensity{10};        ///< linear; the noon sun's light is about 2.5 on a surface that faces it
    float range = 20;               ///< metres, > 0
    float innerAngle = 0, outerAngle = 3.14159274f;  ///< radians from the axis, 0 ≤ inner < outer ≤ π (a lamp without a shade)
};

/// An instance that drives for ever round a closed way: from `from` to `to`, by a left turn onto the way back, back, and by
/// the same turn to where it began. A turn is an arc to the right that makes room for it, more than half a circle to the left, and an
/// arc to the right; where `radius` is half of `across`, half a circle. Position and heading are continuous.
struct Motion {
    uint32_t instance = 0;
    glm::vec3 from{0}, to{0};  ///< metres from Scene::origin, apart in the plane
    float speed = 0;           ///< metres per second, ≥ 0
    float start = 0;           ///< metres beyond `from` at time 0
    float across = 4;          ///< metres from the way there to the way back, on its left, > 0
    float radius = 4;          ///< metres, of all arcs, ≥ across / 2

    struct Pose {
        glm::vec3 translation;  ///< metres from Scene::origin
        float yaw;              ///< radians; 0: heading along +x
    };
    Pose at(double seconds) const;
    double turn() const;  ///< metres, the length of a turn
    double lap() const;   ///< metres round the whole way
    /// Metres that the middle of the turn's circle lies beyond `to` (it is half of `across` to its left).
    double turnBeyond() const;
    double swing() const;  ///< radians of the arcs to the right
};

/// What a scene has, derived from its content and never declared: later stages leave out what is absent.
struct Facts {
    bool alphaTested = false;    ///< some material of a used prototype is alpha-tested
    bool rotated = false;        ///< some instance of a casting prototype has yaw ≠ 0 (mod 2π)
    bool scaled = false;         ///< some instance has scale ≠ 1
    bool closed = false;         ///< every casting prototype is closed
    bool moving = false;         ///< some instance drives, or has a shape that wind bends
    bool translucent = false;    ///< some casting prototype lets light through
    bool casters = false;        ///< there is at least one casting triangle
    bool receivers = false;      ///< there is at least one triangle
    double depthRange = 1;       ///< largest far / near of the views
    size_t suns = 1;             ///< each casts shadows of its own
    size_t lights = 0;           ///< local lights
    size_t instances = 0, prototypes = 0, materials = 0;
    size_t triangles = 0;        ///< over all instances
    size_t uniqueTriangles = 0;  ///< over the prototypes
    base::Box box;               ///< of all instances, metres from Scene::origin
};

struct Scene {
    std::string name;
    std::string source;  ///< recipe or file it came from, for run.json
    glm::dvec3 origin{0};
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Prototype> prototypes;
    std::vector<Instance> instances;
    std::vector<View> views;  ///< at least one
    Sun sun;
    std::vector<Sun> furtherSuns;  ///< as a window's reflection or a floodlight far off may be; at most kMostSuns with the first
    std::vector<LocalLight> lights;
    std::vector<Motion> motions;  ///< of moving instances; their poses are those of `time`
    double time = 0;              ///< seconds, of the last moveTo(); not part of the content, which has the poses
    std::vector<std::string> dropped;  ///< what dropBadInstances() has removed and why; not part of the content
    std::vector<std::string> notes;    ///< what its file asks for and this scene does not do, a sentence each; not part of the content

    /// Sets the translations and yaws of the moving instances to those at a time. What the wind bends is not touched: shapes are
    /// those of the recipe's time.
    void moveTo(double seconds);

    Facts facts() const;
    /// Hash of all content but `name` and `source`: equal scenes render equal pixels.
    uint64_t contentHash() const;
    /// Index of the named view. Throws UsageError naming the known ones.
    size_t viewIndex(const std::string& name) const;
};

/// Box of an instance, metres from Scene::origin: the eight corners of the prototype's box, transformed.
base::Box instanceBox(const base::Box& prototypeBox, const Instance& instance);

/// Removes the instances, by index, that `keep` does not accept, with their motions.
void keepInstances(Scene& scene, const std::function<bool(size_t instance)>& keep);

/// Removes the instances that can stand nowhere (a transform that is not finite, a scale that is not above 0, a box beyond 1e9 m), with
/// their motions, and appends a line for each to Scene::dropped. What is left is as if they had never been there.
void dropBadInstances(Scene& scene);

/// Throws UsageError, with the offending item, if any number is not finite, an index is out of range, a
/// scale is ≤ 0 or there is no view: everything behind this call may rely on it.
void validate(const Scene& scene);

}  // namespace dapple::scenegen
