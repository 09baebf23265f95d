// Diffuse light of one lamp, unshadowed: attenuation and cone as KHR_lights_punctual recommends.
#include "lib/gbuffer.glsl"
#include "lib/lamp.glsl"
#include "lib/view.glsl"
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
flat in int vLamp;
layout(location = 0) out vec4 oColour;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(uDepth, pixel, 0).r;
    if (depth == 0.0) discard;
    Lamp lamp = lamps[vLamp];
    vec3 toLamp = lamp.position.xyz - viewRay(gl_FragCoord.xy) * eyeDepth(depth);
    float squared = dot(toLamp, toLamp), range = lamp.position.w;
    if (squared >= range * range) discard;
    toLamp *= inversesqrt(squared);
    uvec4 surface = texelFetch(uSurface, pixel, 0);
    vec3 albedo = unpackUnorm4x8(surface.x).rgb;
    float fade = squared / (range * range);
    float cone = clamp((dot(-toLamp, lamp.direction.xyz) - lamp.direction.w) * lamp.intensity.w, 0.0, 1.0);
    float light = max(dot(unpackNormal(surface.y), toLamp), 0.0) * (1.0 - fade * fade) * cone * cone / squared;
    oColour = vec4(albedo * albedo * lamp.intensity.rgb * light, 0.0);
}
