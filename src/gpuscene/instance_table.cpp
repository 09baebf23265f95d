#include "gpuscene/instance_table.h"

#include <cmath>

namespace dapple::gpuscene {
namespace {

struct TableInstance {
    glm::vec3 translation;  ///< metres from Scene::origin
    float scale;
    glm::vec2 cosSinYaw;
    uint32_t prototype, padding;
};
static_assert(sizeof(TableInstance) == 32);

struct TablePrototype {
    glm::vec3 lo;
    uint32_t firstCommand;
    glm::vec3 hi;
    uint32_t commands;
    uint32_t firstSlot, casts, padding[2];
};
static_assert(sizeof(TablePrototype) == 48);

}  // namespace

const InstanceTable& GpuScene::instanceTable() const {
    if (!instanceTable_) instanceTable_ = std::make_shared<InstanceTable>(*this);
    return *instanceTable_;
}

InstanceTable::InstanceTable(const GpuScene& scene) : scene_(scene) {
    const scenegen::Scene& s = scene.scene();
    std::vector<uint32_t> uses(s.prototypes.size(), 0);
    for (const scenegen::Instance& instance : s.instances) ++uses[instance.prototype];
    std::vector<TablePrototype> prototypes;
    std::vector<IndirectCommand> commands;
    uint32_t slot = 0;
    for (size_t p = 0; p < s.prototypes.size(); ++p) {
        const GpuPrototype& prototype = scene.prototypes()[p];
        firstCommand_.push_back(uint32_t(commands.size()));
        for (const GpuMesh& mesh : prototype.meshes) commands.push_back({mesh.indexCount, 0, mesh.firstIndex(), mesh.baseVertex, slot});
        prototypes.push_back({prototype.box.lo, firstCommand_.back(), prototype.box.hi, uint32_t(commands.size()) - firstCommand_.back(), slot, prototype.castsShadow, {}});
        slot += uses[p];
    }
    commandCount_ = commands.size();
    prototypes_ = gl::Buffer::of<TablePrototype>(prototypes);
    commands_ = gl::Buffer::of<IndirectCommand>(commands);
    upload();
}

void InstanceTable::upload() {
    const scenegen::Scene& s = scene_.scene();
    std::vector<TableInstance> instances;
    for (const scenegen::Instance& i : s.instances)
        instances.push_back({i.translation, i.scale, {float(std::cos(double(i.yaw))), float(std::sin(double(i.yaw)))}, i.prototype, 0});
    count_ = instances.size();
    instances_.update(instances.size() * sizeof(TableInstance), instances.data());
}

void InstanceTable::begin(DrawList& list) const {
    list.buffer.update(count_ * sizeof(InstanceData), nullptr);
    list.commands.update(commandCount_ * sizeof(IndirectCommand), nullptr);
    if (commandCount_ > 0) glCopyNamedBufferSubData(commands_.name(), list.commands.name(), 0, 0, GLsizeiptr(commandCount_ * sizeof(IndirectCommand)));
}

void InstanceTable::bind(const DrawList& list) const {
    const GLuint names[] = {instances_.name(), prototypes_.name(), list.buffer.name(), list.commands.name()};
    for (GLuint i = 0; i < 4; ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, names[i]);
}

InstanceTable::Drawn InstanceTable::read(const DrawList& list) const {
    std::vector<IndirectCommand> commands(commandCount_);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    if (commandCount_ > 0) glGetNamedBufferSubData(list.commands.name(), 0, GLsizeiptr(commandCount_ * sizeof(IndirectCommand)), commands.data());
    Drawn drawn;
    for (size_t p = 0; p < firstCommand_.size(); ++p) {
        const GpuPrototype& prototype = scene_.prototypes()[p];
        const uint32_t count = prototype.meshes.empty() ? 0 : commands[firstCommand_[p]].instances;
        drawn.instances += count;
        drawn.triangles += count * prototype.triangles;
    }
    return drawn;
}

}  // namespace dapple::gpuscene
