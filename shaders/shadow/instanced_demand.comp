// Texels a side that each map needs for a texel per pixel, summed over the receivers that look it up, of every fourth pixel
// across and down: resolution estimation (Ferko et al.), per map instead of per light.
#include "lib/instanced_resolve.glsl"
#include "lib/receiver_box.glsl"
layout(local_size_x = 16, local_size_y = 16) in;
layout(std430, binding = 4) restrict buffer Demand { uint demand[]; };  // by map: sum of texels / UNIT
uniform int uCasters;
uniform float uPadTexels;  // about the object in each map
uniform float uMost;  // texels a side that a map may have
shared uint sList[256];
shared uint sCount;

// Footprint of a pixel on the receiver's plane: metres for a step across and one up.
mat2x3 footprint(vec3 ray, float z, vec3 normal) {
    float along = dot(normal, ray);
    vec3 across = uRight.xyz * 2.0 * uPixel.x, up = uUp.xyz * 2.0 * uPixel.y;
    return z * mat2x3(across - ray * (dot(normal, across) / along), up - ray * (dot(normal, up) / along));
}

// Smaller singular value.
float shortest(mat2 m) {
    float a = dot(m[0], m[0]), b = dot(m[1], m[1]), c = dot(m[0], m[1]);
    float larger = 0.5 * (a + b + sqrt((a - b) * (a - b) + 4.0 * c * c));
    return abs(determinant(m)) / sqrt(max(larger, 1e-30));
}

void ask(uint index, CasterMap map, Caster c, mat2x3 metres) {
    Basis b = basisOf(map);
    mat2 seen = mat2(dot(metres[0], b.u), dot(metres[0], b.v), dot(metres[1], b.u), dot(metres[1], b.v));  // from the sun
    // Of the object alone, without what surrounds it: that depends on the present side, which must not feed back.
    float share = max(0.5, 1.0 - 2.0 * uPadTexels / map.square.w);
    vec2 perSide = map.texels.xy / map.square.w / share * c.place.w;  // objects by metre
    float step = shortest(mat2(seen[0] * perSide, seen[1] * perSide));
    // What lies at a crown's edge moves with the rotation between map and caster; finer texels only draw that sharper.
    step = length(vec2(step, ROTATION * atan(map.turn.y, map.turn.x)));
    atomicAdd(demand[index], uint(min(1.0 / max(step, 1e-9), uMost) / UNIT + 0.5));
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) * STRIDE + STRIDE / 2, size = textureSize(uDepth, 0);
    uint thread = gl_LocalInvocationIndex;
    clearReceiverBox();
    float depth = all(lessThan(pixel, size)) ? texelFetch(uDepth, pixel, 0).r : 0.0;
    vec3 p = vec3(0.0);
    mat2x3 metres = mat2x3(0.0);
    bool asks = false;
    if (depth > 0.0) {
        vec3 ray = viewRay(vec2(pixel) + 0.5), normal = geometricNormal(pixel);
        p = ray * eyeDepth(depth);
        asks = dot(normal, uLight) < -LEAST_FACING;
        metres = footprint(ray, eyeDepth(depth), normal);
        if (asks) addReceiver(p);
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
        for (uint k = 0u; k < sCount && asks; ++k) {
            Caster c = casters[sList[k]];
            float pad = uintBitsToFloat(c.refers.z);
            c.reach.xyz += 1e-3 * length(c.reach.xyz - pad) - pad;  // a little more: its own faces are on the box
            if (!inVolume(c, p)) continue;
            bool both = MODE != 0 && c.reach.w > 0.0;
            if (both || c.reach.w < 0.5) ask(c.refers.x, c.first, c, metres);
            if (both || c.reach.w >= 0.5) ask(c.refers.y, c.second, c, metres);
        }
        barrier();
    }
}
