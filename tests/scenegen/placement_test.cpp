#include "base/error.h"
#include "base/random.h"
#include "scenegen/placement/path.h"
#include "scenegen/placement/poisson.h"
#include "scenegen/terrain/ground.h"

#include <gtest/gtest.h>

using namespace dapple::scenegen;

TEST(Poisson, disksKeepTheirDistanceWithinTheSquare) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        dapple::base::Random random(seed, 0, 0);
        std::vector<double> radii;
        for (int i = 0; i < 300; ++i) radii.push_back(random.next(0.5f, 2.0f));
        const std::vector<glm::dvec2> p = poissonDisks(radii, 60, seed, [](const glm::dvec2& q) { return std::abs(q.x) > 3; });
        ASSERT_EQ(p.size(), radii.size());
        for (size_t i = 0; i < p.size(); ++i) {
            EXPECT_LE(std::max(std::abs(p[i].x), std::abs(p[i].y)), 60);
            EXPECT_GT(std::abs(p[i].x), 3) << "allowed() was ignored";
            for (size_t j = 0; j < i; ++j) EXPECT_GE(glm::distance(p[i], p[j]), radii[i] + radii[j]);
        }
    }
}

TEST(Poisson, crowdedDisksMoveCloserTogetherAndAtLastAreRefused) {
    const std::vector<double> crowded(400, 1.0), hopeless(400, 10.0);
    const auto anywhere = [](const glm::dvec2&) { return true; };
    const std::vector<glm::dvec2> p = poissonDisks(crowded, 16, 1, anywhere);
    for (size_t i = 0; i < p.size(); ++i)
        for (size_t j = 0; j < i; ++j) EXPECT_GE(glm::distance(p[i], p[j]), 0.4);
    EXPECT_THROW(poissonDisks(hopeless, 16, 1, anywhere), dapple::base::UsageError);
    EXPECT_THROW(poissonDisks(crowded, 16, 1, [](const glm::dvec2&) { return false; }), dapple::base::UsageError);
}

TEST(Path, distanceIsALowerBound) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
        const Path path(100, seed);
        for (double x = -50; x <= 50; x += 5)
            for (double y = -50; y <= 50; y += 5) {
                double nearest = 1e9;
                for (double t = -80; t <= 80; t += 0.05) nearest = std::min(nearest, glm::distance(glm::dvec2(x, y), glm::dvec2(path.x(t), t)));
                EXPECT_LE(path.distance({x, y}), nearest + 0.05);
            }
    }
}

TEST(Ground, normalIsThatOfTheHeights) {
    const Ground ground({.size = 200, .undulation = 2, .cells = 40, .seed = 9});
    for (double x = -90; x <= 90; x += 17)
        for (double y = -90; y <= 90; y += 13) {
            const double h = 1e-4;
            const glm::dvec3 expected = glm::normalize(glm::dvec3((ground.height(x - h, y) - ground.height(x + h, y)) / (2 * h),
                                                                  (ground.height(x, y - h) - ground.height(x, y + h)) / (2 * h), 1));
            EXPECT_LT(glm::distance(ground.normal(x, y), expected), 1e-7);
            EXPECT_LE(std::abs(ground.height(x, y)), 2);
        }
}

TEST(Ground, meshCoversTheSquareOnceAndFacesUp) {
    const Mesh mesh = Ground({.size = 50, .undulation = 0, .cells = 29, .seed = 1}).mesh();
    double area = 0;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]], c = mesh.positions[mesh.indices[i + 2]];
        const double z = glm::cross(b - a, c - a).z;
        EXPECT_GT(z, 0);
        area += z / 2;
    }
    EXPECT_NEAR(area, 2500, 1e-2);
}
