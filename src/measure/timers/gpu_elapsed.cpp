#include "measure/timers/gpu_queries.h"

namespace dapple::measure {

namespace {

/// Queries of a frame: one for the whole, or one for each pass, since only one TIME_ELAPSED can be active.
class GpuElapsedTimer : public GpuQueryTimer {
public:
    GpuElapsedTimer() : GpuQueryTimer(GL_TIME_ELAPSED) {}
    std::string_view backend() const override { return "gpu_elapsed"; }
    void beginPass() override {
        if (perPass()) begin();
    }
    void endPass() override {
        if (perPass()) glEndQuery(GL_TIME_ELAPSED);
    }

private:
    void begin() { glBeginQuery(GL_TIME_ELAPSED, nextQuery()); }
    void onBeginFrame() override {
        if (!perPass()) begin();
    }
    void onEndFrame() override {
        if (!perPass()) glEndQuery(GL_TIME_ELAPSED);
    }

    FrameTimes convert(const std::vector<uint64_t>& elapsedNs, bool perPass) const override {
        FrameTimes times;
        if (!perPass) times.frameMs = double(elapsedNs.front()) * 1e-6;
        else
            for (uint64_t ns : elapsedNs) times.passMs.push_back(double(ns) * 1e-6);
        return times;
    }
};

}  // namespace

std::unique_ptr<Timer> makeGpuElapsedTimer() { return std::make_unique<GpuElapsedTimer>(); }

}  // namespace dapple::measure
