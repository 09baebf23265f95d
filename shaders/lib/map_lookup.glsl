// Where a pixel's receiver is looked up in the maps of a scene: for the resolve, and for the masks of what it will read.
#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/bias.glsl"
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
uniform vec3 uLight;
uniform vec3 uBasisU, uBasisV;
uniform mat4 uLightClips[8];
uniform vec4 uSplits[8];  // far end of the cascade (metres), depth step (metres), map present, farthest coordinate (metres)
uniform vec4 uTexels[8];  // orthographic maps: a texel's extent along u and v, metres
uniform int uLayers;
uniform float uSize;

struct MapLookup {
    bool receiver, facesSun, mapped;  // no sky; not in its own shade; some caster can reach its slice of the view
    int layer;
    vec2 texels;  // place in the map
    float z;      // reference, but for the slope's bias, which only lessens it
    Slope slope;  // in depths of the map
};

MapLookup mapLookup(ivec2 pixel) {
    MapLookup at = MapLookup(false, false, false, 0, vec2(0.0), 0.0, Slope(vec2(0.0), vec2(0.0), 0.0));
    float depth = texelFetch(uDepth, pixel, 0).r;
    if (depth == 0.0) return at;
    at.receiver = true;
    vec3 normal = unpackNormal(texelFetch(uSurface, pixel, 0).z);
    if (dot(normal, uLight) >= 0.0) return at;
    at.facesSun = true;
    float z = eyeDepth(depth);
    vec3 p = viewRay(vec2(pixel) + 0.5) * z;
    while (at.layer < uLayers - 1 && z >= uSplits[at.layer].x) ++at.layer;
    if (uSplits[at.layer].z == 0.0) return at;
    at.mapped = true;

    mat4 clip = uLightClips[at.layer];
    float facing = facingOf(normal, uLight);
    vec2 across = vec2(dot(normal, uBasisU), dot(normal, uBasisV));
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

    // How far such a step moves the map's depth, in metres along the light: across the light, and on the receiver's
    // plane, which it follows by going dot(normal, step) / facing along the light.
    vec2 gradient = vec2(perU.z, perV.z) / perL.z;
    vec2 flatStep = vec2(dot(gradient, stepU), dot(gradient, stepV));
    Slope slope = slopeOf(across, vec2(length(stepU), length(stepV)), facing);
    slope.perTexel = flatStep + vec2(dot(across, stepU), dot(across, stepV)) / facing;
#else  // an orthographic map has the same texel everywhere
    vec2 flatStep = vec2(0.0);
    vec3 perL = (clip * vec4(uLight, 0.0)).xyz;
    Slope slope = slopeOf(across, uTexels[at.layer].xy, facing);
#endif
    vec4 split = uSplits[at.layer];
    vec4 moved = clip * vec4(biased(p, normal, uLight, slope.texel, abs(flatStep), split.w, split.y), 1.0);
    vec3 s = moved.xyz / moved.w;
    at.texels = (s.xy * 0.5 + 0.5) * uSize;
    at.z = s.z;
    at.slope = times(slope, perL.z);
    return at;
}
