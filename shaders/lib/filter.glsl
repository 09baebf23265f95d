// Comparison results averaged, never depths (Reeves, Salesin, Cook 1987). `uv` in texels of the map, `z` the
// reference. Outside the map the border is the far plane: lit.
float filtered(sampler2DArrayShadow map, float layer, vec2 texels, float size, float z) {
    z = min(z, 1.0);  // D32F compares unclamped references, fixed-point formats do not
#if FILTER < 2
    return texture(map, vec4(texels / size, layer, z));
#else
    // 3×3 with bilinear weights in 2×2 hardware taps: weights 3 - 2s and 1 + 2s per axis, norm 16.
    vec2 base = floor(texels + 0.5);
    vec2 s = texels + 0.5 - base;
    vec2 w0 = 3.0 - 2.0 * s, w1 = 1.0 + 2.0 * s;
    vec2 o0 = (2.0 - s) / w0 - 1.5, o1 = s / w1 + 0.5;
    float sum = w0.x * w0.y * texture(map, vec4((base + vec2(o0.x, o0.y)) / size, layer, z));
    sum += w1.x * w0.y * texture(map, vec4((base + vec2(o1.x, o0.y)) / size, layer, z));
    sum += w0.x * w1.y * texture(map, vec4((base + vec2(o0.x, o1.y)) / size, layer, z));
    sum += w1.x * w1.y * texture(map, vec4((base + vec2(o1.x, o1.y)) / size, layer, z));
    return sum / 16.0;
#endif
}
