#include "scenegen/plants/wind.h"

#include "base/random.h"
#include "scenegen/plants/frames.h"

// The split into a slow bend of the whole and a quicker one of its parts is that of Sousa, "Vegetation Procedural
// Animation and Shading in Crysis", GPU Gems 3 (2007), chapter 16; here stems turn instead of shearing.
namespace dapple::scenegen {
namespace det = base::det;
namespace {

constexpr uint64_t kSwayPurpose = 128;

/// Of one level of stems, in a gale: our values, from what looks right.
struct Sway {
    double lean, swing;  ///< degrees at the tip, against the parent: steady and oscillating
    double frequency;    ///< Hz
};
constexpr Sway kSway[] = {{9, 4, 0.3}, {12, 8, 0.7}, {25, 15, 1.6}, {25, 20, 2.5}};

/// v turned about `axis` by |axis| radians, which are few enough not to need a quaternion's care.
glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis) {
    const double angle = glm::length(axis);
    if (angle < 1e-12) return v;
    const glm::dvec3 k = axis / angle;
    const auto [s, c] = det::sinCos(angle);
    return v * c + glm::cross(k, v) * s + k * (glm::dot(k, v) * (1 - c));
}

}  // namespace

void sway(Skeleton& skeleton, const Wind& wind, uint64_t seed) {
    const Skeleton before = skeleton;
    const glm::dvec3 to(wind.direction.x, wind.direction.y, 0);
    for (size_t i = 0; i < skeleton.stems.size(); ++i) {
        Stem& stem = skeleton.stems[i];
        std::vector<Ring>& rings = stem.rings;
        const std::vector<Ring>& old = before.stems[i].rings;
        glm::dmat3 carried(1);  // what the parent's bend does to directions at the stem's root
        if (stem.parent >= 0) {
            const StemPoint a = before.stems[size_t(stem.parent)].at(stem.parentOffset), b = skeleton.stems[size_t(stem.parent)].at(stem.parentOffset);
            carried = b.frame * glm::transpose(a.frame);
            rings[0].centre = b.centre + carried * (old[0].centre - a.centre);
        }
        const Sway& level = kSway[stem.level];
        const double phase = 2 * det::kPi * base::Random(seed, i, kSwayPurpose).next();
        const double swing = det::sin(2 * det::kPi * level.frequency * wind.time + phase);
        const double most = wind.strength * det::kDegree * (level.lean + level.swing * swing);
        for (size_t r = 0; r + 1 < rings.size(); ++r) {
            const glm::dvec3 segment = carried * (old[r + 1].centre - old[r].centre);
            const double along = (0.5 * (old[r].offset + old[r + 1].offset) - stem.start) / stem.length;
            // The torque falls with the angle between stem and wind: what lies in the wind stays there.
            const glm::dvec3 axis = glm::cross(glm::normalize(segment), to) * (most * along);
            rings[r + 1].centre = rings[r].centre + turned(segment, axis);
        }
        rings[0].frame = carried * rings[0].frame;
        stem.root = carried * stem.root;
        orientRings(rings);
    }
}

}  // namespace dapple::scenegen
