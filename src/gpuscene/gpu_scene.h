#pragma once

#include "gl/objects.h"
#include "gpuscene/hierarchy.h"
#include "gpuscene/pack.h"
#include "scenegen/scene.h"

#include <functional>
#include <map>
#include <memory>
#include <vector>

namespace dapple::gpuscene {

/// One material of one prototype within the scene's shared buffers.
struct GpuMesh {
    Packing packing;
    size_t indexOffset = 0;  ///< bytes
    uint32_t indexCount = 0;
    int32_t baseVertex = 0;  ///< among the vertices of its kind
    uint32_t material = 0;
    bool alphaTested = false;
    bool cullBack = false;  ///< single-sided material, hence a closed mesh: see Faces

    /// In units of its own indices.
    uint32_t firstIndex() const { return uint32_t(indexOffset / (packing.indices == Packing::Indices::bits32 ? 4 : 2)); }
};

struct GpuPrototype {
    base::Box box;  ///< prototype space
    bool castsShadow = true;
    std::vector<GpuMesh> meshes;
    size_t triangles = 0;
};

/// Per-instance vertex attributes: where an instance stands relative to the eye, so that floats suffice
/// however far the scene lies from the world's origin.
struct InstanceData {
    glm::vec3 position;  ///< metres, relative to the eye
    float scale;
    glm::vec2 cosSinYaw;
};
static_assert(sizeof(InstanceData) == 24);

/// As glDrawElementsIndirect reads it.
struct IndirectCommand {
    uint32_t indices, instances, firstIndex;
    int32_t baseVertex;
    uint32_t firstInstance;
};

/// Instances to draw, grouped by prototype, with their buffer on the GPU; `ranges` index `data`. Where a compute shader has
/// chosen them (InstanceTable), the CPU knows nothing of them: there are `commands`, one for each mesh, and no data.
struct DrawList {
    struct Range {
        uint32_t prototype, first, count;
    };
    std::vector<InstanceData> data;
    std::vector<uint32_t> instances;  ///< index into Scene::instances, parallel to `data`
    std::vector<Range> ranges;
    gl::Buffer buffer;    ///< reused from frame to frame
    gl::Buffer commands;  ///< of a list that was filled on the GPU: IndirectCommand, by prototype and mesh

    void upload() { buffer.update(data.size() * sizeof(InstanceData), data.data()); }
};

/// Draws a list with what the caller has: his programs, target and state. Culling calls it, once or several times a frame.
using Submit = std::function<void(const DrawList&)>;

/// Which meshes of a draw list a draw submits.
enum class Bucket { opaque, alphaTested };
/// Which vertex attributes it reads beside the position.
enum class Attributes { position, positionUv, positionNormal, all };
/// Which faces of closed meshes it rasterises: those that look away change a pixel only where the near plane cuts the mesh.
enum class Faces { front, both };

struct DrawCount {
    size_t draws = 0, triangles = 0;
};

class InstanceTable;

/// A Scene on the GPU: a buffer for each kind of vertices, texture coordinates beside it where there are textures, one index
/// buffer, the textures.
class GpuScene {
public:
    explicit GpuScene(const scenegen::Scene& scene);

    /// To be called when Scene::moveTo has moved instances: their boxes follow.
    void instancesMoved();

    const scenegen::Scene& scene() const { return *scene_; }
    const scenegen::Facts& facts() const { return facts_; }
    std::span<const GpuPrototype> prototypes() const { return prototypes_; }
    /// Boxes of all instances, metres from Scene::origin.
    std::span<const base::Box> instanceBoxes() const { return boxes_; }
    const base::Box& box() const { return box_; }  ///< all of them together
    /// Both are made on first use. The hierarchy is over instances, or over those that cast.
    const InstanceTable& instanceTable() const;
    const Hierarchy& hierarchy(uint64_t leafTriangles, bool castersOnly) const;
    size_t bufferBytes() const;
    size_t textureBytes() const;

    /// Fills and uploads `list` with the instances that `keep` accepts, seen from `eye` (metres from
    /// Scene::origin), nearest first. `keep` gets the index of an instance.
    void collect(const glm::dvec3& eye, const std::function<bool(uint32_t instance)>& keep, DrawList& list) const;
    /// The same with these instances.
    void collect(const glm::dvec3& eye, std::span<const uint32_t> instances, DrawList& list) const;

    /// Submits the meshes of a bucket, their grid set as uGrid on `program`. Unless `attributes` is position alone, the material is set on `program`
    /// (uAlbedo = colour and specular strength, uTextured) and its texture bound to units 0 (colour) and 1
    /// (alpha, nearest texel of level 0 as in the reference).
    DrawCount draw(const DrawList& list, Bucket bucket, Attributes attributes, GLuint program, Faces faces = Faces::front) const;
    /// Whether any mesh is in the bucket; whether an opaque one has a texture.
    bool has(Bucket bucket) const { return bucket == Bucket::opaque ? hasOpaque_ : hasAlpha_; }
    bool hasOpaqueTextures() const { return hasOpaqueTextures_; }

private:
    void setMaterial(uint32_t material, GLuint program) const;
    void drawMeshes(uint32_t prototype, Bucket bucket, Attributes attributes, GLuint program, Faces faces, uint32_t& material,
                    const std::function<void(const GpuMesh&, GLenum indexType)>& submit) const;

    const scenegen::Scene* scene_;
    scenegen::Facts facts_;
    std::vector<GpuPrototype> prototypes_;
    std::vector<base::Box> boxes_;
    base::Box box_;
    std::vector<gl::Texture> textures_;
    static constexpr size_t kKinds = 3;  // of Packing::Vertices
    gl::Buffer vertices_[kKinds], uvs_[kKinds], indices_;
    gl::VertexArray arrays_[kKinds][4];  // by Attributes
    gl::Sampler colourSampler_, alphaSampler_;
    mutable std::shared_ptr<InstanceTable> instanceTable_;
    mutable std::map<std::pair<uint64_t, bool>, Hierarchy> hierarchies_;
    bool hasOpaque_ = false, hasAlpha_ = false, hasOpaqueTextures_ = false;
};

}  // namespace dapple::gpuscene
