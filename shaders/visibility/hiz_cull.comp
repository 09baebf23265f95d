// Two-phase culling by hierarchical depth. First: what was visible in the last frame and may be in view. Then (SECOND), against
// the depth which that has left: everything, so that what has come to light is drawn, and what is visible remembered.
#include "lib/instance_table.glsl"
layout(local_size_x = 64) in;
layout(binding = 0) uniform sampler2DArray uFarthest;  // SIGN · depth
layout(std430, binding = 4) restrict buffer Visible { uint visible[]; };
uniform int uLevels;
uniform float uCells;
uniform mat4 uClip;
uniform float uLeastW;
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
    vec3 position = relativePosition(i), lo = vec3(1e30), hi = vec3(-1e30);
    bool known = true;
    uint outside = 15u;  // a bit for each side of the view that all corners so far are beyond
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec4 q = uClip * vec4(boxCorner(i, p, position, corner), 1.0);
        known = known && q.w > uLeastW;
        vec4 beyond = vec4(q.x + q.w, q.w - q.x, q.y + q.w, q.w - q.y) + 1e-4 * abs(q.w);
        for (int side = 0; side < 4; ++side)
            if (beyond[side] >= 0.0) outside &= ~(1u << side);
        vec3 ndc = q.xyz / q.w;
        lo = min(lo, vec3(ndc.xy, SIGN * ndc.z));
        hi = max(hi, ndc);
    }
    bool seen = outside == 0u;
#ifdef SECOND
    if (seen && known) {
        ivec2 a = ivec2(clamp(floor((lo.xy * 0.5 + 0.5) * uCells - uMargin), vec2(0.0), vec2(uCells - 1.0)));
        ivec2 b = ivec2(clamp(floor((hi.xy * 0.5 + 0.5) * uCells + uMargin), vec2(0.0), vec2(uCells - 1.0)));
        int level = 0;
        while (level < uLevels - 1 && any(greaterThanEqual((b >> level) - (a >> level), ivec2(4)))) ++level;
        float nearest = lo.z - max(uSlack.x * abs(lo.z), uSlack.y);
        seen = false;
        for (int y = a.y >> level; y <= b.y >> level; ++y)
            for (int x = a.x >> level; x <= b.x >> level; ++x) seen = seen || nearest <= texelFetch(uFarthest, ivec3(x, y, 0), level).r;
    }
    visible[index] = seen ? 1u : 0u;
    if (before) return;  // drawn in the first phase, if it is in view
#endif
    if (seen) addToList(i, p, position);
}
