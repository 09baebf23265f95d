#pragma once

#include <cstdint>

namespace dapple::measure {

/// What the CPU itself knows that it asked for, in one frame or one pass. Exact, the same on every machine.
struct Ledger {
    uint64_t drawCalls = 0;           ///< glDraw* commands; a multi-draw counts once
    uint64_t trianglesSubmitted = 0;  ///< × instances
    uint64_t texelsAllocated = 0;     ///< of the technique's maps: extent × layers × mips × samples
    uint64_t texelsWritten = 0;       ///< of those, cleared or rendered in this frame
    uint64_t textureBytes = 0;        ///< texelsAllocated × bytes per texel of each format

    Ledger& operator+=(const Ledger& other) {
        drawCalls += other.drawCalls;
        trianglesSubmitted += other.trianglesSubmitted;
        texelsAllocated += other.texelsAllocated;
        texelsWritten += other.texelsWritten;
        textureBytes += other.textureBytes;
        return *this;
    }
    bool operator==(const Ledger&) const = default;

    void draw(uint64_t triangles, uint64_t instances = 1) {
        ++drawCalls;
        trianglesSubmitted += triangles * instances;
    }
    void allocate(uint64_t texels, uint64_t bytesPerTexel) {
        texelsAllocated += texels;
        textureBytes += texels * bytesPerTexel;
    }
};

/// Texels of a texture with `levels` mip levels (each half the last, rounded down, at least 1; layers are not
/// halved), times `samples`.
constexpr uint64_t texelCount(uint64_t width, uint64_t height, uint64_t layers = 1, uint64_t levels = 1,
                              uint64_t samples = 1) {
    uint64_t texels = 0;
    for (uint64_t level = 0; level < levels; ++level) {
        texels += width * height;
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
    }
    return texels * layers * samples;
}

}  // namespace dapple::measure
