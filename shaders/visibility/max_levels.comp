// The next two levels of a pyramid of largest values: unsigned integers, or FLOATS. Sides are powers of two.
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef FLOATS
#define VALUE float
#define VECTOR vec4
#define IMAGE image2DArray
#define FORMAT r32f
#else
#define VALUE uint
#define VECTOR uvec4
#define IMAGE uimage2DArray
#define FORMAT r32ui
#endif
layout(FORMAT, binding = 0) uniform restrict readonly IMAGE uFine;
layout(FORMAT, binding = 1) uniform restrict writeonly IMAGE uCoarse;
layout(FORMAT, binding = 2) uniform restrict writeonly IMAGE uCoarser;  // uCoarse again, where that is a single cell

VALUE mostOf(ivec2 cell) {
    VALUE most = imageLoad(uFine, ivec3(2 * cell, gl_GlobalInvocationID.z)).r;
    for (int corner = 1; corner < 4; ++corner) most = max(most, imageLoad(uFine, ivec3(2 * cell + ivec2(corner & 1, corner >> 1), gl_GlobalInvocationID.z)).r);
    imageStore(uCoarse, ivec3(cell, gl_GlobalInvocationID.z), VECTOR(most));
    return most;
}

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    int side = imageSize(uCoarse).x;
    if (any(greaterThanEqual(2 * cell.xy, ivec2(side)))) return;
    VALUE most = mostOf(2 * cell.xy);
    if (side == 1) return;
    for (int corner = 1; corner < 4; ++corner) most = max(most, mostOf(2 * cell.xy + ivec2(corner & 1, corner >> 1)));
    imageStore(uCoarser, cell, VECTOR(most));
}
