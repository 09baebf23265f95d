// One look-up per pixel inside a bounding shadow volume; survivors are dark. Or, to count candidates, no look-up.
#ifdef MARK_TEXELS
layout(early_fragment_tests) in;
#endif
#include "lib/instanced_resolve.glsl"
// What a look-up reads of a caster comes from the vertices: on a software rasteriser reading buffers at every pixel costs more.
flat in Caster vCaster;
#ifdef COUNT_CANDIDATES
layout(location = 0) out float oCount;
#else
layout(location = 0) out vec2 oVisibility;
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(uDepth, pixel, 0).r;
    if (depth == 0.0) discard;  // front faces lie before the sky, too
    vec3 p = viewRay(gl_FragCoord.xy) * eyeDepth(depth);
#ifndef SKIP_TEST
    if (!inVolume(vCaster, p)) discard;
#endif
    vec3 normal = geometricNormal(pixel);
    if (dot(normal, uLight) >= 0.0) discard;  // dark already: it asks no map
#ifdef COUNT_CANDIDATES
    oCount = 1.0;
#else
    float lit = lookUp(vCaster, p, normal);
    if (lit >= 1.0) discard;
#ifdef TRANSLUCENT
    lit = mix(vCaster.box.w, 1.0, lit);
#endif
    oVisibility = vec2(lit, 1.0);
#endif
}
