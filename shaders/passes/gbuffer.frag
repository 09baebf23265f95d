#include "lib/gbuffer.glsl"
#include "lib/surface.glsl"
layout(location = 0) out uvec4 oSurface;

void main() {
    Surface s = surface();
    oSurface = uvec4(packUnorm4x8(vec4(sqrt(s.albedo), uAlbedo.a)), packNormal(s.normal), packNormal(s.geometricNormal), 0u);
}
