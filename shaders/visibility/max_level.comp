// The next level of a pyramid of largest values.
layout(local_size_x = 8, local_size_y = 8) in;
layout(r32ui, binding = 0) uniform restrict readonly uimage2DArray uFine;
layout(r32ui, binding = 1) uniform restrict writeonly uimage2DArray uCoarse;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell.xy, imageSize(uCoarse).xy))) return;
    uint most = 0u;
    for (int corner = 0; corner < 4; ++corner) most = max(most, imageLoad(uFine, ivec3(2 * cell.xy + ivec2(corner & 1, corner >> 1), cell.z)).r);
    imageStore(uCoarse, cell, uvec4(most));
}
