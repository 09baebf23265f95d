// The cube about a lamp's range, seen from inside or outside: its faces that look away from the eye cover the same pixels
// once. Metres relative to the eye.
#include "lib/lamp.glsl"
uniform mat4 uClipFromRelative;
flat out int vLamp;

// Counter-clockwise from outside, six corners a face; bits x, y, z of a corner.
const int kCorners[36] = int[](0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6);

void main() {
    vLamp = gl_InstanceID;
    int corner = kCorners[gl_VertexID];
    vec3 side = vec3(corner & 1, corner >> 1 & 1, corner >> 2) * 2.0 - 1.0;
    Lamp lamp = lamps[gl_InstanceID];
    gl_Position = uClipFromRelative * vec4(lamp.position.xyz + lamp.position.w * side, 1.0);
}
