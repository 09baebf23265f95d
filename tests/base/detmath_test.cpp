#include "base/detmath.h"

#include <gtest/gtest.h>

namespace det = dapple::base::det;

TEST(DetMath, sineAndCosineAgreeWithLibm) {
    for (int i = -200'000; i <= 200'000; ++i) {
        const double x = i * 0.0123;
        ASSERT_NEAR(det::sin(x), std::sin(x), 1e-12) << x;
        ASSERT_NEAR(det::cos(x), std::cos(x), 1e-12) << x;
    }
}

TEST(DetMath, exponentialAndLogarithmAgreeWithLibm) {
    for (int i = -40'000; i <= 40'000; ++i) {
        const double x = i * 0.001;
        ASSERT_NEAR(det::exp2(x) / std::exp2(x), 1, 1e-12) << x;
        ASSERT_NEAR(det::log2(std::exp2(x)), x, 1e-12) << x;
        ASSERT_NEAR(det::pow(1.7 + 0.04 * std::abs(x), 0.3 * x) / std::pow(1.7 + 0.04 * std::abs(x), 0.3 * x), 1, 1e-11) << x;
    }
    EXPECT_EQ(det::pow(0, 1.3), 0);
}

TEST(DetMath, arccosineAgreesWithLibm) {
    for (int i = -10'000; i <= 10'000; ++i) ASSERT_NEAR(det::acos(i / 10'000.0), std::acos(i / 10'000.0), 3e-8) << i;
    EXPECT_NEAR(det::acos(1.0000001), 0, 1e-9) << "rounding beyond 1 must not become NaN";
}
