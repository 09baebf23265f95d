// One look-up per pixel into the map that serves its depth. V in red, validity in green.
#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/bias.glsl"
#include "lib/filter.glsl"
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
layout(binding = 3) uniform sampler2DArrayShadow uMap;
uniform vec3 uLight;
uniform vec3 uBasisU, uBasisV;
uniform mat4 uLightClips[8];
uniform vec4 uSplits[8];  // far end of the cascade (metres), depth step (metres), map present, unused
uniform vec4 uTexels[8];  // orthographic maps: a texel's extent along u and v, metres
uniform int uLayers;
uniform float uSize;
layout(location = 0) out vec2 oVisibility;

#ifdef WARPED
// Change of the map's normalised depth for a small world step from the point whose clip coordinates are q.
float depthStep(mat4 clip, vec4 q, vec3 worldStep) {
    vec4 d = clip * vec4(worldStep, 0.0);
    return (d.z - q.z / q.w * d.w) / q.w;
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(uDepth, pixel, 0).r;
    oVisibility = vec2(1.0, 0.0);
    if (depth == 0.0) return;  // sky
    vec3 normal = unpackNormal(texelFetch(uSurface, pixel, 0).z);
    if (dot(normal, uLight) >= 0.0) {  // the surface looks away from the sun
        oVisibility = vec2(0.0, 0.0);
        return;
    }
    float z = eyeDepth(depth);
    vec3 p = viewRay(gl_FragCoord.xy) * z;
    int layer = 0;
    while (layer < uLayers - 1 && z >= uSplits[layer].x) ++layer;
    oVisibility = vec2(1.0, 1.0);
    if (uSplits[layer].z == 0.0) return;  // no caster reaches this slice

    mat4 clip = uLightClips[layer];
    float facing = max(-dot(normal, uLight), 1e-4);
#ifdef WARPED
    vec4 q = clip * vec4(p, 1.0);
    vec2 ndc = q.xy / q.w;
    // Jacobian of texels by metres along (u, v), inverted: the world steps of one texel.
    vec4 du = clip * vec4(uBasisU, 0.0), dv = clip * vec4(uBasisV, 0.0);
    vec2 a = (du.xy - ndc * du.w) * (0.5 * uSize / q.w), b = (dv.xy - ndc * dv.w) * (0.5 * uSize / q.w);
    float det = a.x * b.y - b.x * a.y;
    vec3 Tu = (uBasisU * b.y - uBasisV * a.y) / det, Tv = (uBasisV * a.x - uBasisU * b.x) / det;

    // Steps of one texel that stay on the receiver's plane, and how far they move the map's depth along the light.
    float perMetre = (clip * vec4(uLight, 0.0)).z / q.w;
    vec3 onU = Tu + uLight * (dot(normal, Tu) / facing), onV = Tv + uLight * (dot(normal, Tv) / facing);
    vec2 slope = abs(vec2(depthStep(clip, q, onU), depthStep(clip, q, onV))) / perMetre;
    vec2 flatSlope = abs(vec2(depthStep(clip, q, Tu), depthStep(clip, q, Tv))) / perMetre;

    float texel = max(length(Tu), length(Tv));
#else  // an orthographic map has the same texel everywhere
    vec2 steps = uTexels[layer].xy, flatSlope = vec2(0.0);
    vec2 slope = abs(vec2(dot(normal, uBasisU), dot(normal, uBasisV))) * steps / facing;
    float texel = max(steps.x, steps.y);
#endif
    vec4 moved = clip * vec4(biased(p, normal, uLight, texel, slope, flatSlope, uSplits[layer].y), 1.0);
    vec3 s = moved.xyz / moved.w;
    oVisibility.r = filtered(uMap, float(layer), (s.xy * 0.5 + 0.5) * uSize, uSize, s.z);
}
