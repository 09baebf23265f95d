#include "lib/alpha_test.glsl"
in vec2 vUv;
void main() { alphaTest(vUv); }
