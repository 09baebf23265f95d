#pragma once

#include "measure/flags.h"
#include "measure/timer.h"

#include <epoxy/gl.h>

#include <array>
#include <deque>

namespace dapple::measure {

/// (end − begin) of a counter of `bits` bits, nanoseconds, modulo 2^bits. `wrapped` is set when end < begin.
/// More than one wrap cannot be seen: at 1 GHz a counter of 30 bits, the least that GL allows, wraps each second.
uint64_t counterDifference(uint64_t begin, uint64_t end, int bits, bool& wrapped);

/// The ring that the two query back-ends share: a slot per frame, results collected when they have arrived.
class GpuQueryTimer : public Timer {
public:
    ~GpuQueryTimer() override;
    GpuQueryTimer(const GpuQueryTimer&) = delete;
    GpuQueryTimer& operator=(const GpuQueryTimer&) = delete;

    void beginFrame(bool perPass) override;
    void endFrame() override;
    std::vector<FrameTimes> drain() override;

protected:
    /// `target`: of all queries of this ring, since a query object stays tied to its first.
    explicit GpuQueryTimer(GLenum target);
    /// The frame's next query, not yet issued.
    GLuint nextQuery();
    bool perPass() const { return open_->perPass; }
    int bits() const { return bits_; }

    virtual void onBeginFrame() = 0;
    virtual void onEndFrame() = 0;
    /// Times from the results, nanoseconds, of the frame's queries in the order of nextQuery().
    virtual FrameTimes convert(const std::vector<uint64_t>& results, bool perPass) const = 0;

private:
    struct Slot {
        std::vector<GLuint> queries;
        size_t used = 0;
        bool perPass = false;
    };
    enum class Wait { no, yes };
    bool collectOldest(Wait wait);

    int bits_ = 0;
    std::array<Slot, kRingSlots> slots_;
    std::deque<Slot*> pending_;  ///< oldest first
    size_t next_ = 0;
    Slot* open_ = nullptr;
    std::vector<FrameTimes> done_;
};

}  // namespace dapple::measure
