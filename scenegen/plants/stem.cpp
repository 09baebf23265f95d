#include "scenegen/plants/frames.h"

#include <algorithm>
#include <memory>

namespace dapple::scenegen {

void orientRings(std::vector<Ring>& r) {
    const size_t last = r.size() - 1;
    glm::dvec3 across = r[0].frame[0], along(0);
    for (size_t i = 0; i <= last; ++i) {
        if (i == 0 || last > 1) along = glm::normalize(r[std::min(i + 1, last)].centre - r[i == 0 ? 0 : i - 1].centre);
        if (std::abs(glm::dot(across, along)) > 0.99) across = r[i == 0 ? 0 : i - 1].frame[1];
        r[i].frame = frameAlong(along, across);
        across = r[i].frame[0];
    }
}

glm::dvec3 Stem::cageCentre(size_t i) const {
    const size_t last = rings.size() - 1;
    const Ring& r = rings[i];
    // e = (h + e) / 4 at one end of a segment h; a single segment is drawn out at both: e = (h + 2e) / 4.
    const double share = last == 1 ? 1.0 / 2 : 1.0 / 3;
    if (i == 0) return r.centre - r.frame[2] * ((rings[1].offset - r.offset) * share + bury);
    if (i == last) return r.centre + r.frame[2] * ((r.offset - rings[last - 1].offset) * share);
    return r.centre;
}

StemPoint Stem::at(double offset) const { return StemAxis(*this).at(offset); }

StemAxis::StemAxis(const Stem& stem) : stem_(&stem), segment_(stem.rings.size()) {}

double StemAxis::enter(double offset) {
    const std::vector<Ring>& rings = stem_->rings;
    const size_t last = rings.size() - 1;
    size_t i = 0;
    while (i + 1 < last && rings[i + 1].offset <= offset) ++i;
    if (i != segment_) {
        segment_ = i;
        a_ = stem_->cageCentre(i), b_ = stem_->cageCentre(i + 1);
        // Past a cap the cage has no ring; its valence-3 vertices act like one half a segment inwards.
        before_ = i > 0 ? stem_->cageCentre(i - 1) : 0.5 * (a_ + b_);
        after_ = i + 2 <= last ? stem_->cageCentre(i + 2) : 0.5 * (a_ + b_);
    }
    return std::clamp((offset - rings[i].offset) / (rings[i + 1].offset - rings[i].offset), 0.0, 1.0);
}

glm::dvec3 StemAxis::spline(double t) const {
    const double s = 1 - t;
    double w0 = s * s * s / 6, w1 = 2.0 / 3 - t * t * (1 - 0.5 * t), w2 = 2.0 / 3 - s * s * (1 - 0.5 * s), w3 = t * t * t / 6;
    if (stem_->faceted) w0 = s / 6, w1 = (4 * s + t) / 6, w2 = (s + 4 * t) / 6, w3 = t / 6;
    return before_ * w0 + a_ * w1 + b_ * w2 + after_ * w3;
}

glm::dvec3 StemAxis::centre(double offset) { return spline(enter(offset)); }

StemAxis::Raw StemAxis::raw(double offset) {
    const double t = enter(offset);
    const Ring &ra = stem_->rings[segment_], &rb = stem_->rings[segment_ + 1];
    return {spline(t), ra.frame[2] * (1 - t) + rb.frame[2] * t, ra.frame[0]};
}

StemPoint StemAxis::at(double offset) {
    const double t = enter(offset);
    const Ring &ra = stem_->rings[segment_], &rb = stem_->rings[segment_ + 1];
    const glm::dvec3 z = glm::normalize(ra.frame[2] * (1 - t) + rb.frame[2] * t);
    return {spline(t), frameAlong(z, ra.frame[0]), ra.radius * (1 - t) + rb.radius * t};
}

void thinRings(Skeleton& skeleton) {
    ++skeleton.thinned;
    std::vector<bool> bears(skeleton.stems.size(), false);
    for (const Stem& stem : skeleton.stems)
        if (stem.parent >= 0) bears[size_t(stem.parent)] = true;
    std::vector<glm::dvec3> moved(skeleton.stems.size(), glm::dvec3(0));
    std::vector<std::unique_ptr<const Stem>> before(skeleton.stems.size());  // of those that bear others
    for (size_t i = 0; i < skeleton.stems.size(); ++i) {
        Stem& stem = skeleton.stems[i];
        stem.ringCount = stem.ringCount / 2 + 1;
        if (stem.rings.empty()) continue;
        if (stem.parent >= 0) {
            const auto parent = size_t(stem.parent);
            moved[i] = StemAxis(skeleton.stems[parent]).centre(stem.parentOffset) - StemAxis(*before[parent]).centre(stem.parentOffset);
        }
        if (bears[i]) before[i] = std::make_unique<const Stem>(stem);
        std::vector<Ring>& rings = stem.rings;
        for (size_t r = 0; r < stem.ringCount; ++r) rings[r] = rings[std::min(2 * r, rings.size() - 1)];
        rings.erase(rings.begin() + long(stem.ringCount), rings.end());
        for (Ring& ring : rings) ring.centre += moved[i];
        orientRings(rings);
    }
}

}  // namespace dapple::scenegen
