#include "lib/instance.glsl"
layout(location = 1) in vec2 aNormal;  // octahedral
#ifdef TEXTURED
layout(location = 2) in vec2 aUv;
out vec2 vUv;
#endif
uniform mat4 uClipFromRelative;
invariant gl_Position;  // the caps of shadow volumes must come out at the same depth
out vec3 vPosition;  // relative to the eye
out vec3 vNormal;

void main() {
    vPosition = instancePosition();
    vNormal = rotateYaw(unpackOctahedral(aNormal), aCosSinYaw);
#ifdef TEXTURED
    vUv = aUv;
#endif
    gl_Position = uClipFromRelative * vec4(vPosition, 1.0);
}
