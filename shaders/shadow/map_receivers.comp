// Each visible receiver into the cells of the texels that its look-up may read: of a pyramid's finest level, or of a mask (MASK).
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
const float kReach[3] = float[](0.5, 1.0, 2.0);  // nearest, 2x2, 3x3 with bilinear weights
uniform vec2 uCells;  // a side of that level, cells; cells a texel

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(uDepth, 0)))) return;
    MapLookup at = mapLookup(pixel);
    if (!at.mapped) return;
    // The look-up reads texels whose centres are so near the place on both axes (and a hair: hardware rounds that to 1/256 of a
    // texel); a caster is drawn where it covers a centre. So the centres' cells are all that matters, on both sides where one
    // falls on a border.
    float reach = kReach[FILTER] + 1.0 / 64.0, size = uCells.x / uCells.y;
    vec2 nearest = max(ceil(at.texels - reach - 0.5), vec2(0.0)), farthest = min(floor(at.texels + reach - 0.5), vec2(size - 1.0));
    if (any(greaterThan(nearest, farthest))) return;
    ivec2 first = max(ivec2(floor((nearest + 0.5) * uCells.y - 1e-3)), ivec2(0));
    ivec2 last = min(ivec2(floor((farthest + 0.5) * uCells.y + 1e-3)), ivec2(int(uCells.x) - 1));
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
