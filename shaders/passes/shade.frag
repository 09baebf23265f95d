#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/shading.glsl"
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
#ifdef SHADOWED
layout(binding = 3) uniform sampler2D uVisibility[SUNS];
#endif
layout(location = 0) out vec4 oColour;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 ray = normalize(viewRay(gl_FragCoord.xy));
    if (texelFetch(uDepth, pixel, 0).r == 0.0) {
        oColour = vec4(sky(ray), 1.0);
        return;
    }
    uvec4 surface = texelFetch(uSurface, pixel, 0);
    vec4 albedo = unpackUnorm4x8(surface.x);
    vec3 normal = unpackNormal(surface.y);
    float visibility[SUNS];
    for (int i = 0; i < SUNS; ++i)
#ifdef SHADOWED
        visibility[i] = texelFetch(uVisibility[i], pixel, 0).r;
#else
        visibility[i] = 1.0;
#endif
    oColour = vec4(shade(albedo.rgb * albedo.rgb, albedo.a, normal, -ray, visibility), 1.0);
}
