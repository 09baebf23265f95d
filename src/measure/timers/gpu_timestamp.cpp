#include "measure/timers/gpu_queries.h"

namespace dapple::measure {

namespace {

/// Queries of a frame, in order: its begin, begin and end of each pass if asked for, its end.
class GpuTimestampTimer : public GpuQueryTimer {
public:
    GpuTimestampTimer() : GpuQueryTimer(GL_TIMESTAMP) {}
    std::string_view backend() const override { return "gpu_timestamp"; }
    void beginPass() override {
        if (perPass()) stamp();
    }
    void endPass() override {
        if (perPass()) stamp();
    }

private:
    void stamp() { glQueryCounter(nextQuery(), GL_TIMESTAMP); }
    void onBeginFrame() override { stamp(); }
    void onEndFrame() override { stamp(); }

    FrameTimes convert(const std::vector<uint64_t>& stamps, bool perPass) const override {
        FrameTimes times;
        const auto between = [&](uint64_t begin, uint64_t end) {
            bool wrapped = false;
            const double ms = double(counterDifference(begin, end, bits(), wrapped)) * 1e-6;
            if (wrapped) addFlag(times.flags, flag::kWrap);
            return ms;
        };
        times.frameMs = between(stamps.front(), stamps.back());
        if (perPass)
            for (size_t i = 1; i + 2 < stamps.size(); i += 2) times.passMs.push_back(between(stamps[i], stamps[i + 1]));
        return times;
    }
};

}  // namespace

std::unique_ptr<Timer> makeGpuTimestampTimer() { return std::make_unique<GpuTimestampTimer>(); }

}  // namespace dapple::measure
