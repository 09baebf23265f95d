// Two-phase culling by hierarchical depth. First: what was visible in the last frame and may be in view. Then (SECOND), against
// the depth which that has left: everything, so that what has come to light is drawn, and what is visible remembered.
#include "lib/item_table.glsl"
layout(binding = 0) uniform sampler2DArray uFarthest;  // SIGN · depth
layout(binding = 1) uniform sampler2D uDepth;          // the finest level, where its pixels are the cells (IMAGE_CELLS)
// Of an item: the frame in which it was visible when it was last looked at, 0: it was not; of a group, at its first item's place:
// the last frame in which it was hidden as a whole. What is out of view keeps what it had.
struct History { uint itemVisible, groupHidden; };
layout(std430, binding = 6) restrict buffer Histories { History histories[]; };
uniform int uFrame;
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

void main() {
#ifdef GROUPS
    uint group = gl_GlobalInvocationID.x;
    if (group >= uint(uGroups)) return;
    TableGroup g = tableGroups[group];
    bool worth = mayBeBefore(boxOf(g));
    worthALook[group] = worth ? 1u : 0u;
    if (!worth) histories[g.first].groupHidden = uint(uFrame);
#else
    uint place;
#ifdef SECOND
    if (!placeOfItem(false, place)) return;
#else
    if (!placeOfItem(true, place)) return;
#endif
    bool before = histories[place].itemVisible > histories[place - gl_LocalInvocationIndex].groupHidden;
#ifndef SECOND
    if (!before) return;
#endif
    TableItem item = tableItems[place];
#ifdef SECOND
    // A closer look at what may stay hidden, from the sun: it spares a tenth of city-vienna's frame. From the eye it costs what it spares.
    bool seen = before || SIGN < 0.0 ? mayBeBefore(boxOf(item)) : mayBeBefore(item);
    histories[place].itemVisible = seen ? uint(uFrame) : 0u;
    seen = seen && !before;  // or else the first phase has drawn it
#else
    bool seen = !clipBounds(boxOf(item)).outside;
#endif
    if (seen) addToList(place, item);
#endif
}
