// The G-buffer's one colour target, RGBA32UI: colour and specular strength (8 bits each, colour as its square
// root), shading normal, geometric normal (10 bits a component), unused. Integer texels are stored as they
// are: writing several converted targets costs a software rasteriser more than the whole vertex stage.
uint packNormal(vec3 n) {
    ivec3 i = ivec3(round(n * 511.0)) & 1023;
    return uint(i.x | i.y << 10 | i.z << 20);
}
vec3 unpackNormal(uint bits) {
    ivec3 i = ivec3(int(bits) << 22, int(bits) << 12, int(bits) << 2) >> 22;
    return normalize(vec3(i));
}
