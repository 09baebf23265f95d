#include "gl/address_space.h"

#include "base/error.h"
#include "base/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <exception>
#include <string_view>
#include <thread>

namespace dapple::gl {
namespace {

// glibc sets 64 MiB of addresses aside for each thread's heap, beside a stack of 8 MiB and what it allocates; llvmpipe has at
// most 16 threads. The rest is for LLVM, the compiler of its shaders, and for a small scene.
constexpr size_t kPerThread = size_t(128) << 20, kBeside = size_t(512) << 20, kMostThreads = 16;

bool isLimited() {
    rlimit limit{};
    return getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

void reportCrash(int) {
    constexpr std::string_view kLine = "dapple: the GL driver died, probably of the limit on addresses (ulimit -v): raise it, or ask for less\n";
    [[maybe_unused]] const ssize_t n = ::write(STDERR_FILENO, kLine.data(), kLine.size());
    ::_exit(int(base::ExitCode::failed));
}

}  // namespace

void guardAddressSpace() {
    if (!isLimited()) return;
    const size_t threads = std::clamp<size_t>(std::thread::hardware_concurrency(), 1, kMostThreads);
    const size_t needed = kBeside + threads * kPerThread, left = base::availableMemory();
    if (left < needed)
        throw base::UsageError(fmt::format("{} MiB are left for GL, whose software drivers need about {} MiB of addresses with {} threads and crash without: "
                                           "raise the limit (ulimit -v) or free memory", left >> 20, needed >> 20, threads));
    static std::array<char, 1 << 14> stack;  // of its own: what overflows may be the thread's
    const stack_t alternative{stack.data(), 0, stack.size()};
    sigaltstack(&alternative, nullptr);
    struct sigaction action {};
    action.sa_handler = reportCrash;
    action.sa_flags = SA_ONSTACK;
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT}) sigaction(signal, &action, nullptr);
}

bool leaveObjects() { return std::uncaught_exceptions() > 0 && isLimited(); }

}  // namespace dapple::gl
