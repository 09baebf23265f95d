#pragma once

#include <string>
#include <vector>

namespace dapple::measure {

/// Times of one frame, milliseconds. `passMs` is parallel to Subject::passNames(), or empty when the frame
/// was timed as a whole only.
struct FrameTimes {
    double frameMs = 0;
    std::vector<double> passMs;
    std::vector<std::string> flags;  ///< validity flags raised while timing: lost, gl_error, nonfinite …
};

/// What a sampler can time: one technique with its settings on one view. Frames are submitted without
/// waiting; a GPU's results arrive up to four frames late and are collected by drain().
class Subject {
public:
    virtual ~Subject() = default;
    /// Passes in the order they run. Constant over the subject's life.
    virtual const std::vector<std::string>& passNames() const = 0;
    /// Renders one frame. `perPass`: time every pass too (with fences around each pass where the back-end
    /// needs them, so that such a frame's own time is not a frame time and is not reported as one).
    virtual void submitFrame(bool perPass) = 0;
    /// Warming up is over: where a frame depends on those before it, count them anew. Before the first block.
    virtual void beginBlocks() {}
    /// Waits for all submitted frames; their times in submission order.
    virtual std::vector<FrameTimes> drain() = 0;
};

}  // namespace dapple::measure
