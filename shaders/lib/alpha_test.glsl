// The one alpha test of camera, maps and reference: nearest texel of level 0, threshold of scene.h.
layout(binding = 1) uniform sampler2D uAlpha;
void alphaTest(vec2 uv) {
    if (textureLod(uAlpha, uv, 0.0).a < 0.5) discard;
}
