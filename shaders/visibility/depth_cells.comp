// The finest level of a pyramid of farthest depths: over the image, whatever its resolution. SIGN −1: of reversed depths.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D uDepth;
layout(r32f, binding = 0) uniform restrict writeonly image2DArray uCells;

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy), cells = imageSize(uCells).xy, size = textureSize(uDepth, 0);
    if (any(greaterThanEqual(cell, cells))) return;
    // Exact: the cells' number is a power of two. A division of integers would be most of the cost.
    vec2 pixels = vec2(size) / vec2(cells);
    ivec2 first = ivec2(vec2(cell) * pixels), last = ivec2(ceil(vec2(cell + 1) * pixels)) - 1;
    float farthest = -1e30;
    for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x) farthest = max(farthest, SIGN * texelFetch(uDepth, ivec2(x, y), 0).r);
    imageStore(uCells, ivec3(cell, 0), vec4(farthest));
}
