// Whether a box lies, in some cell that its image covers, before the cell's value: how far a view looks there. For culling
// in compute shaders, after lib/item_table.glsl; who includes it defines CELL_VALUE(place, level), which is FAR_BEFORE_ALL
// where the view looks at nothing, and SIGN (−1: depths are reversed).
#include "lib/clip_bounds.glsl"
#define FAR_BEFORE_ALL (-1e30)
uniform int uLevels;
uniform float uCells;  // a side of the finest level
uniform vec2 uMargin;  // cells that rasterisation and rounding may reach beyond the box
uniform vec2 uSlack;   // the same of its depth: a part of it, and at least so much

// Three axes that may separate the box's image from a square: the normals of its edges, or of their mean where a warp turns
// them. xy: the axis; zw: where the image lies along it. In cells.
vec4[3] separators(vec2 corners[8]) {
    vec4 axes[3];
    for (int k = 0; k < 3; ++k) {
        vec2 edge = corners[1 << k] - corners[0] + corners[7] - corners[7 ^ (1 << k)];
        axes[k] = vec4(-edge.y, edge.x, 1e30, -1e30);
        for (int corner = 0; corner < 8; ++corner) {
            float along = dot(axes[k].xy, corners[corner]);
            axes[k].zw = vec2(min(axes[k].z, along), max(axes[k].w, along));
        }
    }
    return axes;
}
bool covers(vec4 axes[3], vec2 centre, float halfSide) {
    for (int k = 0; k < 3; ++k) {
        float along = dot(axes[k].xy, centre), reach = halfSide * (abs(axes[k].x) + abs(axes[k].y));
        if (along + reach < axes[k].z || along - reach > axes[k].w) return false;
    }
    return true;
}

#ifndef WARPED
// The box seen from the sun: a parallelepiped, as the view is not WARPED (a perspective is). Its centre and half its edges, in cells and depth.
struct Prism {
    vec3 centre, edge[3];
};
Prism prismOf(Box box) {
    vec3 toCells = vec3(0.5 * uCells, 0.5 * uCells, 1.0), corner = (uClip * vec4(boxCorner(box, 0u), 1.0)).xyz;
    Prism prism;
    prism.centre = corner;
    for (int k = 0; k < 3; ++k) {
        prism.edge[k] = 0.5 * ((uClip * vec4(boxCorner(box, 1u << k), 1.0)).xyz - corner);
        prism.centre += prism.edge[k];
        prism.edge[k] *= toCells;
    }
    prism.centre = (prism.centre + vec3(1.0, 1.0, 0.0)) * toCells;
    return prism;
}
// Depth before which the sun's rays through a square cannot enter it: behind its three faces that look at the sun.
float beginning(Prism prism, vec2 centre, float halfSide) {
    float depth = -1e30;
    for (int k = 0; k < 3; ++k) {
        vec3 normal = cross(prism.edge[(k + 1) % 3], prism.edge[(k + 2) % 3]);
        if (normal.z == 0.0) continue;
        vec2 slope = normal.xy / normal.z;
        if (abs(slope.x) + abs(slope.y) > 0.04) continue;  // nearly edge on: over the window, rounding would exceed the slack
        depth = max(depth, prism.centre.z - dot(slope, centre - prism.centre.xy) - abs(dot(normal, prism.edge[k]) / normal.z) - halfSide * (abs(slope.x) + abs(slope.y)));
    }
    return depth;
}
#endif

bool mayBeBefore(Box box) {
    ClipBounds bounds = clipBounds(box);
    if (bounds.outside) return false;
    if (!bounds.known) return true;
    vec2 first = floor((bounds.lo.xy * 0.5 + 0.5) * uCells - uMargin), last = floor((bounds.hi.xy * 0.5 + 0.5) * uCells + uMargin);
    if (any(lessThan(last, vec2(0.0))) || any(greaterThanEqual(first, vec2(uCells)))) return false;
    ivec2 a = ivec2(max(first, vec2(0.0))), b = ivec2(min(last, vec2(uCells - 1.0)));
    float nearest = SIGN > 0.0 ? bounds.lo.z : -bounds.hi.z, slack = max(uSlack.x * abs(nearest), uSlack.y);
    // A quick look at few large cells; most boxes are done with it.
    int level = levelOf(a, b, uLevels, 2);
    float most = FAR_BEFORE_ALL;
    for (int y = a.y >> level; y <= b.y >> level; ++y)
        for (int x = a.x >> level; x <= b.x >> level; ++x) most = max(most, CELL_VALUE(ivec2(x, y), level));
    if (nearest - slack > most) return false;
    level = levelOf(a, b, uLevels, 16);
    vec2 corners[8];
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec4 q = uClip * vec4(boxCorner(box, corner), 1.0);
        corners[corner] = (q.xy / q.w * 0.5 + 0.5) * uCells;
    }
    vec4 axes[3] = separators(corners);
#ifndef WARPED
    Prism prism = prismOf(box);
#endif
    for (int y = a.y >> level; y <= b.y >> level; ++y)
        for (int x = a.x >> level; x <= b.x >> level; ++x) {
            float value = CELL_VALUE(ivec2(x, y), level);
            if (nearest - slack > value) continue;
            float side = float(1 << level), reach = 0.5 * side + max(uMargin.x, uMargin.y);
            vec2 centre = (vec2(x, y) + 0.5) * side;
            if (!covers(axes, centre, reach)) continue;
#ifndef WARPED
            if (beginning(prism, centre, reach) - slack > value) continue;
#endif
            return true;
        }
    return false;
}
