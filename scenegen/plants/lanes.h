#pragma once

#include "base/detmath.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

/// Two or four numbers in one register, which every 64-bit processor has. Each lane has the bits that the same expression has
/// in scalars: the order of operations is that of glm's functions of the same name.
namespace dapple::scenegen {

using Pair = double __attribute__((vector_size(16)));

inline Pair loadPair(const double* from) {
    Pair p;
    std::memcpy(&p, from, sizeof(p));
    return p;
}
inline void storePair(double* to, Pair p) { std::memcpy(to, &p, sizeof(p)); }
inline Pair squareRoot(Pair p) { return Pair{std::sqrt(p[0]), std::sqrt(p[1])}; }

/// Four lanes, or a point or direction whose last element nobody looks at.
using Float4 = float __attribute__((vector_size(16)));

inline Float4 float4(const glm::dvec3& v) { return Float4{float(v.x), float(v.y), float(v.z), 0}; }
inline void store3(glm::vec3& to, Float4 v) {
    const auto halves = reinterpret_cast<Pair>(v);
    std::memcpy(&to.x, &halves, sizeof(double));
    to.z = v[2];
}

struct Pair3 {
    Pair x, y, z;
};
inline Pair3 operator+(const Pair3& a, const Pair3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Pair3 operator-(const Pair3& a, const Pair3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Pair3 operator*(const Pair3& a, Pair s) { return {a.x * s, a.y * s, a.z * s}; }
inline Pair dot(const Pair3& a, const Pair3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Pair3 cross(const Pair3& a, const Pair3& b) { return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y}; }
inline Pair3 normalize(const Pair3& a) { return a * (1.0 / squareRoot(dot(a, a))); }

struct PairSinCos {
    Pair sin, cos;
};

/// det::sinCos in both lanes, for |x| ≤ 1e9.
inline PairSinCos sinCos(Pair x) {
    using Bits = int64_t __attribute__((vector_size(16)));
    // Adding and taking away 1.5 · 2⁵² rounds to a whole number, whose lowest bits then are those of the sum.
    constexpr double kWhole = 0x1.8p52;
    const Pair y = x * (2.0 / base::det::kPi) + 0.5;
    Pair k = (y + kWhole) - kWhole;
    k -= reinterpret_cast<Pair>((k > y) & reinterpret_cast<Bits>(Pair{1, 1}));
    Pair s, c;
    base::det::sinCosNearZero(base::det::lessQuadrants(x, k), s, c);
    const Bits quadrant = reinterpret_cast<Bits>(k + kWhole), odd = -(quadrant & 1), bs = reinterpret_cast<Bits>(s), bc = reinterpret_cast<Bits>(c);
    const auto signOf = [](Bits b) { return (b & 2) << 62; };
    return {reinterpret_cast<Pair>(((bc & odd) | (bs & ~odd)) ^ signOf(quadrant)),
            reinterpret_cast<Pair>(((bs & odd) | (bc & ~odd)) ^ signOf(quadrant + 1))};
}

/// x to the y as det::pow gives it, for each x in place. A power is one long chain of quotients: those of sixteen numbers, in eight pairs, go abreast.
inline void powers(std::span<double> x, double y) {
    constexpr size_t kAbreast = 16;
    for (size_t begin = 0; begin < x.size(); begin += kAbreast) {
        const size_t n = std::min(kAbreast, x.size() - begin), pairs = (n + 1) / 2;
        double* const from = x.data() + begin;
        double m[kAbreast], scale[kAbreast];
        m[2 * pairs - 1] = 1, scale[2 * pairs - 1] = 0;
        for (size_t i = 0; i < n; ++i) {
            int exponent = 0;
            m[i] = from[i] > 0 ? base::det::partsForLog2(from[i], exponent) : 1;
            scale[i] = exponent;
        }
        Pair power[kAbreast / 2], whole[kAbreast / 2];
        for (size_t i = 0; i < pairs; ++i) {
            const Pair product = y * base::det::log2OfParts(loadPair(m + 2 * i), loadPair(scale + 2 * i));
            whole[i] = Pair{std::floor(product[0] + 0.5), std::floor(product[1] + 0.5)};
            power[i] = (product - whole[i]) * 0.69314718055994530942;
        }
        base::det::expNearZero(power, pairs);
        for (size_t i = 0; i < n; ++i) from[i] = from[i] > 0 ? std::ldexp(power[i / 2][i % 2], int(whole[i / 2][i % 2])) : 0;
    }
}

}  // namespace dapple::scenegen
