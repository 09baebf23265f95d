#include "base/child.h"

#include "base/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>

namespace dapple::base {
namespace {

constexpr int kOutOfMemory = 77;  ///< exit status
constexpr char kResult = 'r', kError = 'e', kException = 'x';
constexpr double kClockPerProcessor = 10;  ///< other programs take their share of a machine

void lower(__rlimit_resource resource, rlim_t limit) {
    rlimit old{};
    getrlimit(resource, &old);
    const rlimit now{std::min(limit, old.rlim_cur), std::min(limit + 1, old.rlim_max)};
    setrlimit(resource, &now);
}

size_t addressSpace() {
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * size_t(sysconf(_SC_PAGESIZE));
}

void restrain(const Child::Limits& limits) {
    // What interrupts the parent ends this process too, if it ends the parent.
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, SIG_IGN);
    for (const int signal : {SIGXCPU, SIGPIPE, SIGSEGV, SIGBUS, SIGABRT}) std::signal(signal, SIG_DFL);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    lower(RLIMIT_CORE, 0);
    lower(RLIMIT_CPU, rlim_t(std::ceil(limits.seconds)));
#ifndef __SANITIZE_ADDRESS__  // which sets terabytes of addresses aside
    lower(RLIMIT_AS, addressSpace() + limits.bytes);
#endif
    // At once: readers catch the exception and go on with half of what they need.
    std::set_new_handler([] { ::_exit(kOutOfMemory); });
}

void putError(Child::Output& out, char kind, ExitCode code, const std::string& text) {
    const size_t size = text.size();
    out.put(&kind, 1);
    out.put(&code, sizeof code);
    out.put(&size, sizeof size);
    out.put(text.data(), size);
}

/// Ends in the child. The parent's buffers and exit handlers are not the child's business.
[[noreturn]] void doWork(int file, const Child::Limits& limits, const std::function<void(Child::Output&)>& work) {
    restrain(limits);
    Child::Output out(file);
    try {
        Child::Output result(file);
        result.put(&kResult, 1);
        work(result);
        result.flush();
    } catch (const Error& e) {
        putError(out, kError, e.code(), e.what());
    } catch (const std::exception& e) {
        putError(out, kException, ExitCode::failed, e.what());
    }
    out.flush();
    ::_exit(0);
}

}  // namespace

void Child::Output::put(const void* data, size_t bytes) {
    buffer_.append(static_cast<const char*>(data), bytes);
    if (buffer_.size() > 1 << 16) flush();
}

void Child::Output::flush() {
    for (size_t done = 0; done < buffer_.size();) {
        const ssize_t n = ::write(file_, buffer_.data() + done, buffer_.size() - done);
        if (n < 0 && errno != EINTR) ::_exit(1);
        if (n > 0) done += size_t(n);
    }
    buffer_.clear();
}

Child::Child(const Limits& limits, const std::function<void(Output&)>& work)
    : limits_(limits), deadline_(std::chrono::steady_clock::now() + std::chrono::milliseconds(int64_t(limits.seconds * kClockPerProcessor * 1e3))) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw UsageError(fmt::format("no pipe to another process: {}", std::strerror(errno)));
    std::fflush(nullptr);  // what waits to be written must not be written twice
    process_ = ::fork();
    if (process_ == 0) {
        ::close(ends[0]);
        doWork(ends[1], limits, work);
    }
    const int error = errno;
    ::close(ends[1]);
    file_ = ends[0];
    if (process_ > 0) return;
    ::close(file_);
    throw UsageError(fmt::format("no further process can be started: {}", std::strerror(error)));
}

Child::~Child() {
    ::close(file_);
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {}
}

void Child::get(void* data, size_t bytes) {
    if (!opened_) {
        opened_ = true;
        char kind = 0;
        receive(&kind, 1);
        if (kind != kResult) {
            ExitCode code{};
            size_t size = 0;
            receive(&code, sizeof code);
            receive(&size, sizeof size);
            std::string text(size, '\0');
            receive(text.data(), size);
            if (kind == kError && code == ExitCode::usage) throw UsageError(text);
            if (kind == kError) throw Error(code, text);
            throw Failure(fmt::format("fails ({})", text));
        }
    }
    receive(data, bytes);
}

void Child::receive(void* data, size_t bytes) {
    for (size_t done = 0; done < bytes;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - std::chrono::steady_clock::now()).count();
        pollfd waited{file_, POLLIN, 0};
        const int ready = left > 0 ? ::poll(&waited, 1, int(std::min<int64_t>(left, 1 << 30))) : 0;
        if (ready == 0) throw Failure(fmt::format("takes longer than {:.0f} s", limits_.seconds * kClockPerProcessor));
        const ssize_t n = ready > 0 ? ::read(file_, static_cast<char*>(data) + done, bytes - done) : -1;
        if (n == 0) explain();
        if (n < 0 && errno != EINTR) throw Failure(fmt::format("cannot be heard ({})", std::strerror(errno)));
        if (n > 0) done += size_t(n);
    }
}

void Child::explain() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {}
    process_ = -1;
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) throw Failure(fmt::format("takes longer than {:.0f} s", std::ceil(limits_.seconds)));
    if (WIFSIGNALED(status)) throw Failure(fmt::format("crashes ({})", strsignal(WTERMSIG(status))));
    if (WEXITSTATUS(status) == kOutOfMemory) throw Failure(fmt::format("asks for more than {} MiB of memory", limits_.bytes >> 20));
    throw Failure("ends early");
}

}  // namespace dapple::base
