// Instances with their maps, and the look-up of a receiver in them (Buntin & Stamminger 2007). Matches
// shadow/instanced/caster_list.h. Needs lib/bias.glsl, and lib/filter.glsl unless MODE is 2; uLight must be declared.
struct CasterMap {
    vec4 texels;  // coordinates in it of a point in the caster's own scale: texels per metre, texels at the caster's origin
    vec4 square;  // in the atlas: x, y, page, side
    vec4 light;   // depth of the caster's origin along it, 1 / depth of the map, in metres of the caster; cosine and sine of its sun's elevation
    vec4 turn;    // its rotation minus the caster's, cosine and sine; for E: 1 / (cos² + κ² sin²) of the elevation; depth of the map, metres
};
struct Caster {
    vec4 place;    // position relative to the eye, 1 / scale
    vec4 box;      // centre, in its own scale and axes; transmittance of the shadow
    vec4 reach;    // half size of the box whose shadow volume holds all that its maps darken; weight of the second map
    vec4 against;  // 1 / direction of the light in its axes; κ², κ = horizontal radius / half height
    vec4 turn;     // its yaw, cosine and sine; texel of the coarser map across the light, metres
    CasterMap first, second;  // those about its rotation
    uvec4 refers;  // to the two in the atlas; bits of floats, metres in its own scale: by which its box is larger than it, and `reach` than its box
};
layout(std430, binding = 1) restrict readonly buffer Casters { Caster casters[]; };

vec3 toBoxAxes(Caster c, vec3 p) {
    return vec3(c.turn.x * p.x + c.turn.y * p.y, c.turn.x * p.y - c.turn.y * p.x, p.z);
}
vec3 fromBoxAxes(Caster c, vec3 p) {
    return vec3(c.turn.x * p.x - c.turn.y * p.y, c.turn.y * p.x + c.turn.x * p.y, p.z);
}

// Where the ray from q, relative to the box's centre, toward the sun is within the box: lengths along it, none if the second is
// smaller. Slab test in the box's axes.
vec2 withinBox(vec3 q, vec3 reach, vec3 against) {
    vec3 t1 = (q - reach) * against, t2 = (q + reach) * against;
    vec3 enter = min(t1, t2), leave = max(t1, t2);
    return vec2(max(0.0, max(max(enter.x, enter.y), enter.z)), min(min(leave.x, leave.y), leave.z));
}

// Along the light, in the caster's own scale, where its shadow volume can meet the box of receivers about `centre`
// (relative to the eye); nowhere if the second is smaller. Conservative.
vec2 reachOf(Caster c, vec3 centre, vec3 reach) {
    vec2 a = abs(c.turn.xy);  // in the caster's axes the box of receivers lies within one of these half sides
    vec3 grown = c.reach.xyz + vec3(a.x * reach.x + a.y * reach.y, a.y * reach.x + a.x * reach.y, reach.z) * c.place.w;
    return withinBox(toBoxAxes(c, (centre - c.place.xyz) * c.place.w) - c.box.xyz, grown, c.against.xyz);
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

bool inVolume(Caster c, vec3 p) {
    vec2 along = withinBox(toBoxAxes(c, (p - c.place.xyz) * c.place.w) - c.box.xyz, c.reach.xyz, c.against.xyz);
    return along.y >= along.x;
}

// Texel coordinates and normalised depth of q, in the caster's own scale but the world's axes, in its map m.
vec3 mapCoordinates(CasterMap m, Caster c, vec3 q, bool inside) {
    Basis b = basisOf(m);
    float along = 0.0;
#if SAMPLE_FRAME != 0    // A leaves q where it is
    bool pivot = SAMPLE_FRAME == 2 || (SAMPLE_FRAME == 3 && !inside);
    if (pivot) {  // E: turn about the point of q's ray that is nearest to the caster
        along = (dot(b.light.xy, q.xy) + c.against.w * b.light.z * (q.z - c.box.z)) * m.turn.z;
        q -= along * b.light;
    }
    q = vec3(m.turn.x * q.x - m.turn.y * q.y, m.turn.y * q.x + m.turn.x * q.y, q.z);
#endif
    return vec3(vec2(dot(q, b.u), dot(q, b.v)) * m.texels.xy + m.texels.zw, (dot(q, b.light) + along) * m.light.y + m.light.x);
}

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

// The receiver's plane in depths of map m, whose object has turned against the caster.
Slope slopeIn(CasterMap m, Caster c, vec3 normal) {
    Basis b = basisOf(m);
    vec3 n = vec3(m.turn.x * normal.x - m.turn.y * normal.y, m.turn.y * normal.x + m.turn.x * normal.y, normal.z);
    return times(slopeOf(vec2(dot(n, b.u), dot(n, b.v)), 1.0 / (c.place.w * m.texels.xy), facingOf(n, b.light)), 1.0 / m.turn.w);
}

#if MODE == 2
float depthIn(vec4 square, vec2 texels) {
    if (outside(square, texels)) return 1.0;
    mark(square, texels);
    return texelFetch(uMap, ivec3(square.xy + floor(texels), square.z), 0).r;
}
float reference(CasterMap m, Caster c, vec3 s, vec3 normal) {
    return min(s.z - slopeBias(slopeIn(m, c, normal), floor(s.xy) + 0.5 - s.xy, 0.0), 1.0);
}
#else
float litIn(CasterMap m, Caster c, vec3 s, vec3 normal) {
    if (outside(m.square, s.xy)) return 1.0;
    mark(m.square, s.xy);
    return filtered(uMap, MapSquare(m.square.xyz, m.square.w, float(textureSize(uMap, 0).x)), s.xy, s.z, slopeIn(m, c, normal));
}
#endif

// Share of the sun that caster c lets through to a receiver at p (relative to the eye) that faces the sun.
float lookUp(Caster c, vec3 p, vec3 normal) {
    float weight = c.reach.w;
    bool first = weight < 0.5;
    vec3 light;  // of the nearer map
    if (first) light = basisOf(c.first).light;
    else light = basisOf(c.second).light;
    float depthStep = max(c.first.turn.w, c.second.turn.w) * 1.1920929e-7;
    float farthest = length(p) + length(c.place.xyz) + (length(c.box.xyz) + length(c.reach.xyz)) / c.place.w;
    p = biased(p, normal, light, max(c.turn.z, c.turn.w), vec2(0.0), farthest, depthStep);
    // Precise: fragment and compute shaders give the same bits, whatever a compiler would fuse in one of them.
    precise vec3 q = (p - c.place.xyz) * c.place.w;
    bool inside = all(lessThanEqual(abs(toBoxAxes(c, q) - c.box.xyz), c.reach.xyz - uintBitsToFloat(c.refers.w)));
    precise vec3 s0 = mapCoordinates(c.first, c, q, inside), s1 = mapCoordinates(c.second, c, q, inside);
#if MODE == 0    // the nearer map alone
    if (first) return litIn(c.first, c, s0, normal);
    return litIn(c.second, c, s1, normal);
#elif MODE == 1  // binary results, blended
    float lit = litIn(c.first, c, s0, normal);
    return weight > 0.0 ? mix(lit, litIn(c.second, c, s1, normal), weight) : lit;
#else            // depths, interpolated before the comparison; a cleared texel is not a depth
    float d0 = depthIn(c.first.square, s0.xy), d1 = depthIn(c.second.square, s1.xy);
    precise float z0 = reference(c.first, c, s0, normal), z1 = reference(c.second, c, s1, normal);
    if (d0 < 1.0 && d1 < 1.0) return mix((d0 - z0) * c.first.turn.w, (d1 - z1) * c.second.turn.w, weight) < 0.0 ? 0.0 : 1.0;
    return (first ? d0 < z0 : d1 < z1) ? 0.0 : 1.0;
#endif
}
#endif
