#include "scenegen/placement/path.h"

#include "base/detmath.h"
#include "base/random.h"

#include <cmath>

namespace dapple::scenegen {
namespace det = base::det;
namespace {
constexpr double kAmplitude = 0.035, kWaves = 2.5;  // of the ground's size; bends over its length
}

Path::Path(double groundSize, uint64_t seed) : size_(groundSize), maxSlope_(1.5 * kAmplitude * 2 * det::kPi * kWaves) {
    base::Random random(seed, 0, 0x70617468);
    phase_ = 2 * det::kPi * random.next();
    side_ = random.next(-0.1f, 0.1f) * groundSize;
}

double Path::x(double y) const {
    const double t = 2 * det::kPi * kWaves * y / size_ + phase_;
    return side_ + kAmplitude * size_ * (det::sin(t) + 0.5 * det::sin(0.5 * t));
}

double Path::slope(double y) const {
    const double t = 2 * det::kPi * kWaves * y / size_ + phase_;
    return kAmplitude * 2 * det::kPi * kWaves * (det::cos(t) + 0.25 * det::cos(0.5 * t));
}

glm::dvec2 Path::direction(double y) const { return glm::normalize(glm::dvec2(slope(y), 1)); }

double Path::distance(const glm::dvec2& p) const {
    return std::abs(p.x - x(p.y)) / std::sqrt(1 + maxSlope_ * maxSlope_);
}

}  // namespace dapple::scenegen
