#include "bench/interrupt.h"

#include <csignal>

namespace dapple::bench {
namespace {

volatile std::sig_atomic_t interruptRequested = 0;

void handle(int signal) {
    interruptRequested = 1;
    std::signal(signal, SIG_DFL);
}

}  // namespace

InterruptScope::InterruptScope() {
    interruptRequested = 0;
    std::signal(SIGINT, handle);
    std::signal(SIGTERM, handle);
}

InterruptScope::~InterruptScope() {
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
}

bool InterruptScope::requested() const { return interruptRequested != 0; }

}  // namespace dapple::bench
