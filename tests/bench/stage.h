#pragma once

#include "bench/gl_workbench.h"

namespace dapple::bench {

/// GL for a test, as long as it runs.
inline GlWorkbench& workbench() {
    static GlWorkbench bench(-1, "cpu_finish");
    return bench;
}

/// A scene on the GPU and a frame of its first view.
struct Stage {
    explicit Stage(scenegen::Scene made, int width = 160, int height = 120)
        : scene(std::move(made)), gpu((workbench(), scene)), frame(gpu, scene.views.front(), width, height) {}

    scenegen::Scene scene;
    gpuscene::GpuScene gpu;
    frame::Frame frame;
};

}  // namespace dapple::bench
