// Casters into a light map: depth alone. Serves every family; the matrix says which space.
#include "lib/instance.glsl"
#ifdef ALPHA_TEST
layout(location = 2) in vec2 aUv;
out vec2 vUv;
#endif
#ifdef POSITION
out vec3 vPosition;  // relative to the eye
#endif
uniform mat4 uLightClip;
invariant gl_Position;  // variants of one draw must agree

void main() {
#ifdef ALPHA_TEST
    vUv = aUv;
#endif
    vec3 position = instancePosition();
#ifdef POSITION
    vPosition = position;
#endif
    gl_Position = uLightClip * vec4(position, 1.0);
}
