// The scene's instances for compute shaders that choose what is drawn, and the list that they fill. Matches
// gpuscene/instance_table.cpp.
struct TableInstance {
    vec3 translation;  // metres from Scene::origin
    float scale;
    vec2 cosSinYaw;
    uint prototype, padding;
};
struct TablePrototype {
    vec3 lo;           // of its box, prototype space
    uint firstCommand;
    vec3 hi;
    uint commands;
    uint firstSlot, casts, padding0, padding1;
};
struct InstanceData {  // six floats: std430 would round a vec3 up
    float position[3], scale, cosSinYaw[2];
};
struct IndirectCommand {
    uint indices, instances, firstIndex;
    int baseVertex;
    uint firstInstance;
};
layout(std430, binding = 0) restrict readonly buffer TableInstances { TableInstance tableInstances[]; };
layout(std430, binding = 1) restrict readonly buffer TablePrototypes { TablePrototype tablePrototypes[]; };
layout(std430, binding = 2) restrict writeonly buffer ListData { InstanceData listData[]; };
layout(std430, binding = 3) restrict buffer ListCommands { IndirectCommand listCommands[]; };

uniform dvec3 uEye;  // metres from Scene::origin; subtracted in double, as the CPU does
uniform int uInstances;

vec3 relativePosition(TableInstance i) { return vec3(dvec3(i.translation) - uEye); }

// A corner of the instance's box, metres relative to the eye.
vec3 boxCorner(TableInstance i, TablePrototype p, vec3 position, uint corner) {
    vec3 at = mix(p.lo, p.hi, bvec3(corner & 1u, corner & 2u, corner & 4u));
    vec3 turned = vec3(i.cosSinYaw.x * at.x - i.cosSinYaw.y * at.y, i.cosSinYaw.y * at.x + i.cosSinYaw.x * at.y, at.z);
    return position + i.scale * turned;
}

void addToList(TableInstance i, TablePrototype p, vec3 position) {
    if (p.commands == 0u) return;
    uint slot = atomicAdd(listCommands[p.firstCommand].instances, 1u);
    for (uint m = 1u; m < p.commands; ++m) atomicAdd(listCommands[p.firstCommand + m].instances, 1u);
    listData[p.firstSlot + slot] = InstanceData(float[3](position.x, position.y, position.z), i.scale, float[2](i.cosSinYaw.x, i.cosSinYaw.y));
}
