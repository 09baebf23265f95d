// Lists the groups that are worth a look in their order, by one invocation, and how many work groups they take: at most
// MOST_WORK_GROUPS along one axis.
layout(local_size_x = 1) in;
uniform int uGroups;
layout(std430, binding = 7) restrict readonly buffer WorthALook { uint worthALook[]; };
layout(std430, binding = 4) restrict writeonly buffer ListedGroups { uint x, y, z, listedCount, listed[]; };
void main() {
    uint n = 0u;
    for (uint group = 0u; group < uint(uGroups); ++group)
        if (worthALook[group] != 0u) listed[n++] = group;
    listedCount = n;
    x = min(n, MOST_WORK_GROUPS);
    y = (n + MOST_WORK_GROUPS - 1u) / MOST_WORK_GROUPS;
    z = 1u;
}
