#include "measure/timers/fake.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace dapple::measure {

/// Box & Muller (1958).
double FakeTimer::normal(uint64_t index) const {
    const base::Random random(costs_.seed, index, 1);
    const double u = 1.0 - double(random.uniform(0)), v = double(random.uniform(1));
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

void FakeTimer::beginFrame(bool perPass) {
    perPass_ = perPass;
    passMs_.clear();
    factor_ = std::exp(costs_.noise * normal(frame_++)) * (1 + costs_.driftPerSecond * clock_.seconds);
}

void FakeTimer::endPass() {
    const auto pass = passMs_.size();
    const double cost = pass < costs_.passMs.size()
                            ? costs_.passMs[pass]
                            : double(base::Random(costs_.seed, pass, 2).uniform(0, 0.5f, 2.0f));
    passMs_.push_back(cost * factor_);
}

void FakeTimer::endFrame() {
    FrameTimes times{.frameMs = std::accumulate(passMs_.begin(), passMs_.end(), 0.0), .passMs = {}, .flags = {}};
    clock_.seconds += times.frameMs * 1e-3;
    if (perPass_) times.passMs = passMs_;
    done_.push_back(std::move(times));
}

std::vector<FrameTimes> FakeTimer::drain() { return std::exchange(done_, {}); }

}  // namespace dapple::measure
