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

/// Triangles of one material of one prototype within the scene's shared buffers.
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

/// What is drawn or left out as one: a prototype, or a cluster of its triangles.
struct Part {
    uint32_t prototype = 0;
    base::Box box;  ///< prototype space
    bool castsShadow = true;
    size_t triangles = 0;
    std::vector<GpuMesh> meshes;
};

/// Items to draw, grouped by part, with their buffer on the GPU; `ranges` index `data`. Where a compute shader has chosen
/// them (ItemTable), the CPU knows only which parts may be among them, and how often at most: `first` counts `commands`, one
/// for each mesh, and there are no data.
struct DrawList {
    struct Range {
        uint32_t part, first, count;
    };
    std::span<const Part> parts;  ///< of the Items that filled it; empty: the prototypes
    std::vector<InstanceData> data;
    std::vector<uint32_t> items;  ///< parallel to `data`; those of GpuScene::items() are the instances
    std::vector<Range> ranges;
    gl::Buffer buffer;    ///< reused from frame to frame
    gl::Buffer commands;  ///< of a list that was filled on the GPU: IndirectCommand
    gl::Buffer places;    ///< of such a list: uint32_t, places in the table, parallel to `buffer`

    void upload() { buffer.update(data.size() * sizeof(InstanceData), data.data()); }
};

/// Draws a list with what the caller has: his programs, target and state. Culling calls it, once or several times a frame.
using Submit = std::function<void(const DrawList&)>;

class ItemTable;

/// The scene as culling sees it: parts, each in every instance of its prototype. Where no prototype is clustered, item and
/// instance are the same number, part and prototype too.
class Items {
public:
    struct Item {
        uint32_t instance, part;
    };
    /// Triangles in a leaf of the hierarchy that serves whoever does not ask for another: fewer cost more nodes, more draw what
    /// is not seen. Frames of city-vienna under CHC++ took 139 ms with 500, 142 with 2,000 and 168 with 10,000.
    static constexpr uint64_t kLeafTriangles = 2'000;

    /// `parts`: in the order of their prototypes. The scene must outlive it.
    Items(const scenegen::Scene& scene, std::vector<Part> parts);

    size_t size() const { return items_.size(); }
    const scenegen::Scene& scene() const { return *scene_; }
    std::span<const Part> parts() const { return parts_; }
    const Item& operator[](uint32_t item) const { return items_[item]; }
    const Part& part(uint32_t item) const { return parts_[items_[item].part]; }
    const scenegen::Instance& instance(uint32_t item) const { return scene_->instances[items_[item].instance]; }
    /// By item; metres from Scene::origin.
    std::span<const base::Box> boxes() const { return boxes_; }

    /// Both are made on first use; over all items, or over those that cast.
    const Hierarchy& hierarchy(uint64_t leafTriangles, bool castersOnly) const;
    const ItemTable& table(bool castersOnly) const;

    /// To be called when Scene::moveTo has moved instances.
    void instancesMoved();

    /// Fills and uploads `list` with these items, seen from `eye` (metres from Scene::origin), nearest first.
    void collect(const glm::dvec3& eye, std::span<const uint32_t> items, DrawList& list) const;

private:
    const scenegen::Scene* scene_;
    std::vector<Part> parts_;
    std::vector<Item> items_;
    std::vector<base::Box> boxes_;
    mutable std::map<std::pair<uint64_t, bool>, Hierarchy> hierarchies_;
    mutable std::map<bool, std::shared_ptr<ItemTable>> tables_;
};

}  // namespace dapple::gpuscene
