#pragma once

#include "scenegen/scene.h"

#include <cmath>

namespace dapple::bench {

/// What moves in a sweep with a [motion]: the sun and the camera, from where the scene has them, and its moving instances, from
/// where they are at its time, by equal steps from frame to frame. Image errors and counters are those of its frames 1, 2 … in order, with all that techniques keep made for frame 0.
/// Timed frames walk it to and fro, so that no step is larger than another, each point of a comparison from its beginning.
struct MotionPath {
    double azimuthPerFrame = 0, elevationPerFrame = 0;  ///< of the sun, degrees
    int frames = 0;                                     ///< ≥ 2
    double secondsPerFrame = 0;                         ///< of the moving instances
    double metresPerFrame = 0;                          ///< of the camera, level
    double heading = 0;                                 ///< of its way, degrees clockwise from where the view looks
    double turnPerFrame = 0;                            ///< of where it looks, degrees clockwise about the vertical

    bool movesSun() const { return azimuthPerFrame != 0 || elevationPerFrame != 0; }
    bool movesCamera() const { return metresPerFrame != 0 || turnPerFrame != 0; }

    /// Where the sun is in a frame of the path; `start` is the scene's.
    scenegen::Sun at(scenegen::Sun start, int frame) const {
        start.azimuth += frame * azimuthPerFrame;
        start.elevation += frame * elevationPerFrame;
        return start;
    }
    /// Where the camera is, and where it looks.
    scenegen::View at(scenegen::View start, int frame) const {
        const auto turned = [](const glm::dvec3& v, double degrees) {
            const double c = std::cos(glm::radians(degrees)), s = std::sin(glm::radians(degrees));
            return glm::dvec3(c * v.x + s * v.y, c * v.y - s * v.x, v.z);
        };
        // What looks straight down walks to the upper edge of its picture.
        const glm::dvec3& ahead = std::hypot(start.forward.x, start.forward.y) > 1e-6 ? start.forward : start.up;
        start.eye += turned(glm::normalize(glm::dvec3(ahead.x, ahead.y, 0)), heading) * (frame * metresPerFrame);
        start.forward = turned(start.forward, frame * turnPerFrame);
        start.up = turned(start.up, frame * turnPerFrame);
        return start;
    }
    /// Frame of the path that the n-th timed frame shows: 0 … frames − 1 … 0 …
    int frameOf(long n) const {
        const long last = frames - 1, m = n % (2 * last);
        return int(m <= last ? m : 2 * last - m);
    }
};

}  // namespace dapple::bench
