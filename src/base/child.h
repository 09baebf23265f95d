#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>

namespace dapple::base {

/// A child process that does one piece of work and sends bytes back. A crash, an endless loop or a hunger for memory ends
/// the child alone.
class Child {
public:
    struct Limits {
        double seconds = 10;           ///< of processor time; ten times as many by the clock
        size_t bytes = size_t(1) << 30;  ///< of memory beyond what this process has already
    };

    /// Why a child has sent less than was to be read: "crashes (Segmentation fault)". A sentence's second half.
    struct Failure : std::runtime_error {
        using std::runtime_error::runtime_error;
    };

    /// What the child sends.
    class Output {
    public:
        explicit Output(int file) : file_(file) {}
        void put(const void* data, size_t bytes);
        void flush();

    private:
        int file_;
        std::string buffer_;
    };

    /// Starts `work` in a copy of this process. It must use neither GL nor threads that exist already. What it throws before
    /// it puts anything comes out of get(): an Error as it was, anything else as a Failure. Throws UsageError where no
    /// process can be started.
    Child(const Limits& limits, const std::function<void(Output&)>& work);
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child();  ///< ends the child

    /// The next bytes that the child has put; blocks until they are there. Throws Failure.
    void get(void* data, size_t bytes);

private:
    void receive(void* data, size_t bytes);
    [[noreturn]] void explain();

    Limits limits_;
    std::chrono::steady_clock::time_point deadline_;
    pid_t process_ = -1;
    int file_ = -1;
    bool opened_ = false;  ///< its first byte, which says whether it failed, has been read
};

}  // namespace dapple::base
