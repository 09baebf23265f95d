#pragma once

#include "scenegen/scene.h"

namespace dapple::bench {

/// What a sweep with a [motion] moves, by equal steps from frame to frame: the sun, from where the scene has it, and the scene's
/// moving instances, from where they are at its time. Image errors
/// and counters are those of its frames 1, 2 … in order, with all that techniques keep made for frame 0. Timed frames walk
/// it to and fro, so that no step is larger than another, each point of a comparison from its beginning.
struct MotionPath {
    double azimuthPerFrame = 0, elevationPerFrame = 0;  ///< degrees
    double secondsPerFrame = 0;                         ///< of the moving instances
    int frames = 0;                                     ///< ≥ 2

    /// Where the sun is in a frame of the path; `start` is the scene's.
    scenegen::Sun at(scenegen::Sun start, int frame) const {
        start.azimuth += frame * azimuthPerFrame;
        start.elevation += frame * elevationPerFrame;
        return start;
    }
    /// Frame of the path that the n-th timed frame shows: 0 … frames − 1 … 0 …
    int frameOf(long n) const {
        const long last = frames - 1, m = n % (2 * last);
        return int(m <= last ? m : 2 * last - m);
    }
};

}  // namespace dapple::bench
