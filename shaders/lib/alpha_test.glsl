// The one alpha test of camera, maps and reference: nearest texel of level 0, the material's cut-off.
layout(binding = 1) uniform sampler2D uAlpha;
uniform float uAlphaCutoff;
void alphaTest(vec2 uv) {
    if (textureLod(uAlpha, uv, 0.0).a < uAlphaCutoff) discard;
}
