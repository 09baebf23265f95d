#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include <cmath>
#include <limits>

namespace dapple::base {

/// Axis-aligned box; empty (lo > hi) until it is extended. Space and unit are its user's.
template <class Vec>
struct BasicBox {
    using Scalar = typename Vec::value_type;
    Vec lo{std::numeric_limits<Scalar>::max()};
    Vec hi{std::numeric_limits<Scalar>::lowest()};

    bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
    void extend(const Vec& p) {
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
    }
    void extend(const BasicBox& b) {
        if (b.empty()) return;
        extend(b.lo);
        extend(b.hi);
    }
    Vec centre() const { return (lo + hi) * Scalar(0.5); }
    Vec halfSize() const { return (hi - lo) * Scalar(0.5); }
    Vec size() const { return hi - lo; }
    /// Corner i in 0…7: bit 0 picks x, bit 1 y, bit 2 z (0 = lo, 1 = hi).
    Vec corner(int i) const { return {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z}; }
};
using Box = BasicBox<glm::vec3>;
using DBox = BasicBox<glm::dvec3>;

template <class M>
bool allFinite(const M& m) {
    const auto* p = glm::value_ptr(m);
    for (size_t i = 0; i < sizeof(M) / sizeof(*p); ++i)
        if (!std::isfinite(p[i])) return false;
    return true;
}

}  // namespace dapple::base
