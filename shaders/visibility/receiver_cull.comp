// Keeps the casters that can darken a receiver in sight: those whose box, seen from the sun, covers a cell in which some
// receiver's look-up begins that lies no nearer to the sun than the box does.
#include "lib/item_table.glsl"
#include "lib/receiver_key.glsl"
layout(binding = 0) uniform usampler2DArray uReceivers;
uniform int uLayer;
#define SIGN 1.0
#define CELL_VALUE(cell, level) valueOfKey(texelFetch(uReceivers, ivec3(cell, uLayer), level).r)
float valueOfKey(uint key) { return isReceiver(key) ? depthOfKey(key) : -1e30; }
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
