// Boxes of occlusion queries, one an instance, already enlarged (visibility::queryBox): 12 triangles from the vertex's number.
layout(location = 0) in vec3 aLo;  // metres relative to the eye
layout(location = 1) in vec3 aHi;

uniform mat4 uClipFromRelative;

// Corner of a box: bit 0 picks x, bit 1 y, bit 2 z. Two triangles a face.
const int kCorners[36] = int[](0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5);

void main() {
    int corner = kCorners[gl_VertexID];
    vec3 pick = vec3(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    gl_Position = uClipFromRelative * vec4(mix(aLo, aHi, pick), 1.0);
}
