// Casters into a light map: depth alone. Serves every family; the matrix says which space.
#include "lib/instance.glsl"
#ifdef ALPHA_TEST
layout(location = 2) in vec2 aUv;
out vec2 vUv;
#endif
uniform mat4 uLightClip;

void main() {
#ifdef ALPHA_TEST
    vUv = aUv;
#endif
    gl_Position = uLightClip * vec4(instancePosition(), 1.0);
}
