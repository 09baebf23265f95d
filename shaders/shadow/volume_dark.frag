// Darkens the pixels that some volume holds; in front of a stencil test, or by the sums.
#ifdef SUM
layout(binding = 3) uniform sampler2D uSum;
#endif
layout(location = 0) out vec2 oVisibility;

void main() {
#ifdef SUM
    if (texelFetch(uSum, ivec2(gl_FragCoord.xy), 0).r == 0.0) discard;
#endif
    oVisibility = vec2(0.0);
}
