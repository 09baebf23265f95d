#pragma once

#include "measure/subject.h"

#include <memory>
#include <string_view>
#include <vector>

namespace dapple::measure {

/// Times frames and their passes. Passes follow one another and never nest. beginPass() and endPass() are
/// called in every frame; in a frame begun without `perPass` they cost nothing.
class Timer {
public:
    virtual ~Timer() = default;
    /// As in the `backend` column: gpu_timestamp, gpu_elapsed, cpu_finish, fake.
    virtual std::string_view backend() const = 0;
    /// May wait for the oldest frame when more than kRingSlots are in flight.
    virtual void beginFrame(bool perPass) = 0;
    virtual void beginPass() = 0;
    virtual void endPass() = 0;
    virtual void endFrame() = 0;
    /// Waits for all frames since the last drain(); their times in submission order. passMs is filled in
    /// frames begun with `perPass`, whose frameMs is 0 where the back-end cannot time both at once.
    virtual std::vector<FrameTimes> drain() = 0;
};

/// Results arrive up to four frames late; twice that keeps the CPU from ever waiting for the ring.
inline constexpr size_t kRingSlots = 8;

// Each needs a current GL context with version 3.3 or later, on this thread, until it is destroyed.

/// glQueryCounter pairs around the frame and around each pass.
std::unique_ptr<Timer> makeGpuTimestampTimer();
/// One TIME_ELAPSED query at a time: the frame, or each of its passes.
std::unique_ptr<Timer> makeGpuElapsedTimer();
/// glFinish and CLOCK_MONOTONIC. Serialises: a frame begun with `perPass` waits around each pass.
std::unique_ptr<Timer> makeCpuFinishTimer();

/// gpu_timestamp, gpu_elapsed or cpu_finish; throws UsageError for another name.
std::unique_ptr<Timer> makeTimer(std::string_view backend);

/// CLOCK_MONOTONIC, seconds.
double monotonicSeconds();

}  // namespace dapple::measure
