// Comparison results averaged, never depths (Reeves, Salesin, Cook 1987). `uv` in texels of the map, `z` the
// reference. Outside the map is the far plane: lit.
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
    vec2 own = clamp(texels, vec2(kEdge), vec2(square.side - kEdge));
    return texture(map, vec4((square.place.xy + own) / square.page, square.place.z, z));
}
float filtered(sampler2DArrayShadow map, MapSquare square, vec2 texels, float z) {
    z = min(z, 1.0);  // D32F compares unclamped references, fixed-point formats do not
#if FILTER < 2
    return compared(map, square, texels, z);
#else
    // 3×3 with bilinear weights in 2×2 hardware taps: weights 3 - 2s and 1 + 2s per axis, norm 16. Interpolated by differences,
    // so that nine equal results give exactly that: a pixel that is all lit may not be a rounding darker than one that asks no map.
    vec2 base = floor(texels + 0.5);
    vec2 s = texels + 0.5 - base;
    vec2 w0 = 3.0 - 2.0 * s, w1 = 1.0 + 2.0 * s;
    vec2 o0 = (2.0 - s) / w0 - 1.5, o1 = s / w1 + 0.5;
    float a = compared(map, square, base + vec2(o0.x, o0.y), z), b = compared(map, square, base + vec2(o1.x, o0.y), z);
    float c = compared(map, square, base + vec2(o0.x, o1.y), z), d = compared(map, square, base + vec2(o1.x, o1.y), z);
    vec2 t = 0.25 * w1;
    float lower = a + t.x * (b - a), upper = c + t.x * (d - c);
    return lower + t.y * (upper - lower);
#endif
}
