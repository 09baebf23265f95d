// Volumes binned to screen tiles: the threads of a tile first find the casters whose volumes can reach the box about
// the tile's receivers, then each asks them for its own pixel.
#include "lib/instanced_resolve.glsl"
#include "lib/receiver_box.glsl"
layout(local_size_x = 16, local_size_y = 16) in;
layout(rg16f, binding = 0) restrict writeonly uniform image2D uVisibility;
uniform int uCasters;
shared uint sList[256];
shared uint sCount;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(uVisibility);
    uint thread = gl_LocalInvocationIndex;
    clearReceiverBox();
    bool onScreen = all(lessThan(pixel, size));
    float depth = onScreen ? texelFetch(uDepth, pixel, 0).r : 0.0;
    vec3 p = vec3(0.0), normal = vec3(0.0);
    float lit = 1.0;
    bool valid = false;  // the sky asks nobody, even where a volume holds the eye
    if (depth > 0.0) {
        p = viewRay(vec2(pixel) + 0.5) * eyeDepth(depth);
        normal = geometricNormal(pixel);
        valid = dot(normal, uLight) < 0.0;
        lit = valid ? 1.0 : 0.0;
        if (valid) addReceiver(p);
    }
    barrier();
    vec3 centre, reach;
    receiverBox(centre, reach);
    bool any = hasReceivers();
    for (int begin = 0; any && begin < uCasters; begin += 256) {
        if (thread == 0u) sCount = 0u;
        barrier();
        int i = begin + int(thread);
        if (i < uCasters) {
            vec2 along = reachOf(casters[i], centre, reach);
            if (along.y >= along.x) sList[atomicAdd(sCount, 1u)] = uint(i);
        }
        barrier();
        for (uint k = 0u; k < sCount && valid && lit > 0.0; ++k) {
            Caster c = casters[sList[k]];
            if (inVolume(c, p)) lit = min(lit, lookUp(c, p, normal));
        }
        barrier();
    }
    if (onScreen) imageStore(uVisibility, pixel, vec4(lit, valid ? 1.0 : 0.0, 0.0, 0.0));
}
