// Keeps the casters whose shadow volumes can reach a visible receiver, for an indirect draw.
uniform vec3 uLight;
#include "lib/instanced.glsl"
#include "lib/survivor.glsl"
layout(local_size_x = 64) in;
struct Tile {
    vec4 centre, reach;
};
layout(std430, binding = 4) restrict writeonly buffer Survivors { Survivor survivors[]; };
layout(std430, binding = 5) restrict readonly buffer Tiles { Tile tiles[]; };
struct Command {
    uint indices, instances, firstIndex, baseVertex, firstInstance;
};
layout(std430, binding = 6) restrict buffer Commands { Command commands[2]; };
uniform int uCasters, uTiles;
uniform int uNotAboutEye;  // so many casters are drawn by the first command, the others by the second

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(uCasters)) return;
    Caster c = casters[i];
    vec2 all = vec2(1e30, -1e30);
    for (int t = 0; t < uTiles; ++t) {
        if (tiles[t].reach.x < 0.0) continue;
        vec2 along = reachOf(c, tiles[t].centre.xyz, tiles[t].reach.xyz);
        if (along.y >= along.x) all = vec2(min(all.x, along.x), max(all.y, along.y));
    }
    if (all.y < all.x) return;
    // Room for what the vertices round, so that no face cuts a receiver off.
    float slack = 1e-3 * (length(c.reach.xyz) + all.y);
    bool about = i >= uint(uNotAboutEye);
    uint place = atomicAdd(commands[about ? 1 : 0].instances, 1u) + (about ? uint(uCasters) : 0u);
    survivors[place] = Survivor(i, max(0.0, all.x - slack), all.y + slack);
}
