#include "truth/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace dapple::truth {
namespace {

constexpr float kBoundaryPixels = 2;  ///< error within this distance of G's boundary is booked as boundary error

bool inOmega(Label label) { return label == Label::lit || label == Label::shadowed; }

/// Calls visit(pixel, neighbour) for every horizontal and vertical pair of pixels that both lie in Ω, once.
template <class Visit>
void forPairsInOmega(const Reference& reference, const Visit& visit) {
    const auto width = size_t(reference.width), height = size_t(reference.height);
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const size_t i = y * width + x;
            if (!inOmega(reference.label[i])) continue;
            if (x + 1 < width && inOmega(reference.label[i + 1])) visit(i, i + 1);
            if (y + 1 < height && inOmega(reference.label[i + width])) visit(i, i + width);
        }
}

/// Pixels of Ω with a 4-neighbour in Ω of the other class. An excluded or ambiguous neighbour is no edge.
std::vector<uint8_t> boundaryOf(const Reference& reference, const std::vector<uint8_t>& dark) {
    std::vector<uint8_t> boundary(dark.size(), 0);
    forPairsInOmega(reference, [&](size_t a, size_t b) {
        if (dark[a] != dark[b]) boundary[a] = boundary[b] = 1;
    });
    return boundary;
}

void appendDistances(const std::vector<uint8_t>& from, const std::vector<float>& distanceTo, std::vector<float>& out) {
    for (size_t i = 0; i < from.size(); ++i)
        if (from[i]) out.push_back(distanceTo[i]);
}

void measureEdges(const std::vector<uint8_t>& boundaryG, const std::vector<uint8_t>& boundaryV, const std::vector<float>& toG,
                  const std::vector<float>& toV, ErrorMetrics& m) {
    std::vector<float> d;
    appendDistances(boundaryV, toG, d);
    appendDistances(boundaryG, toV, d);
    // One boundary missing: its distances are infinite. Both missing: there are none.
    if (d.empty() || !std::isfinite(*std::ranges::max_element(d))) return;
    std::ranges::sort(d);
    m.edgeMean = std::accumulate(d.begin(), d.end(), 0.0) / double(d.size());
    m.edgeP95 = d[(95 * d.size() + 99) / 100 - 1];  // nearest rank
    m.edgeMax = d.back();
}

struct Counts {
    size_t omega = 0, ambiguous = 0, shadowed = 0;
};

Counts count(const Reference& reference) {
    const auto of = [&](Label l) { return size_t(std::ranges::count(reference.label, l)); };
    const size_t shadowed = of(Label::shadowed);
    return {of(Label::lit) + shadowed, of(Label::ambiguous), shadowed};
}

double share(size_t part, size_t whole) { return whole == 0 ? 0.0 : double(part) / double(whole); }

}  // namespace

float difference(const Reference& reference, size_t pixel, float visibility) {
    const float g = reference.value(pixel), d = visibility - g;
    return std::isfinite(d) ? d : g < 0.5f ? 1.f : -1.f;
}

ErrorMetrics measureError(const Reference& reference, std::span<const float> visibility) {
    const size_t pixels = reference.label.size();
    assert(visibility.size() == pixels);
    const Counts n = count(reference);
    ErrorMetrics m;
    m.valid = share(n.omega, pixels);
    m.ambiguous = share(n.ambiguous, n.omega + n.ambiguous);
    m.shadowed = share(n.shadowed, n.omega);
    if (n.omega == 0) return m;

    std::vector<uint8_t> darkG(pixels), darkV(pixels);
    for (size_t i = 0; i < pixels; ++i) {
        darkG[i] = reference.label[i] == Label::shadowed;
        darkV[i] = !(visibility[i] >= 0.5f);
    }
    const std::vector<uint8_t> boundaryG = boundaryOf(reference, darkG), boundaryV = boundaryOf(reference, darkV);
    const std::vector<float> toG = distanceTransform(boundaryG, reference.width, reference.height);
    const std::vector<float> toV = distanceTransform(boundaryV, reference.width, reference.height);

    size_t wrong[2][2] = {};  // [false light?][interior?]
    double sum = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (!inOmega(reference.label[i])) continue;
        sum += std::abs(double(difference(reference, i, visibility[i])));
        if (darkG[i] != darkV[i]) ++wrong[darkG[i]][toG[i] > kBoundaryPixels];
    }
    m.meanAbsolute = sum / double(n.omega);
    m.falseShadowBoundary = share(wrong[0][0], n.omega);
    m.falseShadowInterior = share(wrong[0][1], n.omega);
    m.falseLightBoundary = share(wrong[1][0], n.omega);
    m.falseLightInterior = share(wrong[1][1], n.omega);
    m.falseShadow = share(wrong[0][0] + wrong[0][1], n.omega);
    m.falseLight = share(wrong[1][0] + wrong[1][1], n.omega);
    m.error = share(wrong[0][0] + wrong[0][1] + wrong[1][0] + wrong[1][1], n.omega);
    measureEdges(boundaryG, boundaryV, toG, toV, m);
    return m;
}

Flips measureFlips(const Reference& before, const Reference& now, std::span<const float> visibilityBefore, std::span<const float> visibility,
                   std::span<const int32_t> same) {
    Flips flips;
    size_t both = 0;
    for (size_t i = 0; i < now.label.size(); ++i) {
        if (!same.empty() && same[i] < 0) continue;
        const size_t j = same.empty() ? i : size_t(same[i]);
        if (!inOmega(before.label[j]) || !inOmega(now.label[i])) continue;
        ++both;
        const double change = std::abs(double(visibility[i]) - double(visibilityBefore[j]));
        flips.image += std::isfinite(change) ? change : 1.0;
        flips.reference += std::abs(double(now.value(i)) - double(before.value(j)));
    }
    if (both > 0) flips.image /= double(both), flips.reference /= double(both);
    return flips;
}

std::vector<int32_t> correspondence(const Receivers& before, const glm::dmat4& clipBefore, const Receivers& now, const glm::dvec3& moved) {
    std::vector<int32_t> same(now.present.size(), -1);
    // A pixel's breadth at clip w, which is the distance along the view: the second row holds 1 / the tangent of half the view.
    const double breadth = 2 / (before.height * glm::length(glm::dvec3(clipBefore[0][1], clipBefore[1][1], clipBefore[2][1])));
    for (size_t i = 0; i < same.size(); ++i) {
        if (!now.present[i]) continue;
        const glm::dvec3 p = glm::dvec3(now.position[i]) + moved;
        const glm::dvec4 clip = clipBefore * glm::dvec4(p, 1);
        if (!(clip.w > 0)) continue;
        const double x = std::floor((clip.x / clip.w + 1) / 2 * before.width), y = std::floor((1 - clip.y / clip.w) / 2 * before.height);
        if (!(x >= 0 && x < before.width && y >= 0 && y < before.height)) continue;
        const size_t j = size_t(y) * size_t(before.width) + size_t(x);
        if (!before.present[j] || glm::dot(before.normal[j], now.normal[i]) < 0.9f) continue;
        if (std::abs(glm::dot(glm::dvec3(now.normal[i]), p - glm::dvec3(before.position[j]))) <= breadth * clip.w) same[i] = int32_t(j);
    }
    return same;
}

double halfPixelSensitivity(const Reference& reference, std::span<const Reference> shifted) {
    double sum = 0;
    for (const Reference& other : shifted) {
        assert(other.label.size() == reference.label.size());
        size_t both = 0, differing = 0;
        for (size_t i = 0; i < reference.label.size(); ++i) {
            if (!inOmega(reference.label[i]) || !inOmega(other.label[i])) continue;
            ++both;
            differing += reference.label[i] != other.label[i];
        }
        sum += share(differing, both);
    }
    return shifted.empty() ? 0 : sum / double(shifted.size());
}

}  // namespace dapple::truth
