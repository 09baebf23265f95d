#pragma once

#include "base/random.h"
#include "measure/timer.h"

namespace dapple::measure {

/// Time that passes only when somebody advances it, so that tests of limits and drift are exact.
struct VirtualClock {
    double seconds = 0;
};

struct FakeCosts {
    std::vector<double> passMs;  ///< of pass 0, 1, …; a pass beyond the list costs 0.5 to 2 ms, drawn from the seed
    double noise = 0;            ///< standard deviation of the logarithm of a frame's cost
    double driftPerSecond = 0;   ///< all costs grow by this share per second of the clock
    uint64_t seed = 1;
};

/// Back-end `fake`: seeded costs and noise, no GL. It advances `clock` by each frame's cost; hand the same
/// clock to the sampler's plan. Both must outlive the timer's use.
class FakeTimer : public Timer {
public:
    FakeTimer(FakeCosts costs, VirtualClock& clock) : costs_(std::move(costs)), clock_(clock) {}

    std::string_view backend() const override { return "fake"; }
    void beginFrame(bool perPass) override;
    void beginPass() override {}
    void endPass() override;
    void endFrame() override;
    std::vector<FrameTimes> drain() override;

private:
    double normal(uint64_t index) const;

    FakeCosts costs_;
    VirtualClock& clock_;
    uint64_t frame_ = 0;
    bool perPass_ = false;
    double factor_ = 1;
    std::vector<double> passMs_;
    std::vector<FrameTimes> done_;
};

}  // namespace dapple::measure
