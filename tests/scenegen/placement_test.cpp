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
        const std::vector<glm::dvec2> p = poissonDisks(radii, 60, seed, Crowding::shrink, [](size_t, const glm::dvec2& q) { return std::abs(q.x) > 3; }).points;
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
    const auto anywhere = [](size_t, const glm::dvec2&) { return true; };
    const std::vector<glm::dvec2> p = poissonDisks(crowded, 16, 1, Crowding::shrink, anywhere).points;
    for (size_t i = 0; i < p.size(); ++i)
        for (size_t j = 0; j < i; ++j) EXPECT_GE(glm::distance(p[i], p[j]), 0.4);
    EXPECT_THROW(poissonDisks(hopeless, 16, 1, Crowding::shrink, anywhere), dapple::base::UsageError);
    EXPECT_THROW(poissonDisks(crowded, 16, 1, Crowding::shrink, [](size_t, const glm::dvec2&) { return false; }), dapple::base::UsageError);
}

// Oracle: brute force over all pairs. A disk dies if and only if a larger one that stands is within reach of its place.
TEST(Poisson, thinnedDisksDieOnlyOfALargerNeighbour) {
    dapple::base::Random random(3, 0, 0);
    std::vector<double> radii;
    for (int i = 0; i < 600; ++i) radii.push_back(random.next(0.5f, 2.5f));
    const auto anywhere = [](size_t, const glm::dvec2&) { return true; };
    const Disks thinned = poissonDisks(radii, 30, 7, Crowding::thin, anywhere);
    EXPECT_LT(thinned.kept.size(), radii.size());
    EXPECT_GT(thinned.kept.size(), 100u);
    EXPECT_TRUE(std::is_sorted(thinned.kept.begin(), thinned.kept.end()));
    for (size_t i = 0; i < thinned.kept.size(); ++i)
        for (size_t j = 0; j < i; ++j) EXPECT_GE(glm::distance(thinned.points[i], thinned.points[j]), radii[thinned.kept[i]] + radii[thinned.kept[j]]);
    for (uint32_t i = 0; i < radii.size(); ++i) {
        if (std::binary_search(thinned.kept.begin(), thinned.kept.end(), i)) continue;
        std::vector<double> nowhereToHide(radii);  // alone, it stands where it was sown
        for (uint32_t j = 0; j < radii.size(); ++j)
            if (j != i) nowhereToHide[j] = 0;
        const Disks alone = poissonDisks(nowhereToHide, 30, 7, Crowding::thin, [i](size_t k, const glm::dvec2&) { return k == i; });
        ASSERT_EQ(alone.kept, std::vector<uint32_t>{i});
        bool killed = false;
        for (size_t k = 0; k < thinned.kept.size(); ++k)
            killed |= radii[thinned.kept[k]] >= radii[i] && glm::distance(thinned.points[k], alone.points[0]) < radii[i] + radii[thinned.kept[k]];
        EXPECT_TRUE(killed) << i;
    }
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
