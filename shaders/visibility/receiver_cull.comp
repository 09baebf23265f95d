// Keeps the casters that can darken a receiver in sight: those whose box, seen from the sun, covers a cell in which some
// receiver lies no nearer to the sun than the box begins.
#include "lib/item_table.glsl"
#include "lib/receiver_key.glsl"
layout(binding = 0) uniform usampler2DArray uReceivers;
uniform int uLayer;
#define SIGN 1.0
#define CELL_VALUE(cell, level) valueOfKey(texelFetch(uReceivers, ivec3(cell, uLayer), level).r)
float valueOfKey(uint key) { return key == 0u ? -1e30 : depthOfKey(key); }
#include "lib/covered_cells.glsl"
shared bool groupAsked;

void main() {
    uint group = groupIndex(), local = gl_LocalInvocationIndex;
    if (group >= uint(uGroups)) return;
    TableGroup g = tableGroups[group];
    if (local == 0u) groupAsked = mayBeBefore(boxOf(g));
    barrier();
    if (local >= g.count || !groupAsked) return;
    TableItem i = tableItems[g.first + local];
    TablePart p = tableParts[i.part];
    Box box = boxOf(i, p);
    if (mayBeBefore(box)) addToList(g.first + local, p, box);
}
