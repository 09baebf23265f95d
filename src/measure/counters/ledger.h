#pragma once

#include <cstdint>

namespace dapple::measure {

/// What the CPU itself knows that it asked for, in one frame or one pass. Exact, the same on every machine.
struct Ledger {
    uint64_t drawCalls = 0;           ///< glDraw* commands; a multi-draw counts once
    uint64_t trianglesSubmitted = 0;  ///< × instances; an indirect draw's as if it drew all that it may
    uint64_t texelsWritten = 0;       ///< of the technique's maps, cleared or rendered

    Ledger& operator+=(const Ledger& other) {
        drawCalls += other.drawCalls;
        trianglesSubmitted += other.trianglesSubmitted;
        texelsWritten += other.texelsWritten;
        return *this;
    }
    bool operator==(const Ledger&) const = default;
};

}  // namespace dapple::measure
