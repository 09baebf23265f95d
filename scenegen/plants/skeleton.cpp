#include "scenegen/plants/skeleton.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dapple::scenegen {
namespace det = base::det;
namespace {

/// Keys of the random streams of one stem.
enum Purpose : uint64_t { kCurve = 1, kSplit, kChildren };

/// A stem's tip keeps this share of its radius: a cone's apex would make degenerate triangles.
constexpr double kTipRadius = 0.15;
constexpr double kMinRadius = 0.0012;

glm::dmat3 rotateX(const glm::dmat3& f, double degrees) {
    const auto [s, c] = det::sinCos(degrees * det::kDegree);
    return {f[0], f[1] * c + f[2] * s, f[2] * c - f[1] * s};
}

glm::dmat3 rotateZ(const glm::dmat3& f, double degrees) {
    const auto [s, c] = det::sinCos(degrees * det::kDegree);
    return {f[0] * c + f[1] * s, f[1] * c - f[0] * s, f[2]};
}

/// Turns all columns about the world's vertical.
glm::dmat3 turnAboutVertical(const glm::dmat3& f, double degrees) {
    const auto [s, c] = det::sinCos(degrees * det::kDegree);
    glm::dmat3 r;
    for (int i = 0; i < 3; ++i) r[i] = {c * f[i].x - s * f[i].y, s * f[i].x + c * f[i].y, f[i].z};
    return r;
}

/// Frame with the given z column whose x column is nearest to `x`.
glm::dmat3 frameAlong(const glm::dvec3& z, const glm::dvec3& x) {
    const glm::dvec3 across = glm::normalize(x - z * glm::dot(x, z));
    return {across, glm::cross(z, across), z};
}

double declination(const glm::dmat3& f) { return det::acos(f[2].z) / det::kDegree; }

/// Section 4.4: radius at the share z of the length, for all three ranges of taper.
double taperedRadius(double taper, double radius, double length, double z) {
    const double unit = taper < 1 ? taper : taper < 2 ? 2 - taper : 0;
    const double cone = radius * (1 - unit * z);
    if (taper < 1) return cone;
    const double toEnd = (1 - z) * length;
    const double depth = taper < 2 || toEnd < cone ? 1 : taper - 2;
    const double local = taper < 2 ? toEnd : std::abs(toEnd - 2 * cone * std::floor(toEnd / (2 * cone) + 0.5));
    if (taper < 2 && local >= cone) return cone;
    return (1 - depth) * cone + depth * std::sqrt(std::max(0.0, cone * cone - (local - cone) * (local - cone)));
}

/// Frames from the mean of the neighbouring directions, parallel-transported, so that the cage does not twist.
void orientRings(std::vector<Ring>& r) {
    const size_t last = r.size() - 1;
    glm::dvec3 across = r[0].frame[0];
    for (size_t i = 0; i <= last; ++i) {
        const glm::dvec3 along = glm::normalize(r[std::min(i + 1, last)].centre - r[i == 0 ? 0 : i - 1].centre);
        if (std::abs(glm::dot(across, along)) > 0.99) across = r[i].frame[1];
        r[i].frame = frameAlong(along, across);
        across = r[i].frame[0];
    }
}

struct Fork {
    int segment;  ///< the clone begins at the end of this many segments
    glm::dmat3 frame;
    double correction;  ///< degrees per segment that bend it back
};

class Grower {
public:
    Grower(const Species& species, uint64_t seed) : species_(species), seed_(seed), splitError_(species.levels.size(), 0.0) {}

    Skeleton grow() {
        base::Random random(seed_, 0, kChildren);
        const double scale = species_.scale + species_.scaleV * random.next(-1, 1);
        const LevelParameters& trunk = species_.levels[0];
        Stem stem;
        stem.length = scale * (trunk.length + trunk.lengthV * random.next(-1, 1));
        stem.radius = stem.length * species_.ratio;
        stem.crown = species_.baseSize * stem.length;
        stem.bury = 0.02 * stem.length;
        growStem(stem, rotateZ(glm::dmat3(1), 360 * random.next()), glm::dvec3(0), 0, 0);
        return std::move(skeleton_);
    }

private:
    double surfaceRadius(const Stem& stem, double offset) const {
        const double z = std::clamp(offset / stem.length, 0.0, 1.0);
        double r = taperedRadius(species_.levels[size_t(stem.level)].taper, stem.radius, stem.length, z);
        r = std::max({r, kTipRadius * stem.radius, kMinRadius});
        if (stem.level == 0) r *= 1 + species_.flare * (det::pow(100, std::max(0.0, 1 - 8 * z)) - 1) / 100;
        return r;
    }

    /// `stem` has everything but rings. `frame` and `position` hold where `segment` of its segments end.
    void growStem(Stem stem, glm::dmat3 frame, glm::dvec3 position, int segment, double correction) {
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        const auto id = int(skeleton_.stems.size());
        stem.faceted = p.refine == 0;
        base::Random curve(seed_, uint64_t(id), kCurve), split(seed_, uint64_t(id), kSplit);
        const double step = stem.length / p.curveRes;
        std::vector<Fork> forks;
        const auto addRing = [&](const glm::dvec3& centre, double offset) {
            stem.rings.push_back({centre, frame, surfaceRadius(stem, offset), offset});
        };
        addRing(position, segment * step);
        for (int s = segment; s < p.curveRes; ++s) {
            double bend = p.curve / p.curveRes;
            if (p.curveBack != 0) bend = (s < (p.curveRes + 1) / 2 ? p.curve : p.curveBack) / (0.5 * p.curveRes);
            frame = rotateX(frame, bend - correction + p.curveV / p.curveRes * curve.next(-1, 1));
            if (p.curveV != 0) frame = rotateZ(frame, 30 * curve.next(-1, 1));
            if (stem.level >= 2) frame = attract(frame, p.curveRes);
            // The flare lies within the first eighth of the trunk: two rings more carry it.
            if (stem.level == 0 && s == 0)
                for (const double share : {0.15, 0.5}) addRing(position + frame[2] * (share * step), share * step);
            position += frame[2] * step;
            addRing(position, (s + 1) * step);
            if (s + 1 < p.curveRes) fork(stem, p, s, frame, correction, split, forks);
        }
        orientRings(stem.rings);
        skeleton_.stems.push_back(stem);

        for (const Fork& f : forks) {
            Stem clone = stem;
            clone.rings.clear();
            clone.parent = id;
            clone.start = clone.parentOffset = f.segment * step;
            clone.bury = 0;
            growStem(clone, f.frame, stem.at(clone.start).centre, f.segment, f.correction);
        }
        if (size_t(stem.level) + 1 < species_.levels.size()) growChildren(stem, id);
    }

    /// Section 4.8: vertical attraction turns the direction towards the sky.
    glm::dmat3 attract(const glm::dmat3& f, int segments) const {
        const glm::dvec3 axis = glm::cross(f[2], glm::dvec3(0, 0, 1));
        const double sine = glm::length(axis);
        if (species_.attractionUp == 0 || sine < 1e-6) return f;
        const double angle = std::clamp(species_.attractionUp * declination(f) * sine / segments, -declination(f), declination(f));
        const auto [s, c] = det::sinCos(angle * det::kDegree);
        return frameAlong(f[2] * c + glm::cross(axis / sine, f[2]) * s, f[0]);
    }

    /// Section 4.2: the stem splits at the end of segment s; rounding errors are carried on.
    void fork(const Stem& stem, const LevelParameters& p, int s, glm::dmat3& frame, double& correction, base::Random& random,
              std::vector<Fork>& forks) {
        int clones = 0;
        if (stem.level == 0 && s == 0 && stem.start == 0) {
            clones = species_.baseSplits;
        } else if (p.segSplits > 0) {
            double& error = splitError_[size_t(stem.level)];
            clones = int(std::floor(p.segSplits + error + 0.5));
            error += p.segSplits - clones;
        }
        if (clones == 0) return;
        const glm::dmat3 before = frame;
        const int remaining = p.curveRes - s - 1;
        const double decl = declination(frame), first = 360 * random.next();
        for (int k = 0; k <= clones; ++k) {
            const double angle = std::max(0.0, p.splitAngle + p.splitAngleV * random.next(-1, 1) - (stem.level == 0 ? 0 : decl));
            const double u = random.next();
            glm::dmat3 f;
            if (stem.level == 0) {
                // A trunk is so upright that only a turn about itself spreads its leaders.
                f = rotateX(rotateZ(before, first + 360.0 * k / (clones + 1) + 30 * (u - 0.5)), angle);
            } else {
                f = rotateX(before, angle + p.splitAngle * 0.5);
                const double spread = 20 + 0.75 * (30 + std::abs(decl - 90)) * u * u;
                if (k > 0) f = turnAboutVertical(f, k % 2 ? spread : -spread);
            }
            if (k == 0) {
                frame = f;
                correction = angle / remaining;
            } else {
                forks.push_back({s + 1, f, angle / remaining});
            }
        }
    }

    void growChildren(const Stem& parent, int parentId) {
        const int level = parent.level + 1;
        const LevelParameters& p = species_.levels[size_t(level)];
        base::Random random(seed_, uint64_t(parentId), kChildren + 16);
        const double begin = std::max(parent.start, parent.crown), end = parent.length;
        double most = p.branches;
        if (level == 2) {
            const double share = parent.length / (trunkLength() * species_.levels[1].length);
            most *= 0.2 + 0.8 * std::min(1.0, share);
        } else if (level > 2) {
            most *= 0.5 + 0.5 * std::min(1.0, parent.leafShare);
        }
        const int count = int(most * (end - begin) / (parent.length - parent.crown) + 0.5);
        double turn = 360 * random.next();
        for (int k = 0; k < count; ++k) {
            const int whorls = (count + p.whorl - 1) / p.whorl;
            const double place = p.whorl > 1 ? (k / p.whorl + 0.5 + 0.2 * random.next(-1, 1)) / whorls
                                             : (k + 0.5 + 0.4 * random.next(-1, 1)) / count;
            growChild(parent, parentId, p, begin + (end - begin) * (p.whorl > 1 ? wholeWhorl(place, k, p.whorl, whorls) : place), k, turn, random);
        }
    }

    /// Boughs of one whorl spring from nearly one height; whorls crowd towards the top, where a year's growth is short.
    static double wholeWhorl(double place, int k, int whorl, int whorls) {
        const double centre = (k / whorl + 0.5) / whorls, z = centre + 0.15 * (place - centre);
        return z * (1.25 - 0.25 * z);
    }

    void growChild(const Stem& parent, int parentId, const LevelParameters& p, double offset, int k, double& turn, base::Random& random) {
        const StemPoint root = parent.at(offset);
        Stem child;
        child.level = parent.level + 1;
        child.parent = parentId;
        child.parentOffset = offset;
        const double fromTop = (parent.length - offset) / std::max(1e-9, parent.length - parent.crown);
        const double relative = p.length + p.lengthV * random.next(-1, 1);
        child.length = child.level == 1 ? parent.length * relative * shapeRatio(species_.shape, fromTop)
                                        : relative * (parent.length - 0.6 * offset);
        child.radius = parent.radius * det::pow(child.length / parent.length, species_.ratioPower);
        child.radius = std::max(kMinRadius, std::min(child.radius, 0.9 * root.radius));
        child.leafShare = shapeRatio(4, fromTop);

        double direction = 0;
        if (p.rotate < 0) {
            direction = (k % 2 ? 90 : -90) + p.rotate + p.rotateV * random.next(-1, 1);
        } else {
            if (p.whorl > 1 && k % p.whorl == 0) turn += 0.5 * p.rotate;
            turn += p.rotate;
            direction = turn + p.rotateV * random.next(-1, 1);
        }
        const double down = p.downAngleV >= 0 ? p.downAngle + p.downAngleV * random.next(-1, 1)
                                              : p.downAngle - p.downAngleV * (2 * shapeRatio(0, fromTop) - 1);
        // Rows lie left and right of the parent, so they are turned from its upright plane.
        const glm::dmat3 base = p.rotate < 0 ? uprightFrame(root.frame) : root.frame;
        growStem(child, rotateX(rotateZ(base, direction), std::clamp(down, 0.0, 170.0)), root.centre, 0, 0);
    }

    /// The same z; x level with the ground where z is not vertical.
    static glm::dmat3 uprightFrame(const glm::dmat3& f) {
        const glm::dvec3 level = glm::cross(f[2], glm::dvec3(0, 0, 1));
        return glm::length(level) < 1e-3 ? f : frameAlong(f[2], level);
    }

    double trunkLength() const { return skeleton_.stems[0].length; }

    const Species& species_;
    uint64_t seed_;
    std::vector<double> splitError_;  // per level, carried over the whole tree
    Skeleton skeleton_;
};

}  // namespace

glm::dvec3 Stem::cageCentre(size_t i) const {
    const size_t last = rings.size() - 1;
    const Ring& r = rings[i];
    // e = (h + e) / 4 at one end of a segment h; a single segment is drawn out at both: e = (h + 2e) / 4.
    const double share = last == 1 ? 1.0 / 2 : 1.0 / 3;
    if (i == 0) return r.centre - r.frame[2] * ((rings[1].offset - r.offset) * share + bury);
    if (i == last) return r.centre + r.frame[2] * ((r.offset - rings[last - 1].offset) * share);
    return r.centre;
}

StemPoint Stem::at(double offset) const {
    const size_t last = rings.size() - 1;
    size_t i = 0;
    while (i + 1 < last && rings[i + 1].offset <= offset) ++i;
    const Ring &ra = rings[i], &rb = rings[i + 1];
    const double t = std::clamp((offset - ra.offset) / (rb.offset - ra.offset), 0.0, 1.0), s = 1 - t;
    const glm::dvec3 a = cageCentre(i), b = cageCentre(i + 1);
    // Past a cap the cage has no ring; its valence-3 vertices act like one half a segment inwards.
    const glm::dvec3 before = i > 0 ? cageCentre(i - 1) : 0.5 * (a + b);
    const glm::dvec3 after = i + 2 <= last ? cageCentre(i + 2) : 0.5 * (a + b);
    double w0 = s * s * s / 6, w1 = 2.0 / 3 - t * t * (1 - 0.5 * t), w2 = 2.0 / 3 - s * s * (1 - 0.5 * s), w3 = t * t * t / 6;
    if (faceted) w0 = s / 6, w1 = (4 * s + t) / 6, w2 = (s + 4 * t) / 6, w3 = t / 6;
    const glm::dvec3 z = glm::normalize(ra.frame[2] * s + rb.frame[2] * t);
    return {before * w0 + a * w1 + b * w2 + after * w3, frameAlong(z, ra.frame[0]), ra.radius * s + rb.radius * t};
}

Skeleton growSkeleton(const Species& species, uint64_t seed) { return Grower(species, seed).grow(); }

void thinRings(Skeleton& skeleton) {
    std::vector<glm::dvec3> moved(skeleton.stems.size(), glm::dvec3(0));
    const Skeleton before = skeleton;
    for (size_t i = 0; i < skeleton.stems.size(); ++i) {
        Stem& stem = skeleton.stems[i];
        if (stem.parent >= 0) {
            const auto parent = size_t(stem.parent);
            moved[i] = skeleton.stems[parent].at(stem.parentOffset).centre - before.stems[parent].at(stem.parentOffset).centre;
        }
        std::vector<Ring> kept;
        for (size_t r = 0; r < stem.rings.size(); ++r)
            if (r % 2 == 0 || r + 1 == stem.rings.size()) kept.push_back(stem.rings[r]);
        stem.rings = std::move(kept);
        for (Ring& ring : stem.rings) ring.centre += moved[i];
        orientRings(stem.rings);
    }
}

}  // namespace dapple::scenegen
