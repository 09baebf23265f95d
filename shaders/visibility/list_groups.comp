// Lists the groups that are worth a look in their order, by one invocation, and how many work groups they take.
layout(local_size_x = 1) in;
uniform int uGroups;
layout(std430, binding = 7) restrict readonly buffer WorthALook { uint worthALook[]; };
layout(std430, binding = 4) restrict writeonly buffer ListedGroups { uint x, y, z, listedCount, listed[]; };
const uint kMostWorkGroups = 65535u;  // what GL grants a dispatch along one axis
void main() {
    uint n = 0u;
    for (uint group = 0u; group < uint(uGroups); ++group)
        if (worthALook[group] != 0u) listed[n++] = group;
    listedCount = n;
    x = min(n, kMostWorkGroups);
    y = (n + kMostWorkGroups - 1u) / kMostWorkGroups;
    z = 1u;
}
