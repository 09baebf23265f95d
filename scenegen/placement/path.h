#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace dapple::scenegen {

/// A path that winds from the south edge of a square to its north edge: x as a function of y, metres.
class Path {
public:
    Path(double groundSize, uint64_t seed);
    double x(double y) const;
    /// Unit direction of travel, northwards.
    glm::dvec2 direction(double y) const;
    double distance(const glm::dvec2& p) const;  ///< lower bound of the distance to the path, metres

private:
    double slope(double y) const;
    double size_, phase_, side_, maxSlope_;
};

}  // namespace dapple::scenegen
