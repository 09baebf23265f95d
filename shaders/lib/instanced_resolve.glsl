// What the resolves of instanced maps share: the receiver under a pixel, and the look-up.
#include "lib/gbuffer.glsl"
#include "lib/view.glsl"
#include "lib/bias.glsl"
#if MODE == 2
#define MAP_SAMPLER sampler2DArray
#else
#define ATLAS
#include "lib/filter.glsl"
#define MAP_SAMPLER sampler2DArrayShadow
#endif
layout(binding = 1) uniform usampler2D uSurface;
layout(binding = 2) uniform sampler2D uDepth;
uniform vec3 uLight;
#define LOOK_UP
#include "lib/instanced.glsl"

vec3 geometricNormal(ivec2 pixel) { return unpackNormal(texelFetch(uSurface, pixel, 0).z); }
