#include "base/math.h"

#include "base/random.h"

#include <gtest/gtest.h>

namespace dapple::base {
namespace {

TEST(Box, IsEmptyUntilItIsExtended) {
    Box box;
    EXPECT_TRUE(box.empty());
    box.extend(Box{});
    EXPECT_TRUE(box.empty());
    box.extend(glm::vec3(1, 2, 3));
    EXPECT_FALSE(box.empty());
    EXPECT_EQ(box.lo, glm::vec3(1, 2, 3));
    EXPECT_EQ(box.hi, glm::vec3(1, 2, 3));
    box.extend(Box{});  // an empty box adds nothing
    EXPECT_EQ(box.size(), glm::vec3(0));
    EXPECT_TRUE((DBox{{0, 0, 1}, {1, 1, 0}}).empty());
    EXPECT_TRUE((DBox{{0, 0, std::nan("")}, {1, 1, 1}}).empty());
}

TEST(Box, HoldsItsPointsTightly) {
    Random random(1, 2, 3);
    Box box, halves[2];
    glm::vec3 lo(1e9f), hi(-1e9f);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 p(random.next(-5, 9), random.next(-100, -90), random.next(0, 1e-3f));
        box.extend(p);
        halves[i % 2].extend(p);
        for (int k = 0; k < 3; ++k) {
            if (p[k] < lo[k]) lo[k] = p[k];
            if (p[k] > hi[k]) hi[k] = p[k];
        }
    }
    EXPECT_EQ(box.lo, lo);
    EXPECT_EQ(box.hi, hi);
    halves[0].extend(halves[1]);
    EXPECT_EQ(halves[0].lo, lo);
    EXPECT_EQ(halves[0].hi, hi);
}

TEST(Box, CentreSizeAndCorners) {
    const DBox box{{1, 2, 3}, {5, 10, 19}};
    EXPECT_EQ(box.centre(), glm::dvec3(3, 6, 11));
    EXPECT_EQ(box.size(), glm::dvec3(4, 8, 16));
    EXPECT_EQ(box.halfSize(), glm::dvec3(2, 4, 8));
    EXPECT_EQ(box.corner(0), glm::dvec3(1, 2, 3));
    EXPECT_EQ(box.corner(1), glm::dvec3(5, 2, 3));
    EXPECT_EQ(box.corner(2), glm::dvec3(1, 10, 3));
    EXPECT_EQ(box.corner(4), glm::dvec3(1, 2, 19));
    EXPECT_EQ(box.corner(7), glm::dvec3(5, 10, 19));
}

TEST(AllFinite, LooksAtEveryComponent) {
    EXPECT_TRUE(allFinite(glm::dmat4(1)));
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
                glm::dmat4 m(1);
                m[column][row] = bad;
                EXPECT_FALSE(allFinite(m));
            }
    EXPECT_FALSE(allFinite(glm::vec3(0, 0, std::nanf(""))));
}

}  // namespace
}  // namespace dapple::base
