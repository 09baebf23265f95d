// One look-up per pixel into the map that serves its depth. V in red, validity in green.
#include "lib/map_lookup.glsl"
#include "lib/filter.glsl"
layout(binding = 3) uniform sampler2DArrayShadow uMap;
layout(location = 0) out vec2 oVisibility;

void main() {
    MapLookup at = mapLookup(ivec2(gl_FragCoord.xy));
    if (!at.receiver || !at.facesSun) oVisibility = vec2(at.receiver ? 0.0 : 1.0, 0.0);
    else oVisibility = vec2(at.mapped ? filtered(uMap, MapSquare(vec3(0.0, 0.0, at.layer), uSize, uSize), at.texels, at.z, at.slope) : 1.0, 1.0);
}
