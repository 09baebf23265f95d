// Start of the visibility image: lit where the surface faces the sun. Copies depth: volumes that test against the depth
// buffer cannot read it, and those that count in a stencil need one beside it.
#include "lib/gbuffer.glsl"
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
uniform vec3 uLight;
#ifdef UNLIT
uniform float uUnlit;
#endif
layout(location = 0) out vec2 oVisibility;
#ifdef OWN_DEPTH
#define oDepth gl_FragDepth
#else
layout(location = 1) out float oDepth;
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(uDepth, pixel, 0).r;
    bool lit = depth > 0.0 && dot(unpackNormal(texelFetch(uSurface, pixel, 0).z), uLight) < 0.0;
    oVisibility = depth == 0.0 ? vec2(1.0, 0.0) : lit ? vec2(1.0) : vec2(0.0);
#ifdef UNLIT
    depth = lit ? depth : uUnlit;
#endif
    oDepth = depth;
}
