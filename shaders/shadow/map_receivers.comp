// Each visible receiver into cells over the texels that its look-up may read: of a pyramid of receivers' depths, or of a mask (MASK).
#include "lib/map_lookup.glsl"
layout(local_size_x = 16, local_size_y = 8) in;
#ifdef MASK
layout(r8, binding = 0) uniform restrict coherent image2DArray uReceivers;
#else
#include "lib/receiver_key.glsl"
layout(r32ui, binding = 0) uniform restrict coherent uimage2DArray uReceivers;
#if MARKED_LEVELS > 1
layout(r32ui, binding = 1) uniform restrict coherent uimage2DArray uCoarser;
#endif
#if MARKED_LEVELS > 2
layout(r32ui, binding = 2) uniform restrict coherent uimage2DArray uCoarsest;
#endif
// Most are beaten already; who has raised a cell sees to the coarser one.
#define RAISES(image, cell, key) (imageLoad(image, cell).r < key && imageAtomicMax(image, cell, key) < key)
#endif
uniform vec2 uCells;  // a side of the finest level, cells; cells a texel

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(uDepth, 0)))) return;
    MapLookup at = mapLookup(pixel);
    if (!at.mapped) return;
    // The look-up reads texels whose centres are so near the place on both axes (and a hair: hardware rounds that to 1/256 of a
    // texel); a caster is drawn where it covers a centre. So the centres' cells are all that matters, on both sides where one
    // falls on a border.
    const float reach = KERNEL + 0.5, hair = 1.0 / 64.0;
    float size = uCells.x / uCells.y;
    vec2 nearest = ceil(at.texels - reach - hair - 0.5), farthest = floor(at.texels + reach + hair - 0.5);
    if (any(lessThan(farthest, vec2(0.0))) || any(greaterThan(nearest, vec2(size - 1.0)))) return;
#ifndef MASK
    farthest = ceil(at.texels - reach + hair - 0.5);  // the first texel alone: the pyramid knows how many follow it
#endif
    nearest = max(nearest, vec2(0.0));
    farthest = clamp(farthest, vec2(0.0), vec2(size - 1.0));
    ivec2 first = max(ivec2(floor((nearest + 0.5) * uCells.y - 1e-3)), ivec2(0));
    ivec2 last = min(ivec2(floor((farthest + 0.5) * uCells.y + 1e-3)), ivec2(int(uCells.x) - 1));
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) {
            ivec3 cell = ivec3(x, y, at.layer);
#ifdef MASK
            if (imageLoad(uReceivers, cell).r < 0.5) imageStore(uReceivers, cell, vec4(1.0));
#else
            uint key = receiverKey(at.z);
            bool raised = RAISES(uReceivers, cell, key);
#if MARKED_LEVELS > 1
            raised = raised && RAISES(uCoarser, ivec3(cell.xy >> 1, cell.z), key);
#endif
#if MARKED_LEVELS > 2
            raised = raised && RAISES(uCoarsest, ivec3(cell.xy >> 2, cell.z), key);
#endif
#endif
        }
}
