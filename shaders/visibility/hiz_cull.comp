// Two-phase culling by hierarchical depth. First: what was visible in the last frame and may be in view. Then (SECOND), against
// the depth which that has left: everything, so that what has come to light is drawn, and what is visible remembered.
#include "lib/instance_table.glsl"
#include "lib/clip_bounds.glsl"
layout(local_size_x = 64) in;
layout(binding = 0) uniform sampler2DArray uFarthest;  // SIGN · depth
layout(std430, binding = 4) restrict buffer Visible { uint visible[]; };
uniform int uLevels;
uniform float uCells;
uniform vec2 uMargin;  // cells
uniform vec2 uSlack;   // of depth: a part of it, and at least so much
uniform int uCasters;  // 1: casters alone

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(uInstances)) return;
    bool before = visible[index] != 0u;
#ifndef SECOND
    if (!before) return;
#endif
    TableInstance i = tableInstances[index];
    TablePrototype p = tablePrototypes[i.prototype];
    if (uCasters != 0 && p.casts == 0u) return;
    vec3 position = relativePosition(i);
    ClipBounds bounds = clipBounds(i, p, position);
    bool seen = !bounds.outside;
#ifdef SECOND
    if (seen && bounds.known) {
        ivec2 a = ivec2(clamp(floor((bounds.lo.xy * 0.5 + 0.5) * uCells - uMargin), vec2(0.0), vec2(uCells - 1.0)));
        ivec2 b = ivec2(clamp(floor((bounds.hi.xy * 0.5 + 0.5) * uCells + uMargin), vec2(0.0), vec2(uCells - 1.0)));
        int level = levelOf(a, b, uLevels, 4);
        float nearest = SIGN > 0.0 ? bounds.lo.z : -bounds.hi.z;
        nearest -= max(uSlack.x * abs(nearest), uSlack.y);
        seen = false;
        for (int y = a.y >> level; y <= b.y >> level; ++y)
            for (int x = a.x >> level; x <= b.x >> level; ++x) seen = seen || nearest <= texelFetch(uFarthest, ivec3(x, y, 0), level).r;
    }
    visible[index] = seen ? 1u : 0u;
    if (before) return;  // drawn in the first phase, if it is in view
#endif
    if (seen) addToList(i, p, position);
}
