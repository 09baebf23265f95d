#pragma once

#include "gpuscene/items.h"

namespace dapple::gpuscene {

struct GpuPrototype {
    base::Box box;  ///< prototype space
    bool castsShadow = true;
    std::vector<GpuMesh> meshes;
    size_t triangles = 0;
};

/// Which meshes of a draw list a draw submits.
enum class Bucket { opaque, alphaTested };
/// Which vertex attributes it reads beside the position.
enum class Attributes { position, positionUv, positionNormal, all };
/// Which faces of closed meshes it rasterises: those that look away change a pixel only where the near plane cuts the mesh.
enum class Faces { front, both };

struct DrawCount {
    size_t draws = 0, triangles = 0;
};

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
    std::span<const base::Box> instanceBoxes() const { return items().boxes(); }
    const base::Box& box() const { return box_; }  ///< all of them together
    /// What is drawn or left out as one: instances; or clusters, of at most so many triangles, of the prototypes that have
    /// more, made on first use.
    const Items& items(uint32_t clusterTriangles = 0) const;
    const Hierarchy& hierarchy(uint64_t leafTriangles, bool castersOnly) const { return items().hierarchy(leafTriangles, castersOnly); }
    size_t bufferBytes() const;
    size_t textureBytes() const;

    /// Fills and uploads `list` with the instances that `keep` accepts, seen from `eye` (metres from
    /// Scene::origin), nearest first. `keep` gets the index of an instance.
    void collect(const glm::dvec3& eye, const std::function<bool(uint32_t instance)>& keep, DrawList& list) const;

    /// Submits the meshes of a bucket, their grid set as uGrid on `program`. Unless `attributes` is position alone, the material is set on `program`
    /// (uAlbedo = colour and specular strength, uTextured, uAlphaCutoff) and its texture bound to units 0 (colour) and 1
    /// (alpha, nearest texel of level 0 as in the reference).
    /// The count of a list that the GPU has filled is what it may hold at most; with `readBack`, which waits, what it holds.
    DrawCount draw(const DrawList& list, Bucket bucket, Attributes attributes, GLuint program, Faces faces = Faces::front, bool readBack = false) const;
    /// Whether any mesh is in the bucket; whether an opaque one has a texture.
    bool has(Bucket bucket) const { return bucket == Bucket::opaque ? hasOpaque_ : hasAlpha_; }
    bool hasOpaqueTextures() const { return hasOpaqueTextures_; }

private:
    struct Uniforms;
    void setMaterial(uint32_t material, const Uniforms& uniforms) const;

    const scenegen::Scene* scene_;
    scenegen::Facts facts_;
    std::vector<GpuPrototype> prototypes_;
    base::Box box_;
    std::vector<gl::Texture> textures_;
    static constexpr size_t kKinds = 3;  // of Packing::Vertices
    gl::Buffer vertices_[kKinds], uvs_[kKinds];
    mutable gl::Buffer indices_;  // grows with clusters
    gl::VertexArray arrays_[kKinds][4];  // by Attributes
    /// Samplers of colour and of alpha, by wrap along u and v.
    std::array<std::array<gl::Sampler, 9>, 2> samplers_;
    mutable std::map<uint32_t, Items> items_;  // by a cluster's triangles
    bool hasOpaque_ = false, hasAlpha_ = false, hasOpaqueTextures_ = false;
};

}  // namespace dapple::gpuscene
