#include "shadow/instanced/volume.h"

#include "base/math.h"
#include "base/random.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>

namespace dapple::shadow {
namespace {

/// World corner of an entry, for a box [−h, h]³ whose axes are already mirrored (all light components ≥ 0).
glm::dvec3 place(uint32_t entry, const glm::dvec3& half, const glm::dvec3& light, double extrusion) {
    glm::dvec3 p = half * (glm::dvec3(entry & 1, entry >> 1 & 1, entry >> 2 & 1) * 2.0 - 1.0);
    return entry & 8 ? p + light * extrusion : p;
}

TEST(BoxShadowVolume, IsClosedAndOriented) {
    const auto corners = boxShadowVolume();
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (size_t t = 0; t < corners.size(); t += 3)
        for (size_t e = 0; e < 3; ++e) ++edges[{corners[t + e], corners[t + (e + 1) % 3]}];
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << edge.first << "-" << edge.second;
        EXPECT_TRUE(edges.contains({edge.second, edge.first})) << edge.first << "-" << edge.second;
    }
}

// Oracle: a point is in the volume iff the segment from it back along the light, of the extrusion's length, meets the
// box, by brute-force stepping; the polyhedron is convex, so inside means behind all of its triangles.
TEST(BoxShadowVolume, HoldsExactlyTheSweptBox) {
    base::Random random(7, 0, 0);
    for (int trial = 0; trial < 40; ++trial) {
        const glm::dvec3 half(random.next(0.2f, 2), random.next(0.2f, 2), random.next(0.2f, 2));
        glm::dvec3 light(random.next(), random.next(), random.next());
        if (trial % 5 == 0) light[trial % 3] = 0;
        if (trial == 1) light = {0, 0, 1};
        light = glm::normalize(light);
        const double extrusion = 5;
        const auto corners = boxShadowVolume();
        for (int i = 0; i < 400; ++i) {
            const glm::dvec3 p(random.next(-4, 7), random.next(-4, 7), random.next(-4, 7));
            double outside = -1e9;
            for (size_t t = 0; t < corners.size(); t += 3) {
                const glm::dvec3 a = place(corners[t], half, light, extrusion), b = place(corners[t + 1], half, light, extrusion),
                                 c = place(corners[t + 2], half, light, extrusion);
                const glm::dvec3 n = glm::cross(b - a, c - a);
                if (glm::length(n) > 1e-9) outside = std::max(outside, glm::dot(glm::normalize(n), p - a));
            }
            double distance = 1e9;  // signed Chebyshev-like distance of the swept point to the box
            for (double s = 0; s <= extrusion; s += 0.002) {
                const glm::dvec3 q = glm::abs(p - light * s) - half;
                distance = std::min(distance, std::max({q.x, q.y, q.z}));
            }
            if (std::abs(distance) < 0.01 || std::abs(outside) < 0.01) continue;  // the steps cannot tell
            EXPECT_EQ(outside < 0, distance < 0) << trial << " " << p.x << " " << p.y << " " << p.z;
        }
    }
}

TEST(SampleRotation, BracketsTheAngle) {
    base::Random random(3, 0, 0);
    for (const int count : {1, 2, 4, 12, 36, 72})
        for (int i = 0; i < 2000; ++i) {
            const double yaw = random.next(-30, 30);
            const RotationSample s = sampleRotation(yaw, count);
            ASSERT_LT(s.first, uint32_t(count));
            ASSERT_GE(s.weight, 0);
            ASSERT_LT(s.weight, 1);
            const double rebuilt = (s.first + double(s.weight)) * 2 * std::numbers::pi / count;
            EXPECT_NEAR(std::cos(rebuilt - yaw), 1, 1e-9);
        }
}

TEST(SampleRotation, OnAMapsAngleThatMapAlone) {
    for (const int count : {4, 12, 36, 72})
        for (int k = -2 * count; k <= 2 * count; ++k) {
            const float yaw = float(2 * std::numbers::pi * k / count);  // as an instance stores it
            const RotationSample s = sampleRotation(double(yaw), count);
            EXPECT_EQ(int(s.first), (k % count + count) % count) << count << " " << k;
            EXPECT_EQ(s.weight, 0) << count << " " << k;
        }
}

TEST(SampleRotation, WrapsAtTheEndsOfATurn) {
    constexpr double turn = 2 * std::numbers::pi;
    for (const double yaw : {0.0, -0.0, std::nextafter(turn, 0.0), -std::numeric_limits<double>::denorm_min(), turn, 7 * turn}) {
        const RotationSample s = sampleRotation(yaw, 12);
        EXPECT_EQ(s.first, 0u) << yaw;
        EXPECT_EQ(s.weight, 0) << yaw;
    }
}

}  // namespace
}  // namespace dapple::shadow
