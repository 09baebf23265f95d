// Box about the receivers of a work group, kept in shared memory as integers of the floats' order.
shared int sLo[3], sHi[3];

int ordered(float v) {
    int i = floatBitsToInt(v);
    return i >= 0 ? i : i ^ 0x7FFFFFFF;
}
float fromOrdered(int i) { return intBitsToFloat(i >= 0 ? i : i ^ 0x7FFFFFFF); }

// By all threads, before and after.
void clearReceiverBox() {
    if (gl_LocalInvocationIndex < 3u) {
        sLo[gl_LocalInvocationIndex] = 0x7FFFFFFF;
        sHi[gl_LocalInvocationIndex] = -0x7FFFFFFF;
    }
    barrier();
}
void addReceiver(vec3 p) {
    for (int k = 0; k < 3; ++k) {
        atomicMin(sLo[k], ordered(p[k]));
        atomicMax(sHi[k], ordered(p[k]));
    }
}
bool hasReceivers() { return sLo[0] <= sHi[0]; }
// Larger than the receivers need by 1e-5 of the distance, for what the caster's transform rounds.
void receiverBox(out vec3 centre, out vec3 reach) {
    vec3 lo = vec3(fromOrdered(sLo[0]), fromOrdered(sLo[1]), fromOrdered(sLo[2]));
    vec3 hi = vec3(fromOrdered(sHi[0]), fromOrdered(sHi[1]), fromOrdered(sHi[2]));
    centre = 0.5 * (lo + hi);
    reach = 0.5 * (hi - lo) + 1e-5 * (1.0 + abs(centre));
}
