// Forward shading without shadows: what the bare loop draws.
#include "lib/surface.glsl"
#include "lib/shading.glsl"
layout(location = 0) out vec4 oColour;

void main() {
    Surface s = surface();
    float lit[SUNS];
    for (int i = 0; i < SUNS; ++i) lit[i] = 1.0;
    oColour = vec4(shade(s.albedo, uAlbedo.a, s.normal, -normalize(vPosition), lit), 1.0);
}
