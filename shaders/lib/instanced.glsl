// Instances with their maps, and the look-up of a receiver in them (Buntin & Stamminger 2007). Matches
// shadow/instanced/caster_list.h. Needs lib/bias.glsl, and lib/filter.glsl unless MODE is 2; uLight must be declared.
struct Caster {
    vec4 place;    // position relative to the eye, scale
    vec4 yaw;      // cosine, sine; weight of the second of the two maps about its rotation
    vec4 turns;    // the maps' rotation minus the caster's: cosine and sine for the first, cosine and sine for the second
    uvec4 refers;  // to its type, first map, second map
};
struct CasterType {
    vec4 centre;  // of its box, prototype space; w: metres by which shadows of maps of an earlier sun may leave the volume
    vec4 half_;   // half its size; w: κ², κ = horizontal radius / half height
    vec4 more;    // transmittance of its shadow, metres by which the box is larger than the object's
};
layout(std430, binding = 1) restrict readonly buffer Casters { Caster casters[]; };
layout(std430, binding = 2) restrict readonly buffer CasterTypes { CasterType casterTypes[]; };
struct CasterMap {
    vec4 window;  // centre, 1 / half size
    vec4 square;  // in the atlas: x, y, page, side
    vec4 light;   // metres along its light from the object's origin: nearest, 1 / range; cosine and sine of its sun's elevation
};
layout(std430, binding = 3) restrict readonly buffer CasterMaps { CasterMap casterMaps[]; };

vec3 toBoxAxes(Caster c, vec3 p) {
    return vec3(c.yaw.x * p.x + c.yaw.y * p.y, c.yaw.x * p.y - c.yaw.y * p.x, p.z);
}
vec3 fromBoxAxes(Caster c, vec3 p) {
    return vec3(c.yaw.x * p.x - c.yaw.y * p.y, c.yaw.y * p.x + c.yaw.x * p.y, p.z);
}

// Where the ray from q toward the sun is within the box of half size h about the origin: lengths along it, none if the
// second is smaller. Slab test in the box's axes.
vec2 withinBox(vec3 q, vec3 h, vec3 light) {
    vec3 safe = mix(light, vec3(1e-12), lessThan(abs(light), vec3(1e-12)));
    vec3 t1 = (q - h) / safe, t2 = (q + h) / safe;
    vec3 enter = min(t1, t2), leave = max(t1, t2);
    return vec2(max(0.0, max(max(enter.x, enter.y), enter.z)), min(min(leave.x, leave.y), leave.z));
}

// Half size of the box whose shadow volume holds all that the caster's maps darken, in its own scale.
vec3 reachOfBox(Caster c, CasterType type) { return type.half_.xyz + type.centre.w / c.place.w; }

// Along the light, in the caster's own scale, where its shadow volume can meet the box of receivers about `centre`
// (relative to the eye); nowhere if the second is smaller. Conservative.
vec2 reachOf(Caster c, CasterType type, vec3 centre, vec3 reach) {
    vec2 a = abs(c.yaw.xy);  // in the caster's axes the box of receivers lies within one of these half sides
    vec3 grown = reachOfBox(c, type) + vec3(a.x * reach.x + a.y * reach.y, a.y * reach.x + a.x * reach.y, reach.z) / c.place.w;
    return withinBox(toBoxAxes(c, (centre - c.place.xyz) / c.place.w) - type.centre.xyz, grown, toBoxAxes(c, uLight));
}

#ifdef LOOK_UP
layout(binding = 3) uniform MAP_SAMPLER uMap;
uniform vec2 uHeading;  // of the light, unit

// Axes of a map. Its rotation is counted against the light's heading, so that they turn with the sun's azimuth.
struct Basis {
    vec3 u, v, light;
};
Basis basisOf(CasterMap map) {
    return Basis(vec3(uHeading.y, -uHeading.x, 0.0), vec3(map.light.w * uHeading, map.light.z), vec3(map.light.z * uHeading, -map.light.w));
}

bool inVolume(Caster c, CasterType type, vec3 p) {
    vec2 along = withinBox(toBoxAxes(c, (p - c.place.xyz) / c.place.w) - type.centre.xyz, reachOfBox(c, type), toBoxAxes(c, uLight));
    return along.y >= along.x;
}

// Texel coordinates and normalised depth of q, in the caster's own scale but the world's axes, in a map that was
// rendered with another rotation: by `turn`, cosine and sine.
vec3 mapCoordinates(CasterMap m, CasterType type, vec3 q, vec2 turn, bool inside) {
    Basis b = basisOf(m);
    float along = 0.0;
#if SAMPLE_FRAME != 0    // A leaves q where it is
    bool pivot = SAMPLE_FRAME == 2 || (SAMPLE_FRAME == 3 && !inside);
    if (pivot) {  // E: turn about the point of q's ray that is nearest to the caster
        float k = type.half_.w;
        along = (dot(b.light.xy, q.xy) + k * b.light.z * (q.z - type.centre.z)) / (dot(b.light.xy, b.light.xy) + k * b.light.z * b.light.z);
        q -= along * b.light;
    }
    q = vec3(turn.x * q.x - turn.y * q.y, turn.y * q.x + turn.x * q.y, q.z);
#endif
    vec2 uv = (vec2(dot(q, b.u), dot(q, b.v)) - m.window.xy) * m.window.zw * 0.5 + 0.5;
    return vec3(uv * m.square.w, (dot(q, b.light) + along - m.light.x) * m.light.y);
}

// Extent of a map's texel along the map's axes, metres in the caster's own scale.
vec2 texelOf(CasterMap map) { return 2.0 / (map.square.w * map.window.zw); }

// Beside a map's square lies another's: outside of its own is the far plane.
bool outside(vec4 square, vec2 texels) { return any(lessThan(texels, vec2(0.0))) || any(greaterThanEqual(texels, vec2(square.w))); }

#ifdef MARK_TEXELS  // those that a look-up reads, for counters
layout(r8ui, binding = 0) writeonly uniform uimage2DArray uMarks;
void mark(vec4 square, vec2 texels) {
    const float reach = FILTER == 0 ? 0.0 : FILTER == 1 ? 0.5 : 1.5;
    ivec2 lo = max(ivec2(floor(texels - reach)), 0), hi = min(ivec2(floor(texels + reach)), int(square.w) - 1);
    for (int y = lo.y; y <= hi.y; ++y)
        for (int x = lo.x; x <= hi.x; ++x) imageStore(uMarks, ivec3(ivec2(square.xy) + ivec2(x, y), square.z), uvec4(1u));
}
#else
#define mark(square, texels)
#endif

#if MODE == 2
float depthIn(vec4 square, vec2 texels) {
    if (outside(square, texels)) return 1.0;
    mark(square, texels);
    return texelFetch(uMap, ivec3(square.xy + floor(texels), square.z), 0).r;
}
#else
float litIn(vec4 square, vec3 s) {
    if (outside(square, s.xy)) return 1.0;
    mark(square, s.xy);
    return filtered(uMap, MapSquare(square.xyz, square.w, float(textureSize(uMap, 0).x)), s.xy, s.z);
}
#endif

// Share of the sun that caster c lets through to a receiver at p (relative to the eye) that faces the sun.
float lookUp(Caster c, CasterType type, CasterMap m0, CasterMap m1, vec3 p, vec3 normal) {
    float weight = c.yaw.z;
    vec2 texel = max(texelOf(m0), texelOf(m1)) * c.place.w;
    vec2 range = 1.0 / vec2(m0.light.y, m1.light.y);
    float depthStep = c.place.w * max(range.x, range.y) * 1.1920929e-7;
    bool first = weight < 0.5;
    Basis b = basisOf(first ? m0 : m1);
    vec2 slope = abs(vec2(dot(normal, b.u), dot(normal, b.v))) * texel / max(-dot(normal, b.light), 1e-4);
    p = biased(p, normal, b.light, max(texel.x, texel.y), slope, vec2(0.0), depthStep);
    // Precise: fragment and compute shaders give the same bits, whatever a compiler would fuse in one of them.
    precise vec3 q = (p - c.place.xyz) / c.place.w;
    bool inside = all(lessThanEqual(abs(toBoxAxes(c, q) - type.centre.xyz), type.half_.xyz));
    precise vec3 s0 = mapCoordinates(m0, type, q, c.turns.xy, inside), s1 = mapCoordinates(m1, type, q, c.turns.zw, inside);
#if MODE == 0    // the nearer map alone
    vec3 s = first ? s0 : s1;
    return litIn(first ? m0.square : m1.square, s);
#elif MODE == 1  // binary results, blended
    float lit = litIn(m0.square, s0);
    return weight > 0.0 ? mix(lit, litIn(m1.square, s1), weight) : lit;
#else            // depths, interpolated before the comparison; a cleared texel is not a depth
    float d0 = depthIn(m0.square, s0.xy), d1 = depthIn(m1.square, s1.xy);
    float z0 = min(s0.z, 1.0), z1 = min(s1.z, 1.0);
    if (d0 < 1.0 && d1 < 1.0) return mix((d0 - z0) * range.x, (d1 - z1) * range.y, weight) < 0.0 ? 0.0 : 1.0;
    return (first ? d0 < z0 : d1 < z1) ? 0.0 : 1.0;
#endif
}
float lookUp(Caster c, CasterType type, vec3 p, vec3 normal) {
    return lookUp(c, type, casterMaps[c.refers.y], casterMaps[c.refers.z], p, normal);
}
#endif
