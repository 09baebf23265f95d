#include "measure/timer.h"

#include <epoxy/gl.h>

#include <utility>

namespace dapple::measure {

namespace {

class CpuFinishTimer : public Timer {
public:
    std::string_view backend() const override { return "cpu_finish"; }

    void beginFrame(bool perPass) override {
        perPass_ = perPass;
        times_ = {};
        frameBegin_ = finishedAt();
    }
    void beginPass() override {
        if (perPass_) passBegin_ = finishedAt();
    }
    void endPass() override {
        if (perPass_) times_.passMs.push_back((finishedAt() - passBegin_) * 1e3);
    }
    void endFrame() override {
        const double end = finishedAt();
        // With fences around its passes a frame is slower than a frame, so that its own time is not given.
        if (!perPass_) times_.frameMs = (end - frameBegin_) * 1e3;
        done_.push_back(std::move(times_));
    }
    std::vector<FrameTimes> drain() override { return std::exchange(done_, {}); }

private:
    static double finishedAt() {
        glFinish();
        return monotonicSeconds();
    }

    bool perPass_ = false;
    double frameBegin_ = 0, passBegin_ = 0;
    FrameTimes times_;
    std::vector<FrameTimes> done_;
};

}  // namespace

std::unique_ptr<Timer> makeCpuFinishTimer() { return std::make_unique<CpuFinishTimer>(); }

}  // namespace dapple::measure
