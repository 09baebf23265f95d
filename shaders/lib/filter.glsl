// Comparison results averaged, never depths (Reeves, Salesin, Cook 1987). `texels`: place in the map, `z`: reference,
// `slope`: of the receiver's plane, in depths of the map. Outside the map is the far plane: lit. Needs lib/bias.glsl.
struct MapSquare {
    vec3 place;  // x, y, page of the map's lower left texel
    float side;  // of the map, texels
    float page;  // side of the page, texels
};
// A map that fills its texture has a border of the far plane; in an atlas, its own outermost texels are that.
#ifdef ATLAS
const float kEdge = 0.5;
#else
const float kEdge = -0.5;
#endif

float compared(sampler2DArrayShadow map, MapSquare square, vec2 texels, float z) {
    z = min(z, 1.0);  // D32F compares unclamped references, fixed-point formats do not
    vec2 own = clamp(texels, vec2(kEdge), vec2(square.side - kEdge));
    return texture(map, vec4((square.place.xy + own) / square.page, square.place.z, z));
}
float filtered(sampler2DArrayShadow map, MapSquare square, vec2 texels, float z, Slope slope) {
#if FILTER == 0
    return compared(map, square, texels, z - slopeBias(slope, floor(texels) + 0.5 - texels, 0.0));
#elif FILTER == 1
    return compared(map, square, texels, z - slopeBias(slope, round(texels) - texels, 0.5));
#else
    // 3×3 with bilinear weights in 2×2 hardware taps: weights 3 - 2s and 1 + 2s per axis, norm 16. Interpolated by differences,
    // so that nine equal results give exactly that: a pixel that is all lit may not be a rounding darker than one that asks no map.
    vec2 base = floor(texels + 0.5);
    vec2 s = texels + 0.5 - base;
    vec2 w0 = 3.0 - 2.0 * s, w1 = 1.0 + 2.0 * s;
    vec2 o0 = (2.0 - s) / w0 - 1.5, o1 = s / w1 + 0.5;
    // Each tap has its own reference: the plane goes up on one side of the kernel and down on the other.
    vec2 off0 = base - 1.0 - texels, off1 = base + 1.0 - texels;
    float a = compared(map, square, base + o0, z - slopeBias(slope, off0, 0.5));
    float b = compared(map, square, base + vec2(o1.x, o0.y), z - slopeBias(slope, vec2(off1.x, off0.y), 0.5));
    float c = compared(map, square, base + vec2(o0.x, o1.y), z - slopeBias(slope, vec2(off0.x, off1.y), 0.5));
    float d = compared(map, square, base + o1, z - slopeBias(slope, off1, 0.5));
    vec2 t = 0.25 * w1;
    float lower = a + t.x * (b - a), upper = c + t.x * (d - c);
    return lower + t.y * (upper - lower);
#endif
}
