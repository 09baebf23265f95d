#include "measure/timer.h"

#include "base/error.h"

#include <array>
#include <chrono>
#include <string>

namespace dapple::measure {

std::unique_ptr<Timer> makeTimer(std::string_view backend) {
    if (backend == "gpu_timestamp") return makeGpuTimestampTimer();
    if (backend == "gpu_elapsed") return makeGpuElapsedTimer();
    if (backend == "cpu_finish") return makeCpuFinishTimer();
    const std::array<std::string, 3> known{"gpu_timestamp", "gpu_elapsed", "cpu_finish"};
    throw base::UsageError(base::unknownName("timer", backend, known));
}

double monotonicSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace dapple::measure
