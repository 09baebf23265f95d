// Two-phase culling by hierarchical depth. First: what was visible in the last frame and may be in view. Then (SECOND), against
// the depth which that has left: everything, so that what has come to light is drawn, and what is visible remembered.
#include "lib/item_table.glsl"
#include "lib/clip_bounds.glsl"
layout(binding = 0) uniform sampler2DArray uFarthest;  // SIGN · depth
layout(std430, binding = 6) restrict buffer Visible { uint visible[]; };
uniform int uLevels;
uniform float uCells;
uniform vec2 uMargin;  // cells
uniform vec2 uSlack;   // of depth: a part of it, and at least so much
shared bool groupSeen;

bool mayBeSeen(Box box) {
    ClipBounds bounds = clipBounds(box);
    if (bounds.outside) return false;
#ifdef SECOND
    if (!bounds.known) return true;
    ivec2 a = ivec2(clamp(floor((bounds.lo.xy * 0.5 + 0.5) * uCells - uMargin), vec2(0.0), vec2(uCells - 1.0)));
    ivec2 b = ivec2(clamp(floor((bounds.hi.xy * 0.5 + 0.5) * uCells + uMargin), vec2(0.0), vec2(uCells - 1.0)));
    int level = levelOf(a, b, uLevels, 4);
    float nearest = SIGN > 0.0 ? bounds.lo.z : -bounds.hi.z;
    nearest -= max(uSlack.x * abs(nearest), uSlack.y);
    for (int y = a.y >> level; y <= b.y >> level; ++y)
        for (int x = a.x >> level; x <= b.x >> level; ++x)
            if (nearest <= texelFetch(uFarthest, ivec3(x, y, 0), level).r) return true;
    return false;
#else
    return true;
#endif
}

void main() {
    uint group = groupIndex(), local = gl_LocalInvocationIndex;
    if (group >= uint(uGroups)) return;
    TableGroup g = tableGroups[group];
    if (local == 0u) groupSeen = mayBeSeen(boxOf(g));
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
    bool seen = groupSeen && mayBeSeen(box);
#ifdef SECOND
    visible[index] = seen ? 1u : 0u;
    if (before) return;  // drawn in the first phase, if it is in view
#endif
    if (seen) addToList(index, p, box);
}
