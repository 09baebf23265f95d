#include "base/detmath.h"
#include "base/random.h"
#include "scenegen/plants/foliage.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

/// Leaves that are narrower, over their length, are blades of grass.
constexpr double kBladeScaleX = 0.1;

/// Draws tapering blades into an image; the coverage of an edge texel is its distance to the edge, so that the alpha
/// test at one half cuts along the outline.
class Painter {
public:
    Painter(int size, uint8_t r, uint8_t g, uint8_t b) : image_{size, size, 4, {}}, size_(size) {
        // Texels without a leaf carry the leaves' colour too: filtering must not bleed black into the edges.
        image_.texels.reserve(size_t(size) * size_t(size) * 4);
        for (int i = 0; i < size * size; ++i) image_.texels.insert(image_.texels.end(), {r, g, b, 0});
    }

    /// From `root` in direction `degrees` (0 = up the image, clockwise); lengths in shares of the image.
    /// `belly` ≥ 0 is how far from parallel-sided to lens-shaped the outline is.
    void blade(glm::dvec2 root, double degrees, double length, double width, double belly, const glm::dvec3& colour) {
        const auto [s, c] = base::det::sinCos(degrees * base::det::kDegree);
        const glm::dvec2 along(s, -c), across(c, s);
        const glm::dvec2 tip = root + along * length, pad(width);
        const glm::dvec2 lo = glm::min(root, tip) - pad, hi = glm::max(root, tip) + pad;
        const auto texel = [&](double v) { return std::clamp(int(std::floor(v * size_)), 0, size_ - 1); };
        for (int y = texel(lo.y); y <= texel(hi.y); ++y)
            for (int x = texel(lo.x); x <= texel(hi.x); ++x) {
                const glm::dvec2 d = glm::dvec2(x + 0.5, y + 0.5) / double(size_) - root;
                const double u = glm::dot(d, along) / length, v = glm::dot(d, across);
                if (u < 0 || u > 1) continue;
                const double lens = 4 * u * (1 - u), half = 0.5 * width * ((1 - belly) * std::sqrt(1 - u) + belly * lens);
                const double coverage = std::clamp(0.5 + (half - std::abs(v)) * size_, 0.0, 1.0);
                if (coverage <= 0) continue;
                uint8_t* out = image_.at(x, y);
                const double midrib = std::abs(v) * size_ < 0.7 && belly > 0.5 ? 0.8 : 1;
                if (coverage >= 0.5)
                    for (int k = 0; k < 3; ++k) out[k] = uint8_t(std::clamp(colour[k] * midrib, 0.0, 1.0) * 255 + 0.5);
                out[3] = std::max(out[3], uint8_t(coverage * 255 + 0.5));
            }
    }

    base::Image8 take() { return std::move(image_); }

private:
    base::Image8 image_;
    int size_;
};

void drawNeedles(Painter& painter, base::Random& random) {
    const auto sprig = [&](glm::dvec2 root, double degrees, double length, double needle) {
        const auto [s, c] = base::det::sinCos(degrees * base::det::kDegree);
        constexpr int kPairs = 26;
        for (int i = 0; i < kPairs; ++i) {
            const double t = (i + 0.5) / kPairs;
            const glm::dvec2 at = root + glm::dvec2(s, -c) * (length * t);
            for (const int side : {-1, 1}) {
                const double tone = 0.72 + 0.28 * random.next();
                const double angle = degrees + side * (58 - 30 * t + 8 * random.next(-1, 1));
                painter.blade(at, angle, needle * (1 - 0.35 * t) * random.next(0.85f, 1.1f), 0.022, 0.2, {tone, tone, 0.9 * tone});
            }
        }
        painter.blade(root, degrees, length, 0.022, 0, {0.85, 0.6, 0.5});
    };
    for (int i = 0; i < 4; ++i)
        for (const int side : {-1, 1}) sprig({0.5, 0.86 - 0.17 * i}, side * (52.0 - 4 * i), 0.42 - 0.055 * i, 0.11);
    sprig({0.5, 1.0}, 0, 0.86, 0.13);
}

void drawBlades(Painter& painter, base::Random& random) {
    constexpr int kBlades = 17;
    for (int i = 0; i < kBlades; ++i) {
        const double tone = 0.7 + 0.3 * random.next(), t = 2.0 * i / (kBlades - 1) - 1;
        painter.blade({0.5 + 0.12 * t, 1.0}, 26 * t + 5 * random.next(-1, 1), random.next(0.65f, 0.98f), 0.04, 0.35, {tone, tone, 0.9 * tone});
    }
}

void drawLeaves(Painter& painter, base::Random& random) {
    painter.blade({0.5, 1.0}, 0, 0.8, 0.02, 0, {0.8, 0.65, 0.55});
    constexpr int kPairs = 5;
    for (int i = 0; i < kPairs; ++i)
        for (const int side : {-1, 1}) {
            const double tone = 0.7 + 0.3 * random.next(), t = double(i) / kPairs;
            const glm::dvec2 at(0.5, 0.9 - 0.66 * t - 0.05 * random.next());
            painter.blade(at, side * (70 - 38 * t + 10 * random.next(-1, 1)), 0.42 - 0.08 * t, 0.2, 1, {tone, tone, 0.9 * tone});
        }
    painter.blade({0.5, 0.36}, 4, 0.34, 0.19, 1, {0.95, 0.95, 0.86});
}

}  // namespace

base::Image8 drawCard(const Species& species, int size) {
    Painter painter(size, 217, 217, 195);
    base::Random random(0, 0, species.leaves.needles ? 2 : 1);
    const auto draw = species.leaves.needles ? drawNeedles : species.leaves.scaleX < kBladeScaleX ? drawBlades : drawLeaves;
    draw(painter, random);
    return painter.take();
}

}  // namespace dapple::scenegen
