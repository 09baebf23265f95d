#include "base/random.h"
#include "scenegen/terrain/height_field.h"

#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr uint64_t kPurpose = 0x66626d;

/// Slope at a lattice point: one of 16 directions without a preference for the axes, chosen by a hash.
glm::dvec2 gradient(const base::Random& random, int64_t i, int64_t j) {
    static constexpr double kCos[] = {1, 0.92387953251128674, 0.70710678118654752, 0.38268343236508977};
    const uint64_t bits = random.bits(base::mix64(uint64_t(i)) + 0x9e3779b97f4a7c15 * uint64_t(j));
    const int octant = int(bits & 15), k = octant & 3;
    glm::dvec2 g(kCos[k], k == 0 ? 0 : kCos[4 - k]);
    for (int turn = octant >> 2; turn > 0; --turn) g = {-g.y, g.x};
    return g;
}

/// Perlin, "Improving Noise" (2002): quintic fade.
double noise(const base::Random& random, double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y), s = x - fx, t = y - fy;
    const auto i = int64_t(fx), j = int64_t(fy);
    const auto corner = [&](int a, int b) { return glm::dot(gradient(random, i + a, j + b), glm::dvec2(s - a, t - b)); };
    const auto fade = [](double v) { return v * v * v * (v * (v * 6 - 15) + 10); };
    const double u = fade(s), v = fade(t);
    return glm::mix(glm::mix(corner(0, 0), corner(1, 0), u), glm::mix(corner(0, 1), corner(1, 1), u), v);
}

}  // namespace

void addFbm(HeightField& field, const FbmOptions& options) {
    double amplitude = 1, frequency = 1 / options.wavelength;
    for (int octave = 0; octave < options.octaves; ++octave) {
        const base::Random random(options.seed, uint64_t(octave), kPurpose);
        for (int j = 0; j < field.rows; ++j)
            for (int i = 0; i < field.columns; ++i)
                field.at(i, j) += float(amplitude * noise(random, field.x(i) * frequency, field.y(j) * frequency));
        amplitude *= options.gain;
        frequency *= options.lacunarity;
    }
}

}  // namespace dapple::scenegen
