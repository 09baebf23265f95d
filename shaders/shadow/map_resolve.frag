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
    vec3 ndc = q.xyz / q.w;
    // Columns: what a metre along u, v and the light changes in (x, y, z) after the division.
    vec4 du = clip * vec4(uBasisU, 0.0), dv = clip * vec4(uBasisV, 0.0), dl = clip * vec4(uLight, 0.0);
    vec3 perU = (du.xyz - ndc * du.w) / q.w, perV = (dv.xyz - ndc * dv.w) / q.w, perL = (dl.xyz - ndc * dl.w) / q.w;
    // Inverse of texels by metres: the steps (metres along u, v) of one texel along the map's two axes.
    vec2 a = perU.xy * (0.5 * uSize), b = perV.xy * (0.5 * uSize);
    float det = a.x * b.y - b.x * a.y;
    vec2 stepU = vec2(b.y, -a.y) / det, stepV = vec2(-b.x, a.x) / det;
    float texel = max(length(stepU), length(stepV));

    // How far such a step moves the map's depth, in metres along the light: across the light, and on the receiver's
    // plane, which it follows by going dot(normal, step) / facing along the light.
    vec2 gradient = vec2(perU.z, perV.z) / perL.z;
    vec2 flatStep = vec2(dot(gradient, stepU), dot(gradient, stepV));
    vec2 tilt = vec2(dot(normal, uBasisU), dot(normal, uBasisV)) / facing;
    vec2 slope = abs(flatStep + vec2(dot(tilt, stepU), dot(tilt, stepV))), flatSlope = abs(flatStep);
#else  // an orthographic map has the same texel everywhere
    vec2 steps = uTexels[layer].xy, flatSlope = vec2(0.0);
    vec2 slope = abs(vec2(dot(normal, uBasisU), dot(normal, uBasisV))) * steps / facing;
    float texel = max(steps.x, steps.y);
#endif
    vec4 moved = clip * vec4(biased(p, normal, uLight, texel, slope, flatSlope, uSplits[layer].y), 1.0);
    vec3 s = moved.xyz / moved.w;
    oVisibility.r = filtered(uMap, MapSquare(vec3(0.0, 0.0, layer), uSize, uSize), (s.xy * 0.5 + 0.5) * uSize, s.z);
}
