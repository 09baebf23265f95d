// Where a box lies in a view, for culling in compute shaders. Needs lib/item_table.glsl.
uniform mat4 uClip;     // of the view, from metres relative to the eye
uniform float uLeastW;  // clip w up to which nothing is known of a box

struct ClipBounds {
    vec3 lo, hi;   // after the division by w
    bool known;    // that of all corners
    bool outside;  // all corners are beyond one side of the view, whatever their w
};

ClipBounds clipBounds(Box box) {
    ClipBounds bounds = ClipBounds(vec3(1e30), vec3(-1e30), true, false);
    bvec4 beyond = bvec4(true);
    for (uint corner = 0u; corner < 8u; ++corner) {
        vec4 q = uClip * vec4(boxCorner(box, corner), 1.0);
        bounds.known = bounds.known && q.w > uLeastW;
        bvec4 here = lessThan(vec4(q.x, -q.x, q.y, -q.y) + q.w, vec4(-1e-4 * abs(q.w)));
        beyond = bvec4(beyond.x && here.x, beyond.y && here.y, beyond.z && here.z, beyond.w && here.w);
        vec3 ndc = q.xyz / q.w;
        bounds.lo = min(bounds.lo, ndc);
        bounds.hi = max(bounds.hi, ndc);
    }
    bounds.outside = any(beyond);
    return bounds;
}

// The finest level of a pyramid at which the cells from a to b, of level 0, are no more than `cells`.
int levelOf(ivec2 a, ivec2 b, int levels, int cells) {
    int level = 0;
    for (; level < levels - 1; ++level) {
        ivec2 sides = (b >> level) - (a >> level) + 1;
        if (sides.x * sides.y <= cells) break;
    }
    return level;
}
