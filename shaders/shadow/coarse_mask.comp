// A mask at the map's resolution to the cells that queries read: a cell is set when a texel of it, or nearer to it than a
// look-up reaches, is.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D uTexels;
layout(r8, binding = 0) uniform restrict writeonly image2D uMask;
uniform int uReach;  // texels

void main() {
    ivec2 cell = ivec2(gl_GlobalInvocationID.xy), cells = imageSize(uMask), size = textureSize(uTexels, 0);
    if (any(greaterThanEqual(cell, cells))) return;
    ivec2 first = max(cell * size / cells - uReach, ivec2(0)), last = min(((cell + 1) * size + cells - 1) / cells - 1 + uReach, size - 1);
    float some = 0.0;
    for (int y = first.y; y <= last.y && some < 0.5; ++y)
        for (int x = first.x; x <= last.x && some < 0.5; ++x) some = texelFetch(uTexels, ivec2(x, y), 0).r;
    imageStore(uMask, cell, vec4(some));
}
