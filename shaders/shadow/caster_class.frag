// For pictures of a light's view: which kind of caster is nearest to the sun.
#ifdef ALPHA_TEST
#include "lib/alpha_test.glsl"
in vec2 vUv;
#endif
uniform float uClass;
layout(location = 0) out vec4 oClass;
void main() {
#ifdef ALPHA_TEST
    alphaTest(vUv);
#endif
    oClass = vec4(uClass);
}
