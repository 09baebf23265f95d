// Moves a receiver off its own surface. All lengths are metres. `texel`: the longer side of the local texel's
// footprint across the light. `slope`: how far the map's depth of the receiver's plane moves along the light per
// texel's step along the map's two axes; `flatSlope`: the same for a plane that faces the light, not zero where a
// warp bends depth. KERNEL is the filter's radius r in texels.
uniform float uBiasScale;

// A surface that grazes the light needs an unbounded bias; beyond this many texels it would detach shadows.
const float kMaxBiasTexels = 8.0;

vec3 biased(vec3 p, vec3 normal, vec3 light, float texel, vec2 slope, vec2 flatSlope, float depthStep) {
#if BIAS == 0    // constant
    float along = uBiasScale * texel + (KERNEL + 0.5) * (flatSlope.x + flatSlope.y);
#elif BIAS == 1  // slope: the least that suffices for the receiver's plane, (r + 1/2)(|g_u| + |g_v|)
    float along = uBiasScale * min((KERNEL + 0.5) * (slope.x + slope.y), kMaxBiasTexels * texel);
#else            // normal-offset, weight 1 - cos (MJP)
    p += normal * (uBiasScale * texel * (KERNEL + 0.5) * 2.0 * (1.0 + dot(normal, light)));
    float along = (KERNEL + 0.5) * (flatSlope.x + flatSlope.y);
#endif
    // Two steps of the stored depth, so that a plane seen head-on does not fight with itself.
    return p - light * (along + 2.0 * depthStep);
}
