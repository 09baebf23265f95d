#include "scenegen/plants/skeleton.h"

#include "base/random.h"
#include "scenegen/plants/colonise.h"
#include "scenegen/plants/frames.h"
#include "scenegen/plants/lanes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace dapple::scenegen {
namespace det = base::det;
namespace {

/// Keys of the random streams of one stem.
enum Purpose : uint64_t { kCurve = 1, kSplit, kChildren, kProportions };

/// A stem's tip keeps this share of its radius: a cone's apex would make degenerate triangles.
constexpr double kTipRadius = 0.15;
constexpr double kMinRadius = 0.0012;

/// Degrees of a helix per segment: the paper gives its declination only, and four segments a turn still read as one.
constexpr double kHelixTurn = 90;

/// A stem that pruning would cut below this share of its length is left out.
constexpr double kShortest = 0.1;

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

struct Fork {
    int segment;  ///< the clone begins at the end of this many segments
    glm::dmat3 frame;
    double correction;  ///< degrees per segment that bend it back
};

/// A child to be: what the parameters and chance give before its parent's surface is looked at.
struct Bud {
    double offset;         ///< metres along the parent
    double length = 0;     ///< metres
    double leafShare = 0;
    double direction = 0, down = 0;  ///< degrees, about the parent's axis and away from it
};

class Grower {
public:
    Grower(const Species& species, uint64_t seed) : species_(species), seed_(seed), splitError_(species.levels.size(), 0.0) {
        if (species.prune.ratio == 0) return;
        for (size_t i = 0; i < kEnvelopeSteps; ++i) envelope_[i] = envelopeRatio(species.prune, double(i) / (kEnvelopeSteps - 1));
    }

    Skeleton grow(bool twigsLater) {
        base::Random random(seed_, 0, kChildren);
        const double scale = species_.scale + species_.scaleV * random.next(-1, 1);
        const LevelParameters& trunk = species_.levels[0];
        Stem stem;
        height_ = scale;
        stem.length = scale * (trunk.length + trunk.lengthV * random.next(-1, 1));
        base::Random proportions(seed_, 0, kProportions);
        stem.radius = stem.length * species_.ratio * (species_.radiusScale + species_.radiusScaleV * proportions.next(-1, 1));
        const double zScale = species_.zScale + species_.zScaleV * proportions.next(-1, 1);
        stem.crown = species_.baseSize * stem.length;
        stem.bury = 0.02 * stem.length;
        const double turn = 360 * random.next();
        trunkLength_ = stem.length;
        twigsLater_ = twigsLater && zScale == 1 && species_.levels.back().segSplits == 0;
        skeleton_.stems.reserve(2048);
        if (species_.prune.ratio > 0) skeleton_.courses.reserve(8192);
        if (species_.colonisation)
            growCrown(stem);
        else
            growStem(std::move(stem), rotateZ(glm::dmat3(1), turn), glm::dvec3(0), 0, 0);
        if (zScale != 1) stretch(zScale);
        for (Stem& grown : skeleton_.stems)
            if (!grown.rings.empty()) grown.ringCount = grown.rings.size();
        return std::move(skeleton_);
    }

    void growTwigs(Skeleton& skeleton, std::span<const uint32_t> wanted) {
        int parent = -1;
        std::optional<StemAxis> axis;
        std::vector<Fork> none;
        for (const uint32_t id : wanted) {
            Stem& twig = skeleton.stems[id];
            if (!twig.rings.empty()) continue;
            if (twig.parent != parent) axis.emplace(skeleton.stems[size_t(parent = twig.parent)]);
            const auto end = skeleton.courses.begin() + long(twig.courseEnd);
            if (twig.courseEnd > 0)
                course_.assign(end - species_.levels.back().curveRes, end);
            else
                steer(twig, int(id), twig.root, 0, 0, none);
            addRings(twig, twig.root, axis->centre(twig.parentOffset), 0, 1 << skeleton.thinned);
        }
    }

private:
    /// Offsets stay shares of the lengths that the parameters speak of, so that children stay where they sit.
    void stretch(double zScale) {
        for (Stem& stem : skeleton_.stems) {
            for (Ring& ring : stem.rings) ring.centre.z *= zScale;
            orientRings(stem.rings);
        }
    }

    double surfaceRadius(const Stem& stem, double offset) const {
        const double z = std::clamp(offset / stem.length, 0.0, 1.0);
        double r = taperedRadius(species_.levels[size_t(stem.level)].taper, stem.radius, stem.length, z);
        r = std::max({r, kTipRadius * stem.radius, kMinRadius});
        if (stem.level == 0) r *= flare(z);
        return r;
    }

    /// Section 4.4: the foot of a trunk is thicker, at the share z of its length.
    double flare(double z) const { return 1 + species_.flare * (det::pow(100, std::max(0.0, 1 - 8 * z)) - 1) / 100; }

    /// `stem` has everything but rings. `frame` and `position` hold where `segment` of its segments end.
    void growStem(Stem stem, const glm::dmat3& frame, const glm::dvec3& position, int segment, double correction) {
        const auto id = int(skeleton_.stems.size());
        stem.root = frame;
        if (isLater(stem) && !isPruned(stem)) {
            leaveForLater(stem);
            skeleton_.stems.push_back(std::move(stem));
            return;
        }
        std::vector<Fork> forks;
        if (!shape(stem, id, frame, position, segment, correction, forks)) return;
        skeleton_.stems.emplace_back();  // its place, before those of its forks and children
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        for (const Fork& f : forks) {
            Stem clone = stem;
            clone.rings.clear();
            clone.parent = id;
            clone.start = clone.parentOffset = f.segment * (stem.length / p.curveRes);
            clone.bury = 0;
            growStem(std::move(clone), f.frame, stem.at(f.segment * (stem.length / p.curveRes)).centre, f.segment, f.correction);
        }
        if (size_t(stem.level) + 1 < species_.levels.size()) growChildren(stem, id);
        skeleton_.stems[size_t(id)] = std::move(stem);
    }

    bool isLater(const Stem& stem) const { return twigsLater_ && size_t(stem.level) + 1 == species_.levels.size(); }
    bool isPruned(const Stem& stem) const { return species_.prune.ratio > 0 && stem.level > 0; }

    void leaveForLater(Stem& stem) const {
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        stem.faceted = p.refine == 0;
        stem.ringCount = size_t(p.curveRes) + 1;
    }

    /// Gives the stem its rings and, if it is pruned (section 4.6), its length; false if too little fits into the envelope.
    bool shape(Stem& stem, int id, const glm::dmat3& frame, const glm::dvec3& root, int segment, double correction, std::vector<Fork>& forks) {
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        const bool pruned = isPruned(stem);
        steer(stem, id, frame, segment, correction, forks);
        const double whole = stem.length;
        if (pruned) {
            double fit = whole;
            while (const std::optional<double> exit = leavesEnvelope(stem, fit, root, segment)) {
                fit = std::min(*exit, 0.9 * fit);  // where it left is a good guess; less never reaches as far
                if (fit < kShortest * whole) {
                    fit = 0;
                    break;
                }
            }
            stem.length = whole + (fit - whole) * species_.prune.ratio;
            if (stem.length < kShortest * whole) return false;
        }
        stem.faceted = p.refine == 0;
        if (isLater(stem)) {
            leaveForLater(stem);
            skeleton_.courses.insert(skeleton_.courses.end(), course_.begin(), course_.end());
            stem.courseEnd = skeleton_.courses.size();
        } else {
            addRings(stem, frame, root, segment, 1);
        }
        return true;
    }

    /// Sections 4.1, 4.2: the directions of the segments from `segment` on, and the forks. They do not depend on the length.
    void steer(const Stem& stem, int id, glm::dmat3 frame, int segment, double correction, std::vector<Fork>& forks) {
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        course_.clear();
        if (p.curve == 0 && p.curveBack == 0 && p.curveV == 0 && p.segSplits == 0 && correction == 0 && stem.level >= 2)
            return steerUpright(frame[2], p.curveRes);
        base::Random curve(seed_, uint64_t(id), kCurve), split(seed_, uint64_t(id), kSplit);
        const glm::dmat3 helixAxis = p.curveV < 0 ? rotateX(frame, p.curveV) : frame;
        const double helixTurn = p.curveV < 0 ? (curve.next() < 0.5f ? -kHelixTurn : kHelixTurn) : 0;
        for (int s = segment; s < p.curveRes; ++s) {
            if (p.curveV < 0) {
                frame = rotateX(rotateZ(helixAxis, helixTurn * (s - segment)), -p.curveV);
            } else {
                double bend = p.curve / p.curveRes;
                if (p.curveBack != 0) bend = (s < (p.curveRes + 1) / 2 ? p.curve : p.curveBack) / (0.5 * p.curveRes);
                frame = rotateX(frame, bend - correction + p.curveV / p.curveRes * curve.next(-1, 1));
                // Past the last segment nobody asks for more than its direction.
                const bool last = s + 1 == p.curveRes;
                if (p.curveV != 0 && !last) frame = rotateZ(frame, 30 * curve.next(-1, 1));
                if (stem.level >= 2) {
                    const glm::dvec3 along = attracted(frame[2], p.curveRes);
                    frame = last || along == frame[2] ? glm::dmat3(frame[0], frame[1], along) : frameAlong(along, frame[0]);
                }
            }
            course_.push_back(frame[2]);
            if (s + 1 < p.curveRes) fork(stem, p, s, frame, correction, split, forks);
        }
    }

    /// steer() for a stem that nothing but vertical attraction bends: it stays in one upright plane.
    void steerUpright(const glm::dvec3& along, int segments) {
        const double across = std::sqrt(along.x * along.x + along.y * along.y);
        const glm::dvec2 to = across < 1e-6 ? glm::dvec2(0) : glm::dvec2(along) / across;
        double decl = det::acos(along.z), sine = across;
        for (int s = 0; s < segments; ++s) {
            decl -= std::clamp(species_.attractionUp * decl * sine / segments, -decl, decl);
            const auto [sin, cos] = det::sinCos(decl);
            course_.emplace_back(to * sin, cos);
            sine = sin;
        }
    }

    /// Where along itself a stem of `length` metres first is outside the pruning envelope.
    std::optional<double> leavesEnvelope(const Stem& stem, double length, glm::dvec3 position, int segment) const {
        const double step = length / species_.levels[size_t(stem.level)].curveRes;
        const double most = species_.prune.width * height_;
        const auto outside = [&](const glm::dvec3& p) {
            const double distance2 = p.x * p.x + p.y * p.y;
            const double ratio = (height_ - p.z) / (height_ * (1 - species_.baseSize));
            const auto [least, widestHere] = envelopeBounds(ratio);  // a power takes long
            if (distance2 < most * most * least * least) return false;
            if (distance2 > most * most * widestHere * widestHere) return true;
            const double widest = most * envelopeRatio(species_.prune, ratio);
            return distance2 > widest * widest;
        };
        if (outside(position)) return segment * step;
        for (size_t s = 0; s < course_.size(); ++s) {
            position += course_[s] * step;
            if (outside(position)) return (segment + int(s) + 1) * step;
        }
        return std::nullopt;
    }

    /// Around envelopeRatio. The envelope rises to its peak and falls from there, so between two heights that are not on
    /// both sides of it, it is no wider and no narrower than at them; give or take what rounding may do.
    std::pair<double, double> envelopeBounds(double ratio) const {
        if (!(ratio >= 0 && ratio < 1)) return {0, 1};
        const auto i = size_t(ratio * (kEnvelopeSteps - 1));
        const auto [low, high] = std::minmax(envelope_[i], envelope_[i + 1]);
        const bool peak = std::abs(double(i) + 0.5 - (1 - species_.prune.widthPeak) * (kEnvelopeSteps - 1)) < 1.5;
        return {low * (1 - 1e-9), peak ? 1 : high * (1 + 1e-9)};
    }

    /// Every `stride`-th ring and the last.
    void addRings(Stem& stem, const glm::dmat3& frame, glm::dvec3 position, int segment, int stride) const {
        const LevelParameters& p = species_.levels[size_t(stem.level)];
        stem.rings.reserve(course_.size() / size_t(stride) + (stem.level == 0 ? 4 : 2));
        const double step = stem.length / p.curveRes;
        if (segment > 0) stem.start = segment * step;
        const auto addRing = [&](const glm::dvec3& centre, double offset) {
            stem.rings.push_back({centre, frame, surfaceRadius(stem, offset), offset});
        };
        addRing(position, segment * step);
        for (const glm::dvec3& along : course_) {
            // The flare lies within the first eighth of the trunk: two rings more carry it.
            if (stem.level == 0 && segment == 0)
                for (const double share : {0.15, 0.5}) addRing(position + along * (share * step), share * step);
            position += along * step;
            if (++segment % stride == 0 || &along == &course_.back()) addRing(position, segment * step);
        }
        orientRings(stem.rings);
    }

    void growCrown(const Stem& trunk) {
        nodes_ = colonise(species_, height_, trunk.radius, seed_);
        thickest_.assign(nodes_.size(), 0);
        others_.resize(nodes_.size());
        for (size_t i = 1; i < nodes_.size(); ++i) {
            const auto parent = size_t(nodes_[i].parent);
            size_t& thickest = thickest_[parent];
            const size_t other = thickest != 0 && nodes_[i].radius <= nodes_[thickest].radius ? i : std::exchange(thickest, i);
            if (other != 0) others_[parent].push_back(other);
        }
        growColonised(0, trunk);
    }

    /// The stem that begins at a node and goes on to its thickest child each time; the others begin stems of their own.
    void growColonised(size_t first, Stem stem) {
        const auto id = int(skeleton_.stems.size());
        stem.faceted = species_.levels[size_t(stem.level)].refine == 0;
        stem.length = 0;
        glm::dvec3 end = nodes_[first].position;
        if (stem.parent >= 0) {
            const StemPoint root = skeleton_.stems[size_t(stem.parent)].at(stem.parentOffset);
            stem.radius = std::min(nodes_[first].radius, 0.9 * root.radius);
            stem.length = glm::distance(root.centre, end);
            stem.rings.push_back({root.centre, glm::dmat3(1), stem.radius, 0});
        }
        std::vector<std::pair<size_t, double>> forks;  // first nodes of side stems, and where they leave
        for (size_t node = first, count = 0;; node = thickest_[node], ++count) {
            stem.length += glm::distance(nodes_[node].position, end);
            end = nodes_[node].position;
            for (const size_t other : others_[node]) forks.emplace_back(other, stem.length);
            // Every second node is ring enough.
            if (count % 2 == 0 || thickest_[node] == 0)
                stem.rings.push_back({end, glm::dmat3(1), std::max(std::min(nodes_[node].radius, stem.radius), kMinRadius), stem.length});
            if (thickest_[node] == 0) break;
        }
        orientRings(stem.rings);
        if (stem.level == 0)
            for (Ring& ring : stem.rings) ring.radius *= flare(ring.offset / stem.length);
        skeleton_.stems.push_back(stem);
        for (const auto& [node, offset] : forks) {
            Stem limb;
            limb.level = 1;
            limb.parent = id;
            limb.parentOffset = offset;
            growColonised(node, std::move(limb));
        }
        if (stem.level == 1) growChildren(stem, id);
    }

    /// Section 4.8: vertical attraction turns the direction towards the sky.
    glm::dvec3 attracted(const glm::dvec3& along, int segments) const {
        const glm::dvec3 axis = glm::cross(along, glm::dvec3(0, 0, 1));
        const double sine = glm::length(axis);
        if (species_.attractionUp == 0 || sine < 1e-6) return along;
        const double decl = det::acos(along.z) / det::kDegree, angle = std::clamp(species_.attractionUp * decl * sine / segments, -decl, decl);
        const auto [s, c] = det::sinCos(angle * det::kDegree);
        return along * c + glm::cross(axis / sine, along) * s;
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
        if (species_.colonisation) {
            most *= parent.length / trunkLength_;
        } else if (level == 2) {
            const double share = parent.length / (trunkLength_ * species_.levels[1].length);
            most *= 0.2 + 0.8 * std::min(1.0, share);
        } else if (level > 2) {
            most *= 0.5 + 0.5 * std::min(1.0, parent.leafShare);
        }
        const int count = int(most * (end - begin) / (parent.length - parent.crown) + 0.5);
        double turn = 360 * random.next();
        // All buds first: their powers go abreast.
        std::vector<Bud> buds;
        buds.reserve(size_t(std::max(0, count)));
        for (int k = 0; k < count; ++k) {
            const int whorls = (count + p.whorl - 1) / p.whorl;
            const double place = p.whorl > 1 ? (k / p.whorl + 0.5 + 0.2 * random.next(-1, 1)) / whorls
                                             : (k + 0.5 + 0.4 * random.next(-1, 1)) / count;
            buds.push_back(bud(parent, p, begin + (end - begin) * (p.whorl > 1 ? wholeWhorl(place, k, p.whorl, whorls) : place), k, turn, random));
        }
        std::vector<double> thickness;
        thickness.reserve(buds.size());
        for (const Bud& b : buds) thickness.push_back(b.length / parent.length);
        powers(thickness, species_.ratioPower);
        StemAxis axis(parent);
        for (size_t k = 0; k < buds.size(); ++k) growChild(parent, parentId, p, buds[k], thickness[k], axis.at(buds[k].offset));
    }

    /// Boughs of one whorl spring from nearly one height; whorls crowd towards the top, where a year's growth is short.
    static double wholeWhorl(double place, int k, int whorl, int whorls) {
        const double centre = (k / whorl + 0.5) / whorls, z = centre + 0.15 * (place - centre);
        return z * (1.25 - 0.25 * z);
    }

    double crownRatio(double fromTop) const {
        return species_.shape == 8 ? envelopeRatio(species_.prune, fromTop) : shapeRatio(species_.shape, fromTop);
    }

    /// Child k at `offset`; `turn` is the direction of the one before.
    Bud bud(const Stem& parent, const LevelParameters& p, double offset, int k, double& turn, base::Random& random) const {
        const double fromTop = (parent.length - offset) / std::max(1e-9, parent.length - parent.crown);
        const double relative = p.length + p.lengthV * random.next(-1, 1);
        Bud b{.offset = offset};
        b.length = parent.level == 0 ? parent.length * relative * crownRatio(fromTop)
                   : species_.colonisation ? relative * trunkLength_
                                           : relative * (parent.length - 0.6 * offset);
        b.leafShare = shapeRatio(4, fromTop);
        if (p.rotate < 0) {
            b.direction = (k % 2 ? 90 : -90) + p.rotate + p.rotateV * random.next(-1, 1);
        } else {
            if (p.whorl > 1 && k % p.whorl == 0) turn += 0.5 * p.rotate;
            turn += p.rotate;
            b.direction = turn + p.rotateV * random.next(-1, 1);
        }
        b.down = p.downAngleV >= 0 ? p.downAngle + p.downAngleV * random.next(-1, 1)
                                   : p.downAngle - p.downAngleV * (2 * shapeRatio(0, fromTop) - 1);
        return b;
    }

    void growChild(const Stem& parent, int parentId, const LevelParameters& p, const Bud& b, double thickness, const StemPoint& root) {
        Stem child;
        child.level = parent.level + 1;
        child.parent = parentId;
        child.parentOffset = b.offset;
        child.length = b.length;
        child.radius = std::max(kMinRadius, std::min(parent.radius * thickness, 0.9 * root.radius));
        child.leafShare = b.leafShare;
        // Rows lie left and right of the parent, so they are turned from its upright plane.
        const glm::dmat3 base = p.rotate < 0 ? uprightFrame(root.frame) : root.frame;
        growStem(std::move(child), rotateX(rotateZ(base, b.direction), std::clamp(b.down, 0.0, 170.0)), root.centre, 0, 0);
    }

    /// The same z; x level with the ground where z is not vertical.
    static glm::dmat3 uprightFrame(const glm::dmat3& f) {
        const glm::dvec3 level = glm::cross(f[2], glm::dvec3(0, 0, 1));
        return glm::length(level) < 1e-3 ? f : frameAlong(f[2], level);
    }

    const Species& species_;
    uint64_t seed_;
    double height_ = 0, trunkLength_ = 0;  // metres
    std::vector<double> splitError_;  // per level, carried over the whole tree
    bool twigsLater_ = false;
    static constexpr size_t kEnvelopeSteps = 129;
    std::array<double, kEnvelopeSteps> envelope_{};  // of pruning, from its top to its foot
    std::vector<glm::dvec3> course_;  // of the stem that is being shaped: the direction of each of its segments
    std::vector<CrownNode> nodes_;                 // of a colonised tree,
    std::vector<size_t> thickest_;                 // of each its thickest child, or 0,
    std::vector<std::vector<size_t>> others_;      // and the others
    Skeleton skeleton_;
};

}  // namespace

Skeleton growSkeleton(const Species& species, uint64_t seed) { return Grower(species, seed).grow(false); }

Skeleton growLimbs(const Species& species, uint64_t seed) { return Grower(species, seed).grow(true); }

void growTwigs(const Species& species, uint64_t seed, Skeleton& skeleton, std::span<const uint32_t> wanted) {
    Grower(species, seed).growTwigs(skeleton, wanted);
}

}  // namespace dapple::scenegen
