// One look-up per pixel inside a bounding shadow volume; survivors are dark.
#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/bias.glsl"
#if MODE != 2
#include "lib/filter.glsl"
layout(binding = 3) uniform sampler2DArrayShadow uMap;
#else
layout(binding = 3) uniform sampler2DArray uMap;
#endif
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;  // the copy
uniform vec3 uLight;
uniform vec3 uBasisU, uBasisV;
uniform vec3 uBoxCentre, uBoxHalf;
uniform vec2 uDepthRange;   // nearest light depth, 1 / range; metres from the prototype's origin
uniform vec4 uWindows[72];  // per rotation: centre, 1 / half size
uniform int uFirstLayer, uRotations;
uniform float uSize;
flat in vec4 vInstance;
flat in vec2 vCosSinYaw;
flat in vec2 vRotation;
layout(location = 0) out vec2 oVisibility;

vec3 unrotate(vec3 p) {
    return vec3(vCosSinYaw.x * p.x + vCosSinYaw.y * p.y, vCosSinYaw.x * p.y - vCosSinYaw.y * p.x, p.z);
}

// Does the ray from q toward the sun meet the box? Slab test; q and the light in the box's axes.
bool inVolume(vec3 q, vec3 light) {
    vec3 safe = mix(light, vec3(1e-12), lessThan(abs(light), vec3(1e-12)));
    vec3 t1 = (q - uBoxHalf) / safe, t2 = (q + uBoxHalf) / safe;
    vec3 enter = min(t1, t2), leave = max(t1, t2);
    return min(min(leave.x, leave.y), leave.z) >= max(0.0, max(max(enter.x, enter.y), enter.z));
}

// Texel coordinates and normalised depth of q in map k. `turn`: k's rotation minus the instance's, radians.
vec3 mapCoordinates(int k, vec3 q, float turn) {
#ifdef SAMPLE_ROTATED
    float c = cos(turn), s = sin(turn);
    q = vec3(c * q.x - s * q.y, s * q.x + c * q.y, q.z);
#endif
    vec4 w = uWindows[k];
    vec2 uv = (vec2(dot(q, uBasisU), dot(q, uBasisV)) - w.xy) * w.zw * 0.5 + 0.5;
    return vec3(uv * uSize, (dot(q, uLight) - uDepthRange.x) * uDepthRange.y);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 p = viewRay(gl_FragCoord.xy) * eyeDepth(texelFetch(uDepth, pixel, 0).r);
    if (!inVolume(unrotate((p - vInstance.xyz) / vInstance.w) - uBoxCentre, unrotate(uLight))) discard;
    vec3 normal = unpackNormal(texelFetch(uSurface, pixel, 0).z);
    if (dot(normal, uLight) >= 0.0) discard;  // dark already

    int k0 = int(vRotation.x), k1 = k0 + 1 == uRotations ? 0 : k0 + 1;
    float weight = vRotation.y, turnStep = 6.283185307179586 / float(uRotations);
    vec4 w0 = uWindows[k0], w1 = uWindows[k1];
    vec2 texel = 2.0 / uSize / min(w0.zw, w1.zw) * vInstance.w;
    float depthStep = vInstance.w / uDepthRange.y * 1.1920929e-7;
    vec2 slope = abs(vec2(dot(normal, uBasisU), dot(normal, uBasisV))) * texel / max(-dot(normal, uLight), 1e-4);
    p = biased(p, normal, uLight, max(texel.x, texel.y), slope, vec2(0.0), depthStep);
    vec3 q = (p - vInstance.xyz) / vInstance.w;
    vec3 s0 = mapCoordinates(k0, q, -weight * turnStep), s1 = mapCoordinates(k1, q, (1.0 - weight) * turnStep);
    float layer0 = float(uFirstLayer + k0), layer1 = float(uFirstLayer + k1);

    float lit;
#if MODE == 0    // the nearer map alone
    bool first = weight < 0.5;
    vec3 s = first ? s0 : s1;
    lit = filtered(uMap, first ? layer0 : layer1, s.xy, uSize, s.z);
#elif MODE == 1  // binary results, blended
    lit = filtered(uMap, layer0, s0.xy, uSize, s0.z);
    if (weight > 0.0) lit = mix(lit, filtered(uMap, layer1, s1.xy, uSize, s1.z), weight);
#else            // depths, interpolated before the comparison; a cleared texel is not a depth
    float d0 = texture(uMap, vec3(s0.xy / uSize, layer0)).r, d1 = texture(uMap, vec3(s1.xy / uSize, layer1)).r;
    float z0 = min(s0.z, 1.0), z1 = min(s1.z, 1.0);
    bool first = weight < 0.5;
    if (d0 < 1.0 && d1 < 1.0) lit = mix(d0 - z0, d1 - z1, weight) < 0.0 ? 0.0 : 1.0;
    else lit = (first ? d0 < z0 : d1 < z1) ? 0.0 : 1.0;
#endif
    if (lit >= 1.0) discard;
    oVisibility = vec2(lit, 1.0);
}
