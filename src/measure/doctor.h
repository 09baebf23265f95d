#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dapple::measure {

/// Times of one load of draws, by the wall clock between two glFinish and by a timer inside them.
struct TimerTrial {
    double wallMs = 0, timerMs = 0;
};

struct BackendVerdict {
    std::string backend;
    bool accepted = false;
    std::string reason;        ///< one line, also when accepted
    int bits = 0;              ///< GL_QUERY_COUNTER_BITS; 0 also for cpu_finish, which has no query
    TimerTrial shortLoad;      ///< N draws: medians over the trials
    TimerTrial longLoad;       ///< 4 N draws
    double ratioShort = 0;     ///< median timer / wall on N draws
    double ratioLong = 0;      ///< … on 4 N draws
};

/// Which timer earns trust on this machine.
struct TimerReport {
    std::vector<BackendVerdict> verdicts;  ///< in order of preference: gpu_timestamp, gpu_elapsed, cpu_finish
    std::string chosen;                    ///< back-end; empty if even cpu_finish failed: times mean nothing here
    int drawsShort = 0;                    ///< N
    double seconds = 0;                    ///< that the self-test took

    std::string text() const;  ///< a few lines for a person
    std::string json() const;  ///< one JSON object with the same content
};

/// The rule by which trials are judged, apart from GL so that it can be tested. `shorts` and `longs` are trials of
/// N and 4 N equal draws. A query timer is accepted if it saw ≥ 0.8 of the wall time on the long load, never
/// exceeded the wall (exceedsWall), and grew from N to 4 N as the wall did, within 25 %.
/// cpu_finish is the wall itself; it is accepted if glFinish truly waits: the wall grew by a factor of 2 to 8.
BackendVerdict judgeTimer(const std::string& backend, int bits, const std::vector<TimerTrial>& shorts,
                          const std::vector<TimerTrial>& longs);

/// Runs the self-test in the current GL 4.5 context with objects of its own; leaves gl::resetState() and a changed
/// viewport behind. Under two seconds on a software rasteriser. Throws base::Error(failed) when GL fails.
TimerReport testTimers();

}  // namespace dapple::measure
