#include "base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace dapple::base {
namespace {

constexpr size_t kUnlimited = std::numeric_limits<size_t>::max();

/// The first number of a file; "max" is none.
std::optional<size_t> numberIn(const std::string& path) {
    size_t value = 0;
    std::ifstream file(path);
    if (file >> value) return value;
    return {};
}

size_t freeOnMachine() {
    std::ifstream file("/proc/meminfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("MemAvailable:")) return std::stoull(line.substr(13)) * 1024;
    return kUnlimited;
}

size_t freeInControlGroup() {
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("0::")) {  // version 2: one tree for all controllers
            const std::string folder = "/sys/fs/cgroup" + line.substr(3);
            const std::optional<size_t> limit = numberIn(folder + "/memory.max"), used = numberIn(folder + "/memory.current");
            if (limit && used) return *limit - std::min(*limit, *used);
        }
    return kUnlimited;
}

size_t freeInOwnLimit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
    const size_t used = numberIn("/proc/self/statm").value_or(0) * size_t(sysconf(_SC_PAGESIZE));
    return limit.rlim_cur - std::min<size_t>(limit.rlim_cur, used);
}

}  // namespace

size_t availableMemory() { return std::min({freeOnMachine(), freeInControlGroup(), freeInOwnLimit()}); }

}  // namespace dapple::base
