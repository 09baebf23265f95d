// The next level of a pyramid of largest values: unsigned integers, or FLOATS.
layout(local_size_x = 8, local_size_y = 8) in;
#ifdef FLOATS
#define VALUE float
#define VECTOR vec4
layout(r32f, binding = 0) uniform restrict readonly image2DArray uFine;
layout(r32f, binding = 1) uniform restrict writeonly image2DArray uCoarse;
#else
#define VALUE uint
#define VECTOR uvec4
layout(r32ui, binding = 0) uniform restrict readonly uimage2DArray uFine;
layout(r32ui, binding = 1) uniform restrict writeonly uimage2DArray uCoarse;
#endif

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell.xy, imageSize(uCoarse).xy))) return;
    VALUE most = imageLoad(uFine, ivec3(2 * cell.xy, cell.z)).r;
    for (int corner = 1; corner < 4; ++corner) most = max(most, imageLoad(uFine, ivec3(2 * cell.xy + ivec2(corner & 1, corner >> 1), cell.z)).r);
    imageStore(uCoarse, cell, VECTOR(most));
}
