// Forward shading without shadows: what the bare loop draws.
#include "lib/surface.glsl"
#include "lib/shading.glsl"
layout(location = 0) out vec4 oColour;

void main() {
    Surface s = surface();
    oColour = vec4(shade(s.albedo, uAlbedo.a, s.normal, -normalize(vPosition), 1.0), 1.0);
}
