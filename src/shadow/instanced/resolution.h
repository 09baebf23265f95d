#pragma once

#include "shadow/instanced/caster_list.h"

#include <array>
#include <optional>

namespace dapple::shadow {

/// How many receivers (of a sixteenth of the pixels) want how many texels a side of one map.
struct Demand {
    static constexpr int kBins = 24, kBinsPerOctave = 2, kLeast = 16;
    /// Bin b counts wishes in [16 · 2^(b/2), 16 · 2^((b+1)/2)); the first also less, the last also more.
    std::array<uint32_t, kBins> receivers{};
};

/// Chooses sides of maps by what is asked of them: powers of two, with hysteresis. A map grows at once, and shrinks only
/// after kPatience measurements that would all have been served by half its side.
class SizeChooser {
public:
    static constexpr int kPatience = 30;
    /// `most`: a power of two, at least Demand::kLeast.
    explicit SizeChooser(int most) : most_(most) {}
    /// New sides, parallel to `demands`; maps that are new start at what they are asked for.
    const std::vector<int>& update(std::span<const Demand> demands);
    const std::vector<int>& sides() const { return sides_; }
    /// The side that serves all but a share of the receivers, without hysteresis.
    static int wanted(const Demand& demand, int most);

private:
    /// Measurements in a row that asked for at most half a side, and the most that they asked for.
    struct Wait {
        int measurements = 0, largest = 0;
    };
    int most_;
    std::vector<int> sides_;
    std::vector<Wait> waits_;
};

/// Measures, on the GPU, the texels that each map is asked for in the frame's present view. Results come back some frames
/// later; nothing waits for them.
class DemandEstimate {
public:
    /// `defines`: those of the technique's look-up.
    DemandEstimate(const frame::Frame& frame, const std::vector<std::string>& defines);
    DemandEstimate(const DemandEstimate&) = delete;
    ~DemandEstimate();
    /// Dispatches a measurement of `maps` maps. `bind` binds what a look-up reads and uses the program.
    void record(size_t maps, const std::function<void(const gl::Program&)>& bind, measure::Ledger& tally);
    /// The latest result that has arrived since the last call, if any. `wait`: for all that are under way.
    std::optional<std::vector<Demand>> result(bool wait = false);

private:
    struct Slot {
        gl::Buffer buffer;
        GLsync fence = nullptr;
        size_t maps = 0;
    };
    const frame::Frame& frame_;
    gl::Program program_;
    std::array<Slot, 3> slots_;
    size_t next_ = 0;
};

}  // namespace dapple::shadow
