#pragma once

#include "gpuscene/gpu_scene.h"

namespace dapple::gpuscene {

/// The scene's instances as compute shaders choose among them (lib/instance_table.glsl), and the indirect commands that draw
/// what they chose. Made for those who cull on the GPU only: a scene that is culled on the CPU has none.
class InstanceTable {
public:
    explicit InstanceTable(const GpuScene& scene);

    size_t instances() const { return count_; }
    /// Anew from the scene, after instances have moved.
    void upload();
    /// Makes `list` one that draws nothing yet, with room for every instance: a shader may now add to it.
    void begin(DrawList& list) const;
    /// Binds instances to storage buffer 0, prototypes to 1, and the list's instance data and commands to 2 and 3.
    void bind(const DrawList& list) const;

    /// What the shaders have put into a list. Waits for the GPU: for counters, never in a timed frame.
    struct Drawn {
        size_t instances = 0, triangles = 0;
    };
    Drawn read(const DrawList& list) const;

private:
    const GpuScene& scene_;
    size_t count_ = 0, commandCount_ = 0;
    std::vector<uint32_t> firstCommand_;  ///< by prototype
    gl::Buffer instances_, prototypes_, commands_;
};

}  // namespace dapple::gpuscene
