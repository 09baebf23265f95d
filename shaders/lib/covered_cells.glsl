// Whether a box lies, at some pixel that its image covers, before the value of the pixel's cell: how far a view looks there. For
// culling in compute shaders, after lib/item_table.glsl; who includes it defines CELL_VALUE(place, level), which is
// FAR_BEFORE_ALL where the view looks at nothing, and SIGN (−1: depths are reversed). Any view will do whose matrix can be
// inverted: a box's image is the convex body of the images of its planes.
#include "lib/clip_bounds.glsl"
#define FAR_BEFORE_ALL (-1e30)
// Who has looked so often takes a box, or an item, for before. Mesa's llvmpipe leaves all loops of a shader, and says nothing, once
// they have gone round 65,535 times together: kMostBoxes · (kMostLooks + 200 for the other loops) is less.
const int kMostLooks = 512, kMostBoxes = 64;
uniform mat4 uRelative;  // inverse of uClip
uniform int uLevels;
uniform float uCellsPerPixel;  // a side of the finest level
uniform vec2 uPixels;  // of the view; a pixel is in the cell in which its centre is, and in both where that is on a border
uniform int uBeyond;   // pixels past its last ones, along both axes, for which a cell's value holds as well
uniform vec2 uSlack;   // of depth, that rasterisation may round: a part of it, and at least so much

// What bounds the image, in (x, y) of the divided clip space.
struct Outline {
    vec3 sides[6];  // the silhouette: inside, dot(side, (x, y, 1)) is not negative
    vec3 faces[3];  // those that look at the view: behind them, SIGN · depth is no less than dot(face, (x, y, 1))
    int sideCount, faceCount;
};

// A plane through a point as it is after the division, and what floats may round of it there: `size` is that of the normal's terms.
vec4 divided(vec3 normal, float size, vec3 through, float deepest, out float rounding) {
    vec4 terms = vec4(vec3(size), size * dot(vec3(1.0), abs(through))), most = vec4(1.0, 1.0, deepest, 1.0);
    rounding = 0.0;
    for (int k = 0; k < 4; ++k) rounding += 5e-7 * most[k] * dot(terms, abs(uRelative[k]));
    return vec4(normal, -dot(normal, through)) * uRelative;
}

Outline outlineOf(Box box, float deepest) {
    Outline outline;
    outline.sideCount = outline.faceCount = 0;
    vec3 edges[3] = vec3[](vec3(box.cosSinYaw, 0.0), vec3(-box.cosSinYaw.y, box.cosSinYaw.x, 0.0), vec3(0.0, 0.0, 1.0));
    float rounding;
    for (int k = 0; k < 3; ++k) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        for (uint edge = 0u; edge < 4u; ++edge) {
            vec3 through = boxCorner(box, ((edge & 1u) << i) | ((edge >> 1) << j));
            vec3 ray = uRelative[2].xyz - through * uRelative[2].w;  // to where all rays come from, a point or a direction
            vec3 normal = cross(edges[k], ray);
            // Part of the silhouette is an edge on one side of which the other three lie.
            bool below = (dot(normal, edges[i]) < 0.0) == ((edge & 1u) == 0u);
            if (below != ((dot(normal, edges[j]) < 0.0) == ((edge & 2u) == 0u)) || outline.sideCount == 6) continue;
            vec3 side = divided(below ? -normal : normal, length(ray), through, deepest, rounding).xyw;
            outline.sides[outline.sideCount++] = side + vec3(0.0, 0.0, rounding);
        }
        for (int end = 0; end < 2; ++end) {
            vec4 face = divided(end == 0 ? edges[k] : -edges[k], 1.0, boxCorner(box, end == 0 ? 0u : 7u), deepest, rounding);
            if (SIGN * face.z <= 0.0 || outline.faceCount == 3) continue;
            outline.faces[outline.faceCount++] = (-face.xyw - vec3(0.0, 0.0, rounding)) / abs(face.z);
        }
    }
    return outline;
}

// Whether it may cover one of the pixels from a to b before a depth; `margin` as in mayBeBefore().
bool mayCover(Outline outline, vec2 a, vec2 b, vec2 margin, float depth) {
    vec3 centre = vec3((a + b + 1.0) / uPixels - 1.0, 1.0);
    vec2 reach = (b - a + 2.0 * margin) / uPixels;
    for (int i = 0; i < outline.sideCount; ++i)
        if (dot(outline.sides[i], centre) + dot(abs(outline.sides[i].xy), reach) < 0.0) return false;
    for (int i = 0; i < outline.faceCount; ++i)
        if (dot(outline.faces[i], centre) - dot(abs(outline.faces[i].xy), reach) > depth) return false;
    return true;
}

bool mayBeBefore(Box box) {
    ClipBounds bounds = clipBounds(box);
    if (bounds.outside) return false;
    if (!bounds.known) return true;
    // Covered is a pixel whose centre is: to an eighth of it, for vertices on the coarsest grid that GL allows, and what floats
    // round of a place.
    vec2 margin = 0.125 + 1e-5 * uPixels;
    vec2 first = max(ceil((bounds.lo.xy * 0.5 + 0.5) * uPixels - margin - 0.5), vec2(0.0));
    vec2 last = min(floor((bounds.hi.xy * 0.5 + 0.5) * uPixels + margin - 0.5), uPixels - 1.0);
    if (any(greaterThan(first, last))) return false;
    vec2 beyond = vec2(uBeyond);
    ivec2 a = ivec2((max(first - beyond, vec2(0.0)) + 0.5) * uCellsPerPixel), b = ivec2((last + 0.5) * uCellsPerPixel);
    float nearest = SIGN > 0.0 ? bounds.lo.z : -bounds.hi.z, slack = max(uSlack.x * abs(nearest), uSlack.y);
    // A quick look at few large cells; most boxes are done with it.
    int level = levelOf(a, b, uLevels, 4);
    float most = FAR_BEFORE_ALL;
    for (int y = a.y >> level; y <= b.y >> level; ++y)
        for (int x = a.x >> level; x <= b.x >> level; ++x) most = max(most, CELL_VALUE(ivec2(x, y), level));
    if (nearest - slack > most) return false;
    level = levelOf(a, b, uLevels, 256);
    Outline outline = outlineOf(box, max(1.0, max(abs(bounds.lo.z), abs(bounds.hi.z))));
    ivec2 origin = a >> level, sides = (b >> level) - origin + 1;
    float size = float(1 << level) / uCellsPerPixel, value;
    vec2 from, to, at;  // pixels of a cell
    bool pixels = false;
    // One loop over cells and, in them, pixels: neighbours in a SIMD unit wait for the one with the most looks, not for the sum of the
    // longest at every turn.
    for (int look = 0, cell = 0; look < kMostLooks; ++look) {
        if (!pixels) {
            if (cell == sides.x * sides.y) return false;
            ivec2 place = origin + ivec2(cell % sides.x, cell / sides.x);
            ++cell;
            value = CELL_VALUE(place, level);
            if (nearest - slack > value) continue;
            at = from = max(ceil(vec2(place) * size - 0.501), first);
            to = min(floor(vec2(place + 1) * size - 0.499) + beyond, last);
            if (any(greaterThan(from, to))) continue;
        }
        if (mayCover(outline, at, pixels ? at : to, margin, value + slack)) {
            // Of a few pixels: a thin box may lie between their centres.
            if (pixels || uBeyond == 0 || any(greaterThan(to - from, vec2(4.0)))) return true;
            pixels = true;
        } else if (pixels) {
            at = at.x < to.x ? vec2(at.x + 1.0, at.y) : vec2(from.x, at.y + 1.0);
            pixels = at.y <= to.y;
        }
    }
    return true;
}

// That of an item's boxes, from the outside in: false only if it is of all its triangles.
bool mayBeBefore(TableItem item) {
    Box box = boxOf(item);
    uint end = tableBoxes[item.firstBox].next;
    int boxes = 0;
    for (uint n = item.firstBox; n < end;) {
        NestedBox nested = tableBoxes[n];
        box.lo = nested.lo;
        box.hi = nested.hi;
        bool before = mayBeBefore(box);
        if (++boxes == kMostBoxes || before && nested.next == n + 1u) return true;
        n = before ? n + 1u : nested.next;
    }
    return false;
}
