#pragma once

#include <cstdint>

namespace dapple::measure {

class Counters;

/// What the CPU itself knows that it asked for, in one frame or one pass. Exact, the same on every machine.
struct Ledger {
    uint64_t drawCalls = 0;           ///< glDraw* commands; a multi-draw counts once
    uint64_t trianglesSubmitted = 0;  ///< × instances; an indirect draw's as if it drew all that it may, but where `counters` allow waiting
    uint64_t texelsWritten = 0;       ///< of the technique's maps, cleared or rendered
    uint64_t mapFragments = 0;        ///< of casters in those maps, past the alpha test, hidden or not; only with `counters`
    uint64_t mapTexelsFilled = 0;     ///< texels of those maps that hold a caster; only with `counters`
    Counters* counters = nullptr;     ///< in an untimed frame that counts: the pass may draw again to count, and wait for the GPU

    Ledger& operator+=(const Ledger& other) {
        drawCalls += other.drawCalls;
        trianglesSubmitted += other.trianglesSubmitted;
        texelsWritten += other.texelsWritten;
        mapFragments += other.mapFragments;
        mapTexelsFilled += other.mapTexelsFilled;
        return *this;
    }
    bool operator==(const Ledger&) const = default;
};

}  // namespace dapple::measure
