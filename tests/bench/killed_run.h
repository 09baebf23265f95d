#pragma once

#include "bench/fixture.h"
#include "bench/run.h"

#include <sys/wait.h>
#include <unistd.h>

namespace dapple::bench {

inline constexpr int kKilled = 9;

inline Sweep threeScenes() {
    Sweep sweep = smallSweep();
    sweep.scenes = {"a", "b", "c"};
    return sweep;
}

/// Runs in a child process that dies without a chance to tidy up when `frames` frames were submitted. True if it died.
inline bool runAndDieAfter(const std::string& out, long frames, bool resume) {
    const pid_t child = ::fork();
    if (child == 0) {
        TestWorkbench bench;
        long left = frames;
        bench.onFrame = [&](const PointSpec&) {
            if (left-- <= 0) ::_exit(kKilled);
        };
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = out, .resume = resume});
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == kKilled;
}

}  // namespace dapple::bench
