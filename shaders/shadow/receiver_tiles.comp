// A box about the receivers of each TILE × TILE pixels that face the sun; reach.x < 0 where there is none.
#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/receiver_box.glsl"
layout(local_size_x = 16, local_size_y = 16) in;
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
uniform vec3 uLight;
struct Tile {
    vec4 centre, reach;
};
layout(std430, binding = 5) restrict writeonly buffer Tiles { Tile tiles[]; };

void main() {
    clearReceiverBox();
    ivec2 size = textureSize(uDepth, 0), first = ivec2(gl_WorkGroupID.xy) * TILE + ivec2(gl_LocalInvocationID.xy);
    vec3 lo = vec3(0.0), hi = vec3(0.0);
    bool some = false;
    for (int y = 0; y < TILE; y += 16)
        for (int x = 0; x < TILE; x += 16) {
            ivec2 pixel = first + ivec2(x, y);
            if (any(greaterThanEqual(pixel, size))) continue;
            float depth = texelFetch(uDepth, pixel, 0).r;
            if (depth == 0.0 || dot(unpackNormal(texelFetch(uSurface, pixel, 0).z), uLight) >= 0.0) continue;
            vec3 p = viewRay(vec2(pixel) + 0.5) * eyeDepth(depth);
            lo = some ? min(lo, p) : p;
            hi = some ? max(hi, p) : p;
            some = true;
        }
    if (some) {
        addReceiver(lo);
        addReceiver(hi);
    }
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    vec3 centre = vec3(0.0), reach = vec3(-1.0);
    if (hasReceivers()) receiverBox(centre, reach);
    tiles[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = Tile(vec4(centre, 0.0), vec4(reach, 0.0));
}
