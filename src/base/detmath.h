#pragma once

#include <cmath>
#include <cstddef>

/// Elementary functions built from + - * / and sqrt only, which IEEE 754 rounds the same everywhere: libm's
/// differ in the last bit between versions, and a scene must be the same bytes from every compiler. Angles are
/// radians. Absolute error against libm: ≤ 1e-12 for |x| ≤ 1e4 (sin, cos), relative ≤ 1e-12 (exp2, log2, pow),
/// ≤ 3e-8 (acos). floor, ldexp and frexp are exact by definition.
namespace dapple::base::det {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180.0;

struct SinCos {
    double sin, cos;
};

/// x less k quarter turns, by Cody and Waite. Real: double, or a vector of them.
template <class Real>
inline Real lessQuadrants(Real x, Real k) {
    return (x - k * 1.57079632673412561417) - k * 6.07710050650619224932e-11;
}

/// Taylor polynomials for |r| ≤ π/4.
template <class Real>
inline void sinCosNearZero(Real r, Real& s, Real& c) {
    const Real q = r * r;
    s = r * (1.0 + q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q * (1.0 / 362880 + q * (-1.0 / 39916800 + q / 6227020800.0))))));
    c = 1.0 + q * (-0.5 + q * (1.0 / 24 + q * (-1.0 / 720 + q * (1.0 / 40320 + q * (-1.0 / 3628800 + q * (1.0 / 479001600 - q / 87178291200.0))))));
}

inline SinCos sinCos(double x) {
    // Floor by conversion: without SSE4.1, std::floor is a call.
    const double y = x * (2.0 / kPi) + 0.5;
    const long long whole = static_cast<long long>(y), quadrant = whole - (static_cast<double>(whole) > y);
    double s, c;
    sinCosNearZero(lessQuadrants(x, static_cast<double>(quadrant)), s, c);
    // No branches: the quadrant of a random angle cannot be predicted. Products with ±1 are exact.
    const double odd[2] = {s, c}, even[2] = {c, s}, sign[2] = {1, -1};
    return {sign[(quadrant >> 1) & 1] * odd[quadrant & 1], sign[((quadrant + 1) >> 1) & 1] * even[quadrant & 1]};
}
inline double sin(double x) { return sinCos(x).sin; }
inline double cos(double x) { return sinCos(x).cos; }

/// Taylor polynomials of e to each of at most 8 y, |y| ≤ ln 2 / 2, in their place: of quotients that each wait for the one before, several go abreast.
template <class Real>
inline void expNearZero(Real* y, std::size_t count) {
    constexpr std::size_t kMost = 8;
    Real sum[kMost];
    for (std::size_t k = 0; k < count; ++k) sum[k] = 1.0 + y[k] * 0.0;
    for (int i = 14; i >= 1; --i)
        for (std::size_t k = 0; k < count; ++k) sum[k] = 1.0 + sum[k] * y[k] / static_cast<double>(i);
    for (std::size_t k = 0; k < count; ++k) y[k] = sum[k];
}

inline double exp2(double x) {
    const double k = std::floor(x + 0.5);
    double y = (x - k) * 0.69314718055994530942;
    expNearZero(&y, 1);
    return std::ldexp(y, static_cast<int>(k));
}

/// log2 of m, √½ ≤ m < √2, and of 2 to the exponent.
template <class Real>
inline Real log2OfParts(Real m, Real exponent) {
    const Real s = (m - 1.0) / (m + 1.0), q = s * s;
    constexpr double kInverse[] = {1.0 / 19, 1.0 / 17, 1.0 / 15, 1.0 / 13, 1.0 / 11, 1.0 / 9, 1.0 / 7, 1.0 / 5, 1.0 / 3, 1.0};
    Real sum = q * 0.0;
    for (const double inverse : kInverse) sum = sum * q + inverse;
    return exponent + 2.0 * s * sum * 1.44269504088896340736;
}

/// x > 0 as m and an exponent for log2OfParts.
inline double partsForLog2(double x, int& exponent) {
    const double m = std::frexp(x, &exponent);
    if (m >= 0.70710678118654752440) return m;
    --exponent;
    return 2 * m;
}

/// x > 0.
inline double log2(double x) {
    int exponent = 0;
    const double m = partsForLog2(x, exponent);
    return log2OfParts(m, static_cast<double>(exponent));
}

/// x ≥ 0; 0 for x = 0 whatever y is.
inline double pow(double x, double y) { return x > 0 ? exp2(y * log2(x)) : 0; }

/// Abramowitz & Stegun 4.4.46; x is clamped to [-1, 1].
inline double acos(double x) {
    const double a = std::abs(x) < 1 ? std::abs(x) : 1;
    const double p = 1.5707963050 + a * (-0.2145988016 + a * (0.0889789874 + a * (-0.0501743046 + a * (0.0308918810 + a * (-0.0170881256 + a * (0.0066700901 - a * 0.0012624911))))));
    const double angle = std::sqrt(1 - a) * p;
    return x < 0 ? kPi - angle : angle;
}

}  // namespace dapple::base::det
