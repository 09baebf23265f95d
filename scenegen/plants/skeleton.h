#pragma once

#include "scenegen/plants/species.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// A cross-section of a stem.
struct Ring {
    glm::dvec3 centre;  ///< metres, foot of the tree at the origin, z up
    glm::dmat3 frame;   ///< columns x, y across the stem, z along it
    double radius;      ///< metres, of the surface (the cage's is larger)
    double offset;      ///< metres along the stem from its root
};

/// Frame and radius on a stem's surface, that is, after subdivision of its cage.
struct StemPoint {
    glm::dvec3 centre;
    glm::dmat3 frame;
    double radius;
};

struct Stem {
    int level = 0;
    int parent = -1;         ///< index; a clone (a fork) has the level of its parent
    double length = 0;       ///< metres, of the whole stem that a clone continues
    double radius = 0;       ///< metres, at the root
    double start = 0;        ///< offset at which a clone leaves; 0 for others
    double crown = 0;        ///< offset of the first child
    double parentOffset = 0; ///< where on the parent it begins, metres along the parent
    double leafShare = 1;    ///< factor on the leaves of a twig, from its place on its parent
    bool faceted = false;    ///< meshed without subdivision: between two rings the surface is straight
    double bury = 0;         ///< a trunk goes on below the ground, which undulates: metres
    glm::dmat3 root{1};      ///< frame that it leaves its parent with, before its first bend
    size_t ringCount = 0;    ///< of rings, once they are grown
    size_t courseEnd = 0;    ///< of its directions in Skeleton::courses; 0: not there
    std::vector<Ring> rings; ///< at least two; none before growTwigs, where they are left to that

    /// Centre of ring i of the control cage. The ends lie beyond the stem's, because the limit surface
    /// retreats at a cap (vertices of valence 3) by a quarter of the cage's last segment.
    glm::dvec3 cageCentre(size_t i) const;

    /// Its mesh has the topology of the other's.
    bool isLike(const Stem& other) const { return level == other.level && ringCount == other.ringCount; }

    /// On the axis of the mesh: a uniform cubic B-spline along the stem, or its chords. `offset` is clamped.
    StemPoint at(double offset) const;
};

/// Stem::at for many offsets: what a segment's points have in common is kept until the next is asked for.
class StemAxis {
public:
    /// A point whose frame is yet to be made orthonormal: frameAlong(normalize(along), across).
    struct Raw {
        glm::dvec3 centre, along, across;
    };
    explicit StemAxis(const Stem& stem);
    StemPoint at(double offset);
    Raw raw(double offset);
    glm::dvec3 centre(double offset);

private:
    double enter(double offset);  ///< makes its segment the current one; returns the share along it
    glm::dvec3 spline(double t) const;

    const Stem* stem_;
    size_t segment_;
    glm::dvec3 before_, a_, b_, after_;  // control points of the current segment
};

struct Skeleton {
    std::vector<Stem> stems;  ///< a parent stands before its children
    int thinned = 0;          ///< times that thinRings was called
    std::vector<glm::dvec3> courses;  ///< of each segment of those twigs whose length pruning had to find out, unit
};

/// Weber and Penn (1995), sections 4.1-4.8. The same species and seed give the same bits everywhere.
Skeleton growSkeleton(const Species& species, uint64_t seed);

/// The same without the rings of twigs (stems of the last level), most of which a budget may drop. Twigs that fork, or of
/// trees that are stretched, have theirs at once.
Skeleton growLimbs(const Species& species, uint64_t seed);

/// Gives those of the stems `wanted` (indices) that have none their rings, as thinned as their parents'.
void growTwigs(const Species& species, uint64_t seed, Skeleton& skeleton, std::span<const uint32_t> wanted);

/// Takes every second ring away, and moves what grows on a stem along with its surface.
void thinRings(Skeleton& skeleton);

}  // namespace dapple::scenegen
