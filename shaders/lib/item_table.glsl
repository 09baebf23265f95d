// The scene's items for compute shaders that choose what is drawn, and the list that they fill. Those with GROUPS look at groups
// of neighbours, an invocation to each; the others at a group's items, one work group to each. Matches gpuscene/item_table.cpp.
layout(local_size_x = 64) in;
struct TableItem {
    vec3 translation;  // metres from Scene::origin
    float scale;
    vec2 cosSinYaw;
    uint firstBox, firstCommand, commands, firstSlot, padding0, padding1;
};
struct NestedBox {     // of its part, prototype space
    vec3 lo;
    uint next;         // past those within this one, which follow it
    vec3 hi;
    uint padding;
};
struct TableGroup {
    vec3 lo;           // of the box of all its items, metres from Scene::origin
    uint first;
    vec3 hi;
    uint count;
};
struct InstanceData {  // six floats: std430 would round a vec3 up
    float position[3], scale, cosSinYaw[2];
};
struct IndirectCommand {
    uint indices, instances, firstIndex;
    int baseVertex;
    uint firstInstance;
};
layout(std430, binding = 0) restrict readonly buffer TableItems { TableItem tableItems[]; };
layout(std430, binding = 1) restrict readonly buffer TableBoxes { NestedBox tableBoxes[]; };
layout(std430, binding = 2) restrict writeonly buffer ListData { InstanceData listData[]; };
layout(std430, binding = 3) restrict buffer ListCommands { IndirectCommand listCommands[]; };
layout(std430, binding = 5) restrict writeonly buffer ListPlaces { uint listPlaces[]; };
layout(std430, binding = 4) restrict readonly buffer TableGroups { TableGroup tableGroups[]; };
#ifdef GROUPS
layout(std430, binding = 7) restrict writeonly buffer WorthALook { uint worthALook[]; };  // by group: 1 where its items are
#else
// The groups that are, in their order (visibility/list_groups.comp), so that their items are added in theirs.
layout(std430, binding = 7) restrict readonly buffer ListedGroups { uint listedX, listedY, listedZ, listedCount, listed[]; };
#endif

uniform dvec3 uEye;  // metres from Scene::origin; subtracted in double, as the CPU does
uniform int uGroups;

vec3 relative(vec3 position) { return vec3(dvec3(position) - uEye); }

// A box that is scaled and turned about the vertical through `position`, metres relative to the eye.
struct Box {
    vec3 position, lo, hi;
    float scale;
    vec2 cosSinYaw;
};
Box boxOf(TableItem i) {
    NestedBox all = tableBoxes[i.firstBox];
    return Box(relative(i.translation), all.lo, all.hi, i.scale, i.cosSinYaw);
}
Box boxOf(TableGroup g) { return Box(relative(g.lo), vec3(0.0), g.hi - g.lo, 1.0, vec2(1.0, 0.0)); }

vec3 boxCorner(Box b, uint corner) {
    vec3 at = mix(b.lo, b.hi, bvec3(corner & 1u, corner & 2u, corner & 4u));
    vec3 turned = vec3(b.cosSinYaw.x * at.x - b.cosSinYaw.y * at.y, b.cosSinYaw.y * at.x + b.cosSinYaw.x * at.y, at.z);
    return b.position + b.scale * turned;
}

void addToList(uint place, TableItem i) {
    if (i.commands == 0u) return;
    uint slot = atomicAdd(listCommands[i.firstCommand].instances, 1u);
    for (uint m = 1u; m < i.commands; ++m) atomicAdd(listCommands[i.firstCommand + m].instances, 1u);
    listPlaces[i.firstSlot + slot] = place;
    vec3 position = relative(i.translation);
    listData[i.firstSlot + slot] = InstanceData(float[3](position.x, position.y, position.z), i.scale, float[2](i.cosSinYaw.x, i.cosSinYaw.y));
}

#ifndef GROUPS
// The table's place of this invocation's item; false: it has none. `all`: of all groups, not only of those worth a look.
bool placeOfItem(bool all, out uint place) {
    uint n = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (n >= (all ? uint(uGroups) : listedCount)) return false;
    TableGroup g = tableGroups[all ? n : listed[n]];
    place = g.first + gl_LocalInvocationIndex;
    return gl_LocalInvocationIndex < g.count;
}
#endif
