#pragma once

namespace dapple::bench {

/// While it lives, the first Ctrl-C or SIGTERM only asks for an end, so that finished points stay whole; the
/// second one ends the program at once. One at a time.
class InterruptScope {
public:
    InterruptScope();
    ~InterruptScope();
    InterruptScope(const InterruptScope&) = delete;
    InterruptScope& operator=(const InterruptScope&) = delete;
    bool requested() const;
};

}  // namespace dapple::bench
