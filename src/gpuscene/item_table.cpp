#include "gpuscene/item_table.h"

#include "gpuscene/nested_boxes.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace dapple::gpuscene {
namespace {

/// Of a dispatch along one axis: GL grants 65,535.
constexpr size_t kMostGroups = 32768;

struct TableItem {
    glm::vec3 translation;  ///< metres from Scene::origin
    float scale;
    glm::vec2 cosSinYaw;
    uint32_t firstBox, firstCommand, commands, firstSlot, padding[2];
};
static_assert(sizeof(TableItem) == 48);

struct TableGroup {
    glm::vec3 lo;  ///< metres from Scene::origin
    uint32_t first;
    glm::vec3 hi;
    uint32_t count;
};
static_assert(sizeof(TableGroup) == 32);

}  // namespace

ItemTable::ItemTable(const Items& items, bool castersOnly)
    : items_(items), hierarchy_(items.hierarchy(Items::kLeafTriangles, castersOnly)), order_(hierarchy_.items()), rangeOf_(items.parts().size(), Hierarchy::kNone) {
    std::vector<uint32_t> uses(items.parts().size(), 0);
    for (const uint32_t item : order_) ++uses[items[item].part];
    std::vector<std::vector<NestedBox>> nested(items.parts().size());
    tbb::parallel_for(size_t(0), nested.size(), [&](size_t p) {
        if (uses[p] > 0) nested[p] = nestedBoxes(items.scene(), items.parts()[p]);
    });
    std::vector<NestedBox> boxes;
    std::vector<IndirectCommand> commands;
    uint32_t slot = 0;
    for (size_t p = 0; p < items.parts().size(); ++p) {
        const Part& part = items.parts()[p];
        firstCommand_.push_back(uint32_t(commands.size()));
        for (const GpuMesh& mesh : part.meshes) commands.push_back({mesh.indexCount, 0, mesh.firstIndex(), mesh.baseVertex, slot});
        firstSlot_.push_back(slot);
        firstBox_.push_back(uint32_t(boxes.size()));
        for (NestedBox box : nested[p]) {
            box.next += firstBox_.back();
            boxes.push_back(box);
        }
        slot += uses[p];
    }
    commandCount_ = commands.size();
    boxes_ = gl::Buffer::of<NestedBox>(boxes);
    commands_ = gl::Buffer::of<IndirectCommand>(commands);
    listGroups_ = gl::Program::compute("visibility/list_groups.comp", {fmt::format("MOST_GROUPS {}u", kMostGroups)});
    upload();
}

void ItemTable::upload() {
    std::vector<TableItem> table;
    table.reserve(size());
    for (const uint32_t item : order_) {
        const scenegen::Instance& i = items_.instance(item);
        const uint32_t part = items_[item].part;
        table.push_back({i.translation, i.scale, {float(std::cos(double(i.yaw))), float(std::sin(double(i.yaw)))}, firstBox_[part], firstCommand_[part],
                         uint32_t(items_.parts()[part].meshes.size()), firstSlot_[part], {}});
    }
    table_.update(table.size() * sizeof(TableItem), table.data());
}

void ItemTable::pick(const std::function<bool(const base::Box&)>& keep, const std::function<double(const base::Box&)>& distance, Groups& groups) const {
    std::vector<TableGroup> picked;
    std::vector<uint32_t> nodes;
    hierarchy_.select(keep, kGroupItems, nodes);
    std::vector<std::pair<double, uint32_t>> near;
    for (const uint32_t n : nodes) near.emplace_back(distance(hierarchy_.nodes()[n].box), n);
    std::sort(near.begin(), near.end());
    groups.parts.clear();
    for (const auto& [key, n] : near) {
        const Hierarchy::Node& node = hierarchy_.nodes()[n];
        for (uint32_t first = 0; first < node.itemCount; first += kGroupItems)  // leaves of many small items hold several
            picked.push_back({node.box.lo, node.firstItem + first, node.box.hi, std::min(node.itemCount - first, kGroupItems)});
        for (const uint32_t item : hierarchy_.items(n)) {
            const uint32_t part = items_[item].part;
            if (rangeOf_[part] == Hierarchy::kNone) {
                rangeOf_[part] = uint32_t(groups.parts.size());
                groups.parts.push_back({part, firstCommand_[part], 0});
            }
            ++groups.parts[rangeOf_[part]].count;
        }
    }
    for (const DrawList::Range& range : groups.parts) rangeOf_[range.part] = Hierarchy::kNone;
    groups.count = picked.size();
    groups.buffer.update(picked.size() * sizeof(TableGroup), picked.data());
}

void ItemTable::choose(const gl::Program* group, const gl::Program& item, const glm::dvec3& eye, const Groups& groups, DrawList& list) const {
    list.parts = items_.parts();
    list.items.clear();
    list.data.clear();
    list.ranges = groups.parts;
    if (groups.count == 0) return;
    list.buffer.update(size() * sizeof(InstanceData), nullptr);
    list.places.update(size() * sizeof(uint32_t), nullptr);
    list.commands.update(commandCount_ * sizeof(IndirectCommand), nullptr);
    glCopyNamedBufferSubData(commands_.name(), list.commands.name(), 0, 0, GLsizeiptr(commandCount_ * sizeof(IndirectCommand)));
    worthALook_.update(groups.count * sizeof(GLuint), nullptr);
    listed_.update((4 + groups.count) * sizeof(GLuint), nullptr);
    const std::pair<GLuint, GLuint> bindings[] = {{0, table_.name()}, {1, boxes_.name()}, {2, list.buffer.name()}, {3, list.commands.name()},
                                                  {4, groups.buffer.name()}, {5, list.places.name()}, {7, worthALook_.name()}};
    for (const auto& [index, name] : bindings) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, index, name);
    const auto use = [&](const gl::Program& program) {
        program.set("uEye", eye);
        program.set("uGroups", int(groups.count));
        program.use();
    };
    if (group) {
        use(*group);
        glDispatchCompute(GLuint((groups.count + kGroupItems - 1) / kGroupItems), 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        listGroups_.set("uGroups", int(groups.count));
        listGroups_.use();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, listed_.name());
        for (size_t first = 0; first < groups.count; first += kMostGroups) {
            listGroups_.set("uFirst", int(first));
            glDispatchCompute(1, 1, 1);
            glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
        }
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, groups.buffer.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 7, listed_.name());
        use(item);
        glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, listed_.name());
        glDispatchComputeIndirect(0);
    } else {
        use(item);
        glDispatchCompute(GLuint(std::min(groups.count, kMostGroups)), GLuint((groups.count + kMostGroups - 1) / kMostGroups), 1);
    }
    glMemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void ItemTable::read(const DrawList& list, std::vector<uint32_t>& items) const {
    if (list.ranges.empty()) return;
    std::vector<IndirectCommand> commands(commandCount_);
    std::vector<uint32_t> places(size());
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(list.commands.name(), 0, GLsizeiptr(commandCount_ * sizeof(IndirectCommand)), commands.data());
    glGetNamedBufferSubData(list.places.name(), 0, GLsizeiptr(places.size() * sizeof(uint32_t)), places.data());
    for (const DrawList::Range& range : list.ranges) {
        const uint32_t count = items_.parts()[range.part].meshes.empty() ? 0 : commands[range.first].instances;
        for (uint32_t i = 0; i < count; ++i) items.push_back(order_[places[firstSlot_[range.part] + i]]);
    }
}

}  // namespace dapple::gpuscene
