// The surface under a fragment: colour, shading normal and geometric normal, both on the viewer's side.
#ifdef TEXTURED
in vec2 vUv;
layout(binding = 0) uniform sampler2D uColour;
#endif
#ifdef ALPHA_TEST
#include "lib/alpha_test.glsl"
#endif
in vec3 vPosition;
in vec3 vNormal;
uniform vec4 uAlbedo;  // linear colour, specular strength
uniform int uTextured;

struct Surface {
    vec3 albedo, normal, geometricNormal;
};
Surface surface() {
    // The triangle's own plane; derivatives must be taken before any discard.
    vec3 geometric = normalize(cross(dFdx(vPosition), dFdy(vPosition)));
    vec3 albedo = uAlbedo.rgb;
#ifdef TEXTURED
    vec3 texel = texture(uColour, vUv).rgb;
    if (uTextured != 0) albedo *= texel;
#endif
#ifdef ALPHA_TEST
    alphaTest(vUv);
#endif
    // The triangle's plane faces the viewer by the derivatives' order; the vertices' normal may not.
    vec3 normal = vNormal == vec3(0.0) ? geometric : normalize(vNormal);  // flat meshes carry none
    if (dot(normal, geometric) < 0.0) normal = -normal;
    return Surface(albedo, normal, geometric);
}
