#include "base/random.h"
#include "scenegen/terrain/height_field.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr uint64_t kPurpose = 0x726169;
// Beyer (2015), section 3, with steps of one cell and heights as shares of the field's relief, so that neither changes
// how it erodes.
constexpr double kInertia = 0.05, kCapacity = 4, kMinSlope = 1e-3, kDeposition = 0.3, kErosion = 0.3, kEvaporation = 0.02, kGravity = 4;
constexpr int kSteps = 64, kRadius = 3;

/// Weights of the samples about a point from which soil is taken; they sum to 1 within the field.
struct Brush {
    struct Tap {
        int di, dj;
        double weight;
    };
    std::vector<Tap> taps;
    Brush() {
        double sum = 0;
        for (int dj = -kRadius; dj <= kRadius; ++dj)
            for (int di = -kRadius; di <= kRadius; ++di) {
                const double w = kRadius - std::sqrt(double(di * di + dj * dj));
                if (w <= 0) continue;
                taps.push_back({di, dj, w});
                sum += w;
            }
        for (Tap& tap : taps) tap.weight /= sum;
    }
};

class Rain {
public:
    Rain(HeightField& field, double lowest, double relief) : field_(field), relief_(relief), base_(lowest / relief) {}

    void drop(glm::dvec2 p) {
        glm::dvec2 direction(0);
        double speed = 1, water = 1, soil = 0;
        for (int step = 0; step < kSteps; ++step) {
            const Sample here = sample(p);
            direction = direction * kInertia - here.gradient * (1 - kInertia);
            const double length = glm::length(direction);
            if (length < 1e-9) return;
            direction /= length;
            const glm::dvec2 next = p + direction;
            if (!inside(next)) return;
            const double fall = sample(next).height - here.height;  // share of the relief; negative downhill
            const double capacity = std::max(-fall, kMinSlope) * speed * water * kCapacity;
            if (soil > capacity || fall > 0) {
                const double left = fall > 0 ? std::min(fall, soil) : (soil - capacity) * kDeposition;
                soil -= left;
                deposit(p, left);
            } else {
                // Where water leaves the field nothing holds a bed up: no valley is cut below the lowest point.
                const double taken = std::clamp(std::min((capacity - soil) * kErosion, -fall), 0.0, std::max(0.0, here.height - base_));
                soil += taken;
                erode(p, taken);
            }
            speed = std::sqrt(std::max(0.0, speed * speed - fall * kGravity));
            water *= 1 - kEvaporation;
            p = next;
        }
    }

private:
    struct Sample {
        double height;  // share of the relief
        glm::dvec2 gradient;
    };

    bool inside(const glm::dvec2& p) const { return p.x >= 0 && p.y >= 0 && p.x < field_.columns - 1 && p.y < field_.rows - 1; }

    Sample sample(const glm::dvec2& p) const {
        const int i = int(p.x), j = int(p.y);
        const double s = p.x - i, t = p.y - j, unit = 1 / relief_;
        const double a = field_.at(i, j) * unit, b = field_.at(i + 1, j) * unit, c = field_.at(i, j + 1) * unit, d = field_.at(i + 1, j + 1) * unit;
        return {(a * (1 - s) + b * s) * (1 - t) + (c * (1 - s) + d * s) * t, {(b - a) * (1 - t) + (d - c) * t, (c - a) * (1 - s) + (d - b) * s}};
    }

    void deposit(const glm::dvec2& p, double amount) {
        const int i = int(p.x), j = int(p.y);
        const double s = p.x - i, t = p.y - j, metres = amount * relief_;
        field_.at(i, j) += float(metres * (1 - s) * (1 - t));
        field_.at(i + 1, j) += float(metres * s * (1 - t));
        field_.at(i, j + 1) += float(metres * (1 - s) * t);
        field_.at(i + 1, j + 1) += float(metres * s * t);
    }

    void erode(const glm::dvec2& p, double amount) {
        const int ci = int(p.x), cj = int(p.y);
        for (const Brush::Tap& tap : brush_.taps) {
            const int i = ci + tap.di, j = cj + tap.dj;
            if (i >= 0 && j >= 0 && i < field_.columns && j < field_.rows) field_.at(i, j) -= float(amount * tap.weight * relief_);
        }
    }

    HeightField& field_;
    double relief_;  // metres
    double base_;    // share of the relief
    Brush brush_;
};

}  // namespace

void erode(HeightField& field, size_t droplets, uint64_t seed) {
    const auto [lo, hi] = std::minmax_element(field.heights.begin(), field.heights.end());
    if (!(*hi > *lo)) return;
    Rain rain(field, *lo, double(*hi) - *lo);
    for (size_t k = 0; k < droplets; ++k) {
        const base::Random random(seed, k, kPurpose);
        rain.drop({double(random.uniform(0)) * (field.columns - 1), double(random.uniform(1)) * (field.rows - 1)});
    }
}

}  // namespace dapple::scenegen
