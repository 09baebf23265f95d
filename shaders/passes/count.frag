// Counts fragments by additive blending: the overdraw image.
#ifdef ALPHA_TEST
#include "lib/alpha_test.glsl"
in vec2 vUv;
#endif
layout(location = 0) out float oCount;

void main() {
#ifdef ALPHA_TEST
    alphaTest(vUv);
#endif
    oCount = 1.0;
}
