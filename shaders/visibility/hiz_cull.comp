// Two-phase culling by hierarchical depth. First: what was visible in the last frame and may be in view. Then (SECOND), against
// the depth which that has left: everything, so that what has come to light is drawn, and what is visible remembered.
#include "lib/item_table.glsl"
layout(binding = 0) uniform sampler2DArray uFarthest;  // SIGN · depth
layout(binding = 1) uniform sampler2D uDepth;          // the finest level, where its pixels are the cells (IMAGE_CELLS)
layout(std430, binding = 6) restrict buffer Visible { uint visible[]; };
#define CELL_VALUE(cell, level) farthestIn(cell, level)
// Where a sun's map, drawn with depth clamp, is 0 already, nothing can come before.
float farthestIn(ivec2 cell, int level) {
#ifdef IMAGE_CELLS
    float depth = level == 0 ? SIGN * texelFetch(uDepth, cell, 0).r : texelFetch(uFarthest, ivec3(cell, 0), level - 1).r;
#else
    float depth = texelFetch(uFarthest, ivec3(cell, 0), level).r;
#endif
    return SIGN > 0.0 && depth <= 0.0 ? -1e30 : depth;
}
#include "lib/covered_cells.glsl"
shared bool groupSeen;

#ifdef SECOND
#define MAY_BE_SEEN(box) mayBeBefore(box)
#else
#define MAY_BE_SEEN(box) (!clipBounds(box).outside)
#endif

void main() {
    uint group = groupIndex(), local = gl_LocalInvocationIndex;
    if (group >= uint(uGroups)) return;
    TableGroup g = tableGroups[group];
    if (local == 0u) groupSeen = MAY_BE_SEEN(boxOf(g));
    barrier();
    if (local >= g.count) return;
    uint index = g.first + local;
    bool before = visible[index] != 0u;
#ifndef SECOND
    if (!before || !groupSeen) return;
#endif
    TableItem i = tableItems[index];
    TablePart p = tableParts[i.part];
    Box box = boxOf(i, p);
    bool seen = groupSeen && MAY_BE_SEEN(box);
#ifdef SECOND
    visible[index] = seen ? 1u : 0u;
    if (before) return;  // drawn in the first phase, if it is in view
#endif
    if (seen) addToList(index, p, box);
}
