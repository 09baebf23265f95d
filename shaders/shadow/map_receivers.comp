// Each visible receiver into the cells whose texels its look-up may read: of a pyramid's finest level, or of a mask (MASK).
#include "lib/map_lookup.glsl"
#ifndef MASK
#include "lib/receiver_key.glsl"
#endif
layout(local_size_x = 16, local_size_y = 8) in;
#ifdef MASK
layout(r8, binding = 0) uniform restrict coherent image2DArray uReceivers;
#else
layout(r32ui, binding = 0) uniform restrict coherent uimage2DArray uReceivers;
#endif
uniform vec2 uCells;  // a side of that level, cells; cells a texel

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(uDepth, 0)))) return;
    MapLookup at = mapLookup(pixel);
    if (!at.mapped) return;
    // The kernel reads texel centres up to r + 1/2 from the place: their texels lie within r + 1.
    float reach = KERNEL + 1.0;
    ivec2 first = max(ivec2(floor((at.texels - reach) * uCells.y)), ivec2(0));
    ivec2 last = min(ivec2(floor((at.texels + reach) * uCells.y)), ivec2(int(uCells.x) - 1));
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            ivec3 cell = ivec3(x, y, at.layer);
#ifdef MASK
            if (imageLoad(uReceivers, cell).r < 0.5) imageStore(uReceivers, cell, vec4(1.0));
#else
            uint key = receiverKey(at.z);
            if (imageLoad(uReceivers, cell).r < key) imageAtomicMax(uReceivers, cell, key);  // most are beaten already
#endif
        }
}
