// Leaves fragments where a mask is set, to be marked in the stencil.
layout(binding = 0) uniform sampler2D uMask;
uniform float uTexel;  // 1 / size of the map

void main() {
    if (textureLod(uMask, gl_FragCoord.xy * uTexel, 0.0).r < 0.5) discard;
}
