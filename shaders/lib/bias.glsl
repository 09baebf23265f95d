// What moves a receiver toward the light so that it does not shadow itself. All lengths are metres.
//
// Rounding. Receiver and map hold points that may lie off the receiver's plane by e in any direction; along the light that
// is e / f, f the cosine between light and normal. A float transform rounds seven times, by 2^-24 of a partial sum that is at
// most twice the farthest coordinate, so the map's vertices and the look-up together stay within 2^-19 of it. The depth that
// a receiver is rebuilt from is off by 2^-20 of its distance. Without e a plane that light meets squarely has no bias at all.
// The map's depth rounds, and so does the comparison: two steps.
//
// Slope. The map holds the plane at texel centres. From the look-up's place to a centre at offset o (texels) it moves along
// the light by g·o, so that it needs -g·o; a vertex snaps to the rasteriser's grid, which is an offset of SNAP more. Normals
// have ten bits: turned by δ, a plane changes its slope by at most δ / (f (f - δ)). Within half a texel surfaces have detail
// that is no plane: there the most that the plane needs counts, up to kUsual texels, for more would detach shadows.
uniform float uBiasScale;

const float kGrazing = 0.02;             // cosine below which no shadow is defined (truth::kGrazing): bias grows no more
const float kNormalError = 0.866 / 511.0;  // √3/2 steps of packNormal()
const float kReceiverError = 1.0 / 1048576.0, kMapError = 1.0 / 524288.0;
const float kUsual = 8.0;

float facingOf(vec3 normal, vec3 light) { return max(-dot(normal, light), kGrazing); }

// Slope of a plane per texel along the map's two axes, as depths along the light; `doubt`: by which it may be wrong;
// `texel`: the longer side of the local texel's footprint across the light. In metres, or all three in another unit.
struct Slope {
    vec2 perTexel, doubt;
    float texel;
};
Slope times(Slope s, float unit) { return Slope(s.perTexel * unit, s.doubt * unit, s.texel * unit); }

// `steps`: a texel's extent (metres) along two axes across the light, on which the normal has the components `across`.
Slope slopeOf(vec2 across, vec2 steps, float facing) {
    return Slope(across / facing * steps, kNormalError / (facing * (facing - kNormalError)) * steps, max(steps.x, steps.y));
}

// For texels whose centres lie within `reach` of `offset`, in texels on both axes.
float slopeBias(Slope s, vec2 offset, float reach) {
#if BIAS == 1
    vec2 most = abs(s.perTexel), doubt = s.doubt;
    float needed = dot(most, vec2(reach + SNAP)) - dot(s.perTexel, offset) + dot(doubt, abs(offset) + reach);
    return uBiasScale * max(needed, min(dot(most + doubt, vec2(0.5 + SNAP)), kUsual * s.texel));
#else
    return 0.0;
#endif
}

// All but the slope's. `flatSlope`: per texel, of a plane that faces the light; not zero where a warp bends depth.
// `farthest`: coordinate that the map's transform meets. `depthStep`: of the map.
vec3 biased(vec3 p, vec3 normal, vec3 light, float texel, vec2 flatSlope, float farthest, float depthStep) {
    float along = (kMapError * farthest + kReceiverError * length(p)) / facingOf(normal, light) + 2.0 * depthStep;
#if BIAS == 0    // constant
    along += uBiasScale * texel + (KERNEL + 0.5) * (flatSlope.x + flatSlope.y);
#elif BIAS == 2  // normal-offset, weight 1 - cos (MJP)
    p += normal * (uBiasScale * texel * (KERNEL + 0.5) * 2.0 * (1.0 + dot(normal, light)));
    along += (KERNEL + 0.5) * (flatSlope.x + flatSlope.y);
#endif
    return p - light * along;
}
