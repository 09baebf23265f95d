#pragma once

#include "gl/program.h"
#include "gpuscene/items.h"

namespace dapple::gpuscene {

/// Items as compute shaders choose among them (lib/item_table.glsl), and the indirect commands that draw what they chose. They
/// lie in the order of a hierarchy's leaves, so that those near each other are a group: the CPU picks the groups, one shader
/// looks at the box of each, and another at the items of those that this one has found worth it. Made for those who cull on the
/// GPU only: a scene that is culled on the CPU has none.
class ItemTable {
public:
    static constexpr uint32_t kGroupItems = 64;  ///< local size of the shaders

    ItemTable(const Items& items, bool castersOnly);

    size_t size() const { return order_.size(); }
    /// Anew from the scene, after instances have moved.
    void upload();

    /// Groups of items, and the parts that are among them.
    struct Groups {
        std::vector<DrawList::Range> parts;  ///< as in a DrawList that is filled on the GPU
        size_t count = 0;
        gl::Buffer buffer;
    };
    /// The groups whose boxes (metres from Scene::origin) `keep` accepts, by `distance`, the nearest first: they are drawn in that
    /// order. `keep` must reject whatever lies within a box that it rejects.
    void pick(const std::function<bool(const base::Box&)>& keep, const std::function<double(const base::Box&)>& distance, Groups& groups) const;
    /// Makes `list` one of those items of the groups that `item` adds to it, from the groups that `group` has found worth a look
    /// (null: from all). Sets their uEye (metres from Scene::origin), uGroups and storage buffers 0 to 5 and 7; everything else is
    /// the caller's.
    void choose(const gl::Program* group, const gl::Program& item, const glm::dvec3& eye, const Groups& groups, DrawList& list) const;

    /// Appends the items that the shaders have put into a list. Waits for the GPU: for counters, never in a timed frame.
    void read(const DrawList& list, std::vector<uint32_t>& items) const;

private:
    const Items& items_;
    const Hierarchy& hierarchy_;
    std::span<const uint32_t> order_;
    size_t commandCount_ = 0;
    std::vector<uint32_t> firstCommand_, firstSlot_, firstBox_;  ///< by part
    mutable std::vector<uint32_t> rangeOf_;  ///< by part; kNone between calls
    gl::Buffer table_, boxes_, commands_;
    gl::Program listGroups_;
    mutable gl::Buffer worthALook_, listed_;  ///< of the last choose()
};

}  // namespace dapple::gpuscene
