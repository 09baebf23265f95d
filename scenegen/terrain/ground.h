#pragma once

#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

struct GroundOptions {
    double size = 100;      ///< side of the square about the origin, metres
    double undulation = 0;  ///< the height stays within ± this, metres; 0 = a plane at z = 0
    int cells = 32;         ///< per side
    uint64_t seed = 1;
};

/// Gentle hills: a sum of four waves of 30 to 90 m in random directions.
class Ground {
public:
    explicit Ground(const GroundOptions& options);
    double height(double x, double y) const;  ///< metres
    glm::dvec3 normal(double x, double y) const;
    Mesh mesh() const;

private:
    struct Wave {
        glm::dvec2 k;  ///< radians per metre
        double phase, amplitude;
    };
    GroundOptions options_;
    std::vector<Wave> waves_;
};

}  // namespace dapple::scenegen
