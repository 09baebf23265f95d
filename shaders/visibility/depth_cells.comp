// The finest level of a pyramid of farthest depths: each cell of CELL × CELL pixels, an even number. SIGN −1: of reversed depths.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D uDepth;
layout(r32f, binding = 0) uniform restrict writeonly image2DArray uCells;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy), size = textureSize(uDepth, 0), first = cell * CELL;
    if (any(greaterThanEqual(first, size))) return;
    float farthest = -1e30;
    for (int y = 1; y < CELL; y += 2)
        for (int x = 1; x < CELL; x += 2) {  // past the image's edge its last pixels are read again
            vec4 four = SIGN * textureGather(uDepth, vec2(first + ivec2(x, y)) / vec2(size));
            farthest = max(farthest, max(max(four.x, four.y), max(four.z, four.w)));
        }
    imageStore(uCells, ivec3(cell, 0), vec4(farthest));
}
