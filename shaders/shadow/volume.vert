// Shadow volume of one instance's silhouette, made from the vertex index: every face is a cap, near where it faces the
// sun, far where it does not, and every edge between a lit and an unlit face is a side. Closed by topology whatever the
// signs are, because a face's sign is computed in one way alone.
#include "lib/instance.glsl"
struct Face {
    vec4 normal;
    uvec4 corners;
};
layout(std430, binding = 0) restrict readonly buffer Corners { vec4 corners[]; };
layout(std430, binding = 1) restrict readonly buffer Faces { Face faces[]; };
layout(std430, binding = 2) restrict readonly buffer Edges { uvec4 edges[]; };  // from, to, face that runs so, face that runs back
uniform mat4 uClipFromRelative;
invariant gl_Position;  // as in the G-buffer
uniform vec3 uLight;
uniform int uFirstFace, uFaces, uFirstEdge;
uniform float uTop;        // of the prototype, metres
uniform float uExtrusion;  // metres: behind the whole scene
uniform float uFloor;      // height of the lowest receiver, relative to the eye

bool facesSun(uint face) {
    precise float along = dot(faces[face].normal.xyz, rotateYaw(uLight, vec2(aCosSinYaw.x, -aCosSinYaw.y)));
    return along < 0.0;
}

void main() {
    int index = gl_VertexID - 3 * uFaces;
    uint corner;
    bool moved;
    if (index < 0) {
        uint face = uint(uFirstFace + gl_VertexID / 3);
        corner = faces[face].corners[gl_VertexID % 3];
        moved = !facesSun(face);
    } else {
        uvec4 edge = edges[uFirstEdge + index / 6];
        bool left = facesSun(edge.z);
        if (left == facesSun(edge.w)) {
            gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // no silhouette: nothing
            return;
        }
        // Against the direction of the lit face: back along the edge, then forth along its moved image.
        int turn = index % 6, k = turn < 3 ? turn : turn == 3 ? 0 : turn - 2;
        bool atStart = (k == 1 || k == 2) == left;
        corner = atStart ? edge.x : edge.y;
        moved = k >= 2;
    }
    vec3 position = placed(corners[corner].xyz);
    // Below the lowest receiver there is nothing to darken: a high sun makes short volumes.
    float extrusion = min(uExtrusion, (aInstance.z + aInstance.w * uTop - uFloor) / max(-uLight.z, 1e-6));
    if (moved) position += uLight * extrusion;
    gl_Position = uClipFromRelative * vec4(position, 1.0);
}
