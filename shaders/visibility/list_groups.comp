// Lists the groups that are worth a look in their order, by one invocation, and how many work groups they take: at most MOST_GROUPS
// along one axis. So many are looked at a dispatch, from uFirst on, as Mesa's llvmpipe leaves a loop after 65,535 rounds.
layout(local_size_x = 1) in;
uniform int uFirst, uGroups;
layout(std430, binding = 7) restrict readonly buffer WorthALook { uint worthALook[]; };
layout(std430, binding = 4) restrict buffer ListedGroups { uint x, y, z, listedCount, listed[]; };
void main() {
    uint n = uFirst == 0 ? 0u : listedCount;
    for (uint group = uint(uFirst); group < min(uint(uFirst) + MOST_GROUPS, uint(uGroups)); ++group)
        if (worthALook[group] != 0u) listed[n++] = group;
    listedCount = n;
    x = min(n, MOST_GROUPS);
    y = (n + MOST_GROUPS - 1u) / MOST_GROUPS;
    z = 1u;
}
