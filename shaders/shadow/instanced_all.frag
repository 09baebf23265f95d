// The baseline that binds the maps of all casters and asks them one after the other at every pixel.
#include "lib/instanced_resolve.glsl"
uniform int uCasters;
layout(location = 0) out vec2 oVisibility;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(uDepth, pixel, 0).r;
    oVisibility = vec2(1.0, 0.0);
    if (depth == 0.0) return;
    vec3 p = viewRay(gl_FragCoord.xy) * eyeDepth(depth), normal = geometricNormal(pixel);
    float lit = dot(normal, uLight) >= 0.0 ? 0.0 : 1.0;
    bool valid = lit > 0.0;
    for (int i = 0; i < uCasters && lit > 0.0; ++i) {
        Caster c = casters[i];
        if (inVolume(c, p)) lit = min(lit, lookUp(c, p, normal));
    }
    oVisibility = vec2(lit, valid ? 1.0 : 0.0);
}
