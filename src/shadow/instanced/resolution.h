#pragma once

#include "frame/frame.h"

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dapple::shadow {

/// Chooses sides of maps by what is asked of them: powers of two from 16 up, with hysteresis. A map grows at once, and
/// shrinks only after kPatience measurements in a row that half its side would have served.
class SizeChooser {
public:
    static constexpr int kLeast = 16, kPatience = 30;
    /// `most`: a power of two, at least kLeast.
    explicit SizeChooser(int most) : most_(most) {}
    /// `demands`, by map: sum, over the receivers (pixels) that look it up, of the texels a side that each needs for one texel
    /// per pixel. Maps seen for the first time start at what they want.
    const std::vector<int>& update(std::span<const double> demands);

    /// The side without hysteresis, ∛demand to the nearest power of two. When a map of side s serves receivers that ask for w
    /// with texels of w / s pixels, what the shadows' edges are off by is in proportion to Σ w / s; for a given number of
    /// texels Σ s² over all maps, that is least where s³ is in proportion to Σ w. The factor is 1, so that a map of w² texels
    /// that w² pixels look up, each for a texel of its own, has the side w that they ask for; one that few look up has less.
    static int wanted(double demand, int most);

private:
    /// Measurements in a row that asked for at most half a side, and the most that they asked for.
    struct Wait {
        int measurements = 0, largest = 0;
    };
    int most_;
    std::vector<int> sides_;
    std::vector<Wait> waits_;
};

/// Measures the demand of maps on the GPU, in the frame's present view. Results come back some frames later; nothing waits
/// for them.
class DemandEstimate {
public:
    /// `defines`: those of the technique's look-up. `most`: texels a side that a map may have.
    DemandEstimate(const frame::Frame& frame, std::vector<std::string> defines, int most);
    DemandEstimate(const DemandEstimate&) = delete;
    ~DemandEstimate();
    /// Dispatches a measurement of `maps` maps, unless three are under way. `bind` binds what a look-up reads.
    void record(size_t maps, const std::function<void(const gl::Program&)>& bind, measure::Ledger& tally);
    /// The latest demands that have arrived since the last call, by map (see SizeChooser::update), if any. `wait`: for those
    /// under way.
    std::optional<std::vector<double>> result(bool wait = false);

private:
    struct Slot {
        gl::Buffer buffer;
        GLsync fence = nullptr;
        size_t maps = 0;
    };
    const frame::Frame& frame_;
    int most_;
    gl::Program program_;
    std::array<Slot, 3> slots_;
    size_t next_ = 0;  ///< slot, and the oldest under way
};

}  // namespace dapple::shadow
