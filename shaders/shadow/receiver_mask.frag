// A map's mask of visible receivers, drawn in the map's own view. TEST: only where the camera sees the fragment, by the
// reverse shadow test (Mattausch et al. 2011, "Efficient Online Visibility for Shadow Maps", listing 1.1). ALPHA_TEST: cards.
layout(location = 0) out float oMask;
#ifdef ALPHA_TEST
in vec2 vUv;
#include "lib/alpha_test.glsl"
#endif
#ifdef TEST
#include "lib/view.glsl"
layout(binding = 2) uniform sampler2D uDepth;
uniform mat4 uClipFromRelative;
in vec3 vPosition;
#endif

void main() {
    oMask = 1.0;
#ifdef TEST
    // Half a pixel on the fragment's own plane; the paper's 1e-4 of post-projective depth means any length in metres.
    vec3 normal = cross(dFdx(vPosition), dFdy(vPosition));
    float facing = abs(dot(normal, vPosition)) / max(length(normal) * length(vPosition), 1e-30);
    vec4 clip = uClipFromRelative * vec4(vPosition, 1.0);
    vec2 pixel = (clip.xy / clip.w * 0.5 + 0.5) / uPixel;
    float slack = length(vec2(length(uRight.xyz), length(uUp.xyz)) * uPixel) * clip.w / max(facing, 1e-3) + 1e-5 * clip.w;
    bool seen = clip.w > 0.0 && all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, 1.0 / uPixel)) &&
                clip.w <= eyeDepth(texelFetch(uDepth, ivec2(pixel), 0).r) + slack;
    oMask = seen ? 1.0 : 0.0;
#endif
#ifdef ALPHA_TEST
    alphaTest(vUv);
#endif
}
