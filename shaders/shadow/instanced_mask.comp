// Keeps the casters whose shadow volumes can reach a visible receiver, for an indirect draw.
uniform vec3 uLight;
#include "lib/instanced.glsl"
layout(local_size_x = 64) in;
struct Tile {
    vec4 centre, reach;
};
layout(std430, binding = 4) restrict writeonly buffer Survivors { uint survivors[]; };
layout(std430, binding = 5) restrict readonly buffer Tiles { Tile tiles[]; };
layout(std430, binding = 6) restrict buffer Command { uint vertices, instances, firstVertex, firstInstance; };
uniform int uCasters, uTiles;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(uCasters)) return;
    Caster c = casters[i];
    CasterType type = casterTypes[c.type];
    for (int t = 0; t < uTiles; ++t) {
        if (tiles[t].reach.x < 0.0 || !mayReach(c, type, tiles[t].centre.xyz, tiles[t].reach.xyz)) continue;
        survivors[atomicAdd(instances, 1u)] = i;
        return;
    }
}
