// Incremental insertion with edge swaps (Lawson 1977, Software for C1 Surface Interpolation), in biased randomised
// order (Amenta, Choi, Rote 2003, Incremental Constructions con BRIO); walls by swapping what crosses them (Sloan 1993,
// A Fast Algorithm for Generating Constrained Delaunay Triangulations). The turn of three points is exact (Shewchuk
// 1997, Adaptive Precision Floating-Point Arithmetic); the test of circles need not be, as no swap is made that turns a
// triangle over.
#include "scenegen/city/delaunay.h"

#include "base/hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace dapple::scenegen::city {
namespace {

constexpr int kMostDetours = 1000;  // of one wall, nested ones included: keeps the recursion finite

/// Places along a curve through squares of squares, so that neighbours in the order are mostly near each other.
uint32_t mortonCode(const glm::dvec2& unit) {
    const auto spread = [](double x) {
        auto v = uint32_t(x * 65535);
        v = (v | v << 8) & 0x00FF00FF, v = (v | v << 4) & 0x0F0F0F0F, v = (v | v << 2) & 0x33333333;
        return (v | v << 1) & 0x55555555;
    };
    return spread(unit.x) | spread(unit.y) << 1;
}

/// Random halves, each in an order that leads from neighbour to neighbour: half of the points, after a quarter, ...
std::vector<uint32_t> insertionOrder(const std::vector<glm::dvec2>& points, const glm::dvec2& lo, double size) {
    std::vector<std::pair<uint64_t, uint32_t>> keys;
    for (uint32_t i = 0; i < points.size(); ++i) {
        const uint64_t round = uint64_t(std::bit_width(base::mix64(i) >> 32));
        keys.emplace_back(round << 32 | mortonCode((points[i] - lo) / size), i);
    }
    std::sort(keys.begin(), keys.end());
    std::vector<uint32_t> order;
    for (const auto& [key, i] : keys) order.push_back(i);
    return order;
}

double distanceToSegment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 d = b - a;
    return glm::distance(p, a + std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0) * d);
}

}  // namespace

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    const double l = (a.x - c.x) * (b.y - c.y), r = (a.y - c.y) * (b.x - c.x), det = l - r;
    // Equal coordinates make both sides 0, which is exact.
    if (std::abs(det) >= 4e-16 * (std::abs(l) + std::abs(r))) return det;
    // Six products, each as its rounded value and its error, summed without error; the last part has the sum's sign.
    const double factors[6][2] = {{a.x, b.y}, {-a.x, c.y}, {-c.x, b.y}, {-a.y, b.x}, {a.y, c.x}, {c.y, b.x}};
    double parts[12];
    int n = 0;
    const auto add = [&](double q) {
        for (int i = 0; i < n; ++i) {
            const double sum = q + parts[i], rest = sum - q;
            parts[i] = (q - (sum - rest)) + (parts[i] - rest);
            q = sum;
        }
        parts[n++] = q;
    };
    for (const auto& [x, y] : factors) add(std::fma(x, y, -(x * y))), add(x * y);
    while (n > 1 && parts[n - 1] == 0) --n;
    return parts[n - 1];
}

Delaunay::Delaunay(std::vector<glm::dvec2> points) : points_(std::move(points)) {
    const auto n = uint32_t(points_.size());
    glm::dvec2 lo(points_[0]), hi(points_[0]);
    for (const glm::dvec2& p : points_) lo = glm::min(lo, p), hi = glm::max(hi, p);
    const double size = std::max(hi.x - lo.x, hi.y - lo.y);
    const std::vector<uint32_t> order = insertionOrder(points_, lo, size);
    const glm::dvec2 middle = lo + 0.5 * (hi - lo);
    for (const glm::dvec2 p : {glm::dvec2(-20, -10), glm::dvec2(20, -10), glm::dvec2(0, 20)})
        points_.push_back(middle + size * p);
    origin_ = {n, n + 1, n + 2}, twin_.assign(3, kNone), wall_.assign(3, 0);
    leaving_.assign(points_.size(), 0);
    leaving_[n + 1] = 1, leaving_[n + 2] = 2;
    for (const uint32_t i : order) insert(i);
}

void Delaunay::link(uint32_t e, uint32_t twin) {
    twin_[e] = twin;
    if (twin != kNone) twin_[twin] = e;
}

/// First half-edge of the triangle that holds p.
uint32_t Delaunay::locate(const glm::dvec2& p) {
    for (;;) {
        // Begin with any edge: a fixed order might walk in a ring.
        uint32_t e = last_ + uint32_t(random() % 3), left = 3;
        while (left > 0 && turn(at(e), at(next(e)), p) >= 0) e = next(e), --left;
        if (left == 0) return last_;
        last_ = twin_[e] - twin_[e] % 3;
    }
}

void Delaunay::insert(uint32_t point) {
    const uint32_t t = locate(points_[point]), u = uint32_t(origin_.size()), v = u + 3;
    const uint32_t a = origin_[t], b = origin_[t + 1], c = origin_[t + 2], bc = twin_[t + 1], ca = twin_[t + 2];
    for (const uint32_t corner : {b, c, point, c, a, point}) origin_.push_back(corner);
    origin_[t + 2] = point;
    twin_.resize(v + 3), wall_.resize(v + 3, 0);
    link(u, bc), link(v, ca);
    link(t + 1, u + 2), link(u + 1, v + 2), link(v + 1, t + 2);
    leaving_[point] = t + 2, leaving_[a] = t, leaving_[b] = u, leaving_[c] = v;
    std::vector<uint32_t> doubtful{t, u, v};
    while (!doubtful.empty()) {
        const uint32_t e = doubtful.back();
        doubtful.pop_back();
        if (twin_[e] == kNone) continue;
        // A point on an edge made a triangle without area: that edge goes.
        if (turn(at(e), at(next(e)), at(prev(e))) != 0 && !(isIllegal(e) && isConvex(e))) continue;
        doubtful.push_back(e), doubtful.push_back(prev(twin_[e]));
        flip(e);
    }
}

/// Whether the two triangles at an edge make a strictly convex quadrilateral.
bool Delaunay::isConvex(uint32_t e) const {
    const glm::dvec2 &p = at(prev(e)), &d = at(prev(twin_[e]));
    return turn(p, at(e), d) > 0 && turn(p, d, at(next(e))) > 0;
}

/// Whether the twin's third corner lies in the circle about this triangle, by more than the test rounds.
bool Delaunay::isIllegal(uint32_t e) const {
    const glm::dvec2 d = at(prev(twin_[e])), a = at(e) - d, b = at(next(e)) - d, c = at(prev(e)) - d;
    const double a2 = glm::dot(a, a), b2 = glm::dot(b, b), c2 = glm::dot(c, c);
    const double bc = b.x * c.y, cb = b.y * c.x, ca = c.x * a.y, ac = c.y * a.x, ab = a.x * b.y, ba = a.y * b.x;
    const double size = a2 * (std::abs(bc) + std::abs(cb)) + b2 * (std::abs(ca) + std::abs(ac)) +
                        c2 * (std::abs(ab) + std::abs(ba));
    return a2 * (bc - cb) + b2 * (ca - ac) + c2 * (ab - ba) > 4e-15 * size;
}

/// Swaps the diagonal of the quadrilateral at e. In its triangle e then leads from its origin to the opposite corner.
void Delaunay::flip(uint32_t e0) {
    const uint32_t e1 = next(e0), e2 = prev(e0), t0 = twin_[e0], t1 = next(t0), t2 = prev(t0);
    const uint32_t p = origin_[e2], d = origin_[t2];
    const uint32_t fromTwin = twin_[t1], fromHere = twin_[e1];
    wall_[e0] = wall_[t1], wall_[t0] = wall_[e1], wall_[e1] = wall_[t1] = 0;
    origin_[e1] = d, origin_[t1] = p;
    link(e0, fromTwin), link(t0, fromHere), link(e1, t1);
    leaving_[origin_[e0]] = e0, leaving_[origin_[t0]] = t0, leaving_[p] = e2, leaving_[d] = t2;
}

uint32_t Delaunay::edgeBetween(uint32_t a, uint32_t b) const {
    const uint32_t first = leaving_[a];
    for (uint32_t e = first;;) {
        if (origin_[next(e)] == b) return e;
        e = twin_[prev(e)];
        if (e == kNone || e == first) return kNone;
    }
}

void Delaunay::mark(uint32_t e, uint8_t odd) { wall_[e] = wall_[twin_[e]] = uint8_t(2 | ((wall_[e] ^ odd) & 1)); }

bool Delaunay::addWall(uint32_t a, uint32_t b, double tolerance, double snap) {
    tolerance_ = tolerance, snap_ = snap;
    return add(a, b, 1, 0);
}

bool Delaunay::add(uint32_t a, uint32_t b, uint8_t odd, int depth) {
    std::vector<uint32_t> crossed;
    while (a != b) {
        crossed.clear();
        auto [to, isStraight] = advance(a, b, crossed);
        if (isStraight && !crossed.empty() && wall_[crossed.back()]) {
            to = detour(a, b, crossed.back(), depth + 1);
            isStraight = false;
        }
        if (isStraight) {
            flipAway(a, to, crossed);
            mark(edgeBetween(a, to), odd);
        } else if (to == kNone || ++depth > kMostDetours || (to != a && !add(a, to, odd, depth))) {
            return false;
        }
        a = to;
    }
    return true;
}

/// Whether the point is so near to the segment, between its ends, that it counts as on it.
bool Delaunay::isNear(uint32_t point, uint32_t a, uint32_t b) const {
    if (snap_ == 0 || point == a || point == b) return false;
    const glm::dvec2 d = points_[b] - points_[a], p = points_[point] - points_[a];
    const double along = glm::dot(p, d), length2 = glm::dot(d, d);
    if (!(along > 0 && along < length2)) return false;
    const double across = d.x * p.y - d.y * p.x;
    return across * across <= snap_ * snap_ * length2;
}

/// First point on the way from a to b, and the edges crossed before it, each from right to left; the last one is a wall
/// if the way ends there. The step is not straight to a point that is only near the way.
Delaunay::Step Delaunay::advance(uint32_t a, uint32_t b, std::vector<uint32_t>& crossed) const {
    const glm::dvec2 &from = points_[a], &to = points_[b];
    uint32_t e = leaving_[a];
    for (;; e = twin_[prev(e)]) {
        const uint32_t x = origin_[next(e)];
        if (x == b) {
            for (const uint32_t v : {origin_[prev(e)], origin_[prev(twin_[e])]})
                if (isNear(v, a, b)) return {v, false};
            return {b, true};
        }
        const double side = turn(from, to, points_[x]);
        if (side == 0 && glm::dot(points_[x] - from, to - from) > 0) return {x, true};
        if (side < 0 && turn(from, to, at(prev(e))) > 0) break;
    }
    for (e = next(e);;) {
        for (const uint32_t v : {origin_[e], origin_[next(e)]})
            if (isNear(v, a, b)) return {v, false};
        crossed.push_back(e);
        if (wall_[e]) return {kNone, true};
        const uint32_t t = twin_[e], d = origin_[prev(t)];
        const double side = turn(from, to, points_[d]);
        if (d == b || side == 0) return {d, true};
        // The twin runs from left to right: its next edge ends at d, where the one before it begins.
        e = side > 0 ? next(t) : prev(t);
    }
}

/// A wall is in the way. If an end of either lies within the tolerance of the other, one of them makes a detour over
/// that end. Returns where the way from a leads first (a itself if the wall gave way), or kNone.
uint32_t Delaunay::detour(uint32_t a, uint32_t b, uint32_t wall, int depth) {
    if (depth > kMostDetours) return kNone;
    const uint32_t x = origin_[wall], y = origin_[next(wall)];
    for (const uint32_t end : {x, y})
        if (distanceToSegment(points_[end], points_[a], points_[b]) <= tolerance_) return end;
    for (const uint32_t end : {a, b})
        if (distanceToSegment(points_[end], points_[x], points_[y]) <= tolerance_) {
            const uint8_t odd = wall_[wall] & 1;
            wall_[wall] = wall_[twin_[wall]] = 0;
            return add(x, end, odd, depth) && add(end, y, odd, depth) ? a : kNone;
        }
    return kNone;
}

/// Swaps the crossed edges until none crosses the way from a to b. One swap in eight that leaves an edge in the way is
/// put off, at random: swaps that undo each other cannot go on for ever.
void Delaunay::flipAway(uint32_t a, uint32_t b, std::vector<uint32_t>& crossed) {
    while (!crossed.empty()) {
        size_t kept = 0;
        for (size_t i = 0; i < crossed.size(); ++i) {
            const uint32_t e = crossed[i];
            const uint32_t p = origin_[prev(e)], d = origin_[prev(twin_[e])];
            const double sideP = turn(points_[a], points_[b], points_[p]);
            const double sideD = turn(points_[a], points_[b], points_[d]);
            const bool stays = (sideP < 0 && sideD > 0) || (sideP > 0 && sideD < 0);
            if (!isConvex(e) || (stays && random() % 8 == 0)) {
                crossed[kept++] = e;
                continue;
            }
            const uint32_t moved = next(twin_[e]), diagonal = next(e);
            flip(e);
            if (i + 1 < crossed.size() && crossed[i + 1] == moved) crossed[i + 1] = e;
            if (stays) crossed[kept++] = sideP < 0 ? twin_[diagonal] : diagonal;
        }
        crossed.resize(kept);
    }
}

void Delaunay::refine() {
    std::vector<uint32_t> doubtful(origin_.size());
    std::iota(doubtful.begin(), doubtful.end(), 0);
    while (!doubtful.empty()) {
        const uint32_t e = doubtful.back();
        doubtful.pop_back();
        if (twin_[e] == kNone || wall_[e] || !isIllegal(e) || !isConvex(e)) continue;
        const uint32_t t = twin_[e];
        flip(e);
        for (const uint32_t side : {e, prev(e), t, prev(t)}) doubtful.push_back(side);
    }
}

std::vector<bool> Delaunay::isInside() const {
    std::vector<bool> seen(origin_.size() / 3), inside(seen.size());
    std::vector<uint32_t> front{leaving_.back() / 3};
    seen[front[0]] = true;
    while (!front.empty()) {
        const uint32_t t = front.back();
        front.pop_back();
        for (uint32_t e = 3 * t; e < 3 * t + 3; ++e) {
            if (twin_[e] == kNone || seen[twin_[e] / 3]) continue;
            seen[twin_[e] / 3] = true;
            inside[twin_[e] / 3] = inside[t] != bool(wall_[e] & 1);
            front.push_back(twin_[e] / 3);
        }
    }
    return inside;
}

std::vector<uint32_t> Delaunay::insideOddWalls() const {
    const std::vector<bool> inside = isInside();
    std::vector<uint32_t> corners;
    for (uint32_t e = 0; e < origin_.size(); ++e)
        if (inside[e / 3]) corners.push_back(origin_[e]);
    return corners;
}

std::vector<std::vector<uint32_t>> Delaunay::outlines() const {
    const std::vector<bool> inside = isInside();
    std::vector<bool> done(origin_.size());
    std::vector<std::vector<uint32_t>> rings;
    for (uint32_t first = 0; first < origin_.size(); ++first) {
        if (done[first] || !inside[first / 3] || inside[twin_[first] / 3]) continue;
        rings.emplace_back();
        for (uint32_t e = first; !done[e];) {
            done[e] = true;
            rings.back().push_back(origin_[e]);
            // Around the edge's end, through triangles inside, to the next edge.
            for (e = next(e); inside[twin_[e] / 3];) e = next(twin_[e]);
        }
    }
    return rings;
}

}  // namespace dapple::scenegen::city
