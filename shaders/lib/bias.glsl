// Moves a receiver off its own surface. All lengths are metres; Tu and Tv are the world vectors, across the
// light, of one texel's step along the map's two axes, so that the bias scales with the local texel under a
// warp too. KERNEL is the filter's radius r in texels.
uniform float uBiasScale;

// A surface that grazes the light needs an unbounded bias; beyond this many texels it would detach shadows.
const float kMaxBiasTexels = 8.0;

vec3 biased(vec3 p, vec3 normal, vec3 light, vec3 Tu, vec3 Tv, float depthStep) {
    float facing = max(-dot(normal, light), 1e-4);
    float texel = max(length(Tu), length(Tv));
#if BIAS == 0    // constant
    float along = uBiasScale * texel;
#elif BIAS == 1  // slope: the least that suffices for the receiver's plane, (r + 1/2)(|g_u| + |g_v|)
    float along = uBiasScale * (KERNEL + 0.5) * (abs(dot(normal, Tu)) + abs(dot(normal, Tv))) / facing;
    along = min(along, kMaxBiasTexels * uBiasScale * texel);
#else            // normal-offset, weight 1 - cos (MJP)
    p += normal * (uBiasScale * texel * (KERNEL + 0.5) * 2.0 * (1.0 - facing));
    float along = 0.0;
#endif
    // Two steps of the stored depth, so that a plane seen head-on does not fight with itself.
    return p - light * (along + 2.0 * depthStep);
}
