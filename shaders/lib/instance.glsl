// Where a prototype's vertex stands, metres relative to the eye, world axes.
layout(location = 0) in vec3 aPosition;    // metres, or steps of the mesh's grid
layout(location = 3) in vec4 aInstance;   // position relative to the eye, scale
layout(location = 4) in vec2 aCosSinYaw;

uniform vec4 uGrid;                        // origin and step of the grid

vec3 rotateYaw(vec3 p, vec2 cosSin) { return vec3(cosSin.x * p.x - cosSin.y * p.y, cosSin.y * p.x + cosSin.x * p.y, p.z); }
vec3 placed(vec3 p) { return aInstance.xyz + aInstance.w * rotateYaw(p, aCosSinYaw); }
vec3 instancePosition() { return placed(uGrid.xyz + uGrid.w * aPosition); }
/// The unit vector of gpuscene::octahedral(); 0 for what lies outside its square.
vec3 unpackOctahedral(vec2 o) {
    if (o.x > 1.5) return vec3(0.0);
    vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
    float below = max(-n.z, 0.0);
    n.xy += vec2(n.x >= 0.0 ? -below : below, n.y >= 0.0 ? -below : below);
    return normalize(n);
}
