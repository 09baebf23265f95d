// Keeps the casters that can darken a receiver in sight: those whose box, seen from the sun, covers a cell in which some
// receiver lies farther from the sun than the box begins.
#include "lib/instance_table.glsl"
#include "lib/receiver_key.glsl"
layout(local_size_x = 64) in;
layout(binding = 0) uniform usampler2DArray uReceivers;
uniform int uLayer, uLevels;
uniform float uCells;       // a side of the finest level
uniform mat4 uClip;         // of the map, from metres relative to the eye
uniform float uLeastW;      // nearer to the warp's centre than this, nothing is known of a box
uniform float uMargin;      // cells that rasterisation and rounding may reach beyond the box
uniform float uDepthSlack;  // the same of its depth

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(uInstances)) return;
    TableInstance i = tableInstances[index];
    TablePrototype p = tablePrototypes[i.prototype];
    if (p.casts == 0u) return;
    vec3 position = relativePosition(i), lo = vec3(1e30), hi = vec3(-1e30);
    bool known = true;
    uint outside = 15u;  // a bit for each side of the window that all corners so far are beyond; w may be negative there
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec4 q = uClip * vec4(boxCorner(i, p, position, corner), 1.0);
        known = known && q.w > uLeastW;
        vec4 beyond = vec4(q.x + q.w, q.w - q.x, q.y + q.w, q.w - q.y);
        for (int side = 0; side < 4; ++side)
            if (beyond[side] >= 0.0) outside &= ~(1u << side);
        vec3 ndc = q.xyz / q.w;
        lo = min(lo, ndc);
        hi = max(hi, ndc);
    }
    if (outside != 0u && !known) return;
    if (known) {
        vec2 first = floor((lo.xy * 0.5 + 0.5) * uCells - uMargin), last = floor((hi.xy * 0.5 + 0.5) * uCells + uMargin);
        if (any(lessThan(last, vec2(0.0))) || any(greaterThanEqual(first, vec2(uCells)))) return;
        ivec2 a = ivec2(max(first, vec2(0.0))), b = ivec2(min(last, vec2(uCells - 1.0)));
        // The coarsest level at which it still spans at most CELLS cells a side.
        int level = 0;
        while (level < uLevels - 1 && any(greaterThanEqual((b >> level) - (a >> level), ivec2(CELLS)))) ++level;
        uint most = 0u;
        for (int y = a.y >> level; y <= b.y >> level; ++y)
            for (int x = a.x >> level; x <= b.x >> level; ++x) most = max(most, texelFetch(uReceivers, ivec3(x, y, uLayer), level).r);
        if (most == 0u || lo.z - uDepthSlack >= depthOfKey(most)) return;
    }
    addToList(i, p, position);
}
