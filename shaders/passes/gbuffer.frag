#include "lib/gbuffer.glsl"
#include "lib/surface.glsl"
layout(location = 0) out vec4 oAlbedo;   // sRGB target: linear colour, specular strength
layout(location = 1) out vec4 oNormals;  // shading normal, geometric normal

void main() {
    Surface s = surface();
    oAlbedo = vec4(s.albedo, uAlbedo.a);
    oNormals = vec4(encodeUnit(s.normal), encodeUnit(s.geometricNormal));
}
