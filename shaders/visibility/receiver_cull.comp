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

void main() {
#ifdef GROUPS
    uint group = gl_GlobalInvocationID.x;
    if (group < uint(uGroups)) worthALook[group] = mayBeBefore(boxOf(tableGroups[group])) ? 1u : 0u;
#else
    uint place;
    if (!placeOfItem(false, place)) return;
    TableItem item = tableItems[place];
    if (mayBeBefore(item)) addToList(place, item);
#endif
}
