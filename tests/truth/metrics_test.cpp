#include "truth/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace dapple::truth {
namespace {

/// 'L' lit, 'S' shadowed, 'A' ambiguous, '.' excluded.
Reference image(const std::vector<std::string>& rows) {
    Reference g{int(rows[0].size()), int(rows.size()), {}};
    for (const std::string& row : rows)
        for (const char c : row)
            g.label.push_back(c == 'L' ? Label::lit : c == 'S' ? Label::shadowed : c == 'A' ? Label::ambiguous : Label::excluded);
    return g;
}

std::vector<float> visibility(const std::vector<std::string>& rows) {
    std::vector<float> v;
    for (const std::string& row : rows)
        for (const char c : row) v.push_back(c == 'S' ? 0.0f : 1.0f);
    return v;
}

TEST(DistanceTransform, EqualsBruteForceOnRandomMasks) {
    std::mt19937 random(1);
    for (int trial = 0; trial < 300; ++trial) {
        const int w = 1 + int(random() % 24), h = 1 + int(random() % 24);
        const unsigned density = 1 + random() % 60;
        std::vector<uint8_t> mask(size_t(w) * size_t(h));
        for (uint8_t& m : mask) m = random() % density == 0;
        const std::vector<float> d = distanceTransform(mask, w, h);
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) {
                int best = std::numeric_limits<int>::max();
                for (int b = 0; b < h; ++b)
                    for (int a = 0; a < w; ++a)
                        if (mask[size_t(b * w + a)]) best = std::min(best, (a - x) * (a - x) + (b - y) * (b - y));
                const float expected = best == std::numeric_limits<int>::max() ? std::numeric_limits<float>::infinity() : float(std::sqrt(double(best)));
                ASSERT_EQ(d[size_t(y * w + x)], expected) << w << "x" << h << " at " << x << "," << y;
            }
    }
}

TEST(DistanceTransform, IsExactOnALongRow) {
    std::vector<uint8_t> mask(4096 * 2, 0);
    mask[4096 + 17] = 1;
    const std::vector<float> d = distanceTransform(mask, 4096, 2);
    EXPECT_EQ(d[4095], float(std::sqrt(4078.0 * 4078.0 + 1)));
    EXPECT_EQ(d[4096 + 4095], 4078.0f);
}

TEST(Metrics, PerfectImageHasNoError) {
    const std::vector<std::string> rows = {"LLSS", "LLSS", "LLLS"};
    const ErrorMetrics m = measureError(image(rows), visibility(rows));
    EXPECT_EQ(m.error, 0);
    EXPECT_EQ(m.meanAbsolute, 0);
    EXPECT_EQ(m.valid, 1);
    EXPECT_DOUBLE_EQ(m.shadowed, 5.0 / 12);
    ASSERT_TRUE(m.edgeMean && m.edgeP95 && m.edgeMax);
    EXPECT_EQ(*m.edgeMean, 0);
    EXPECT_EQ(*m.edgeMax, 0);
}

TEST(Metrics, EdgeMovedByThreePixelsIsKnown) {
    // G's boundary: columns 3 and 4. V's: columns 6 and 7. False light in columns 4, 5 (boundary: 0 and
    // 1 px off), 6 (2 px off).
    const Reference g = image({"LLLLSSSSSS", "LLLLSSSSSS"});
    const ErrorMetrics m = measureError(g, visibility({"LLLLLLLSSS", "LLLLLLLSSS"}));
    EXPECT_DOUBLE_EQ(m.error, 6.0 / 20);
    EXPECT_DOUBLE_EQ(m.falseLight, 6.0 / 20);
    EXPECT_EQ(m.falseShadow, 0);
    EXPECT_DOUBLE_EQ(m.falseLightBoundary, 6.0 / 20);
    EXPECT_EQ(m.falseLightInterior, 0);
    // Distances per row: V to G: 2, 3; G to V: 3, 2.
    EXPECT_DOUBLE_EQ(*m.edgeMean, 2.5);
    EXPECT_DOUBLE_EQ(*m.edgeP95, 3);
    EXPECT_DOUBLE_EQ(*m.edgeMax, 3);
}

TEST(Metrics, AcneAndLeaksAreInterior) {
    // Boundary of G: columns 4 and 5. Acne at column 0 (4 px off) and 2 (exactly 2 px off: boundary);
    // leak at column 9 (4 px off).
    const Reference g = image({"LLLLLSSSSS"});
    const ErrorMetrics m = measureError(g, visibility({"SLSLLSSSSL"}));
    EXPECT_DOUBLE_EQ(m.falseShadowInterior, 0.1);
    EXPECT_DOUBLE_EQ(m.falseShadowBoundary, 0.1);
    EXPECT_DOUBLE_EQ(m.falseShadow, 0.2);
    EXPECT_DOUBLE_EQ(m.falseLightInterior, 0.1);
    EXPECT_EQ(m.falseLightBoundary, 0);
    EXPECT_DOUBLE_EQ(m.error, 0.3);
}

TEST(Metrics, PercentileIsNearestRank) {
    // V equals G but for one lit pixel far from G's edge: 3 of 163 distances, beyond the 95th percentile.
    std::vector<std::string> g(40, "LSSSSSSSSSSSSSSSSSSS"), v = g;
    v[39] = "LSSSSSSSSSSSSSSSSSSL";
    const ErrorMetrics m = measureError(image(g), visibility(v));
    EXPECT_EQ(*m.edgeP95, 0);
    EXPECT_EQ(*m.edgeMax, 18);
    // V adds (18,39), (19,39) by the row and (19,38) by the column: distances 17, 18 and 18.
    EXPECT_DOUBLE_EQ(*m.edgeMean, (17.0 + 18 + 18) / (80 + 83));
}

TEST(Metrics, ExcludedAndAmbiguousPixelsAreNeitherErrorNorEdge) {
    const Reference g = image({"LL.SS", "LLASS", "LL.SS"});
    const ErrorMetrics right = measureError(g, visibility({"LLLSS", "LLSSS", "LLSSS"}));
    EXPECT_EQ(right.error, 0);
    EXPECT_DOUBLE_EQ(right.valid, 12.0 / 15);
    EXPECT_DOUBLE_EQ(right.ambiguous, 1.0 / 13);
    EXPECT_FALSE(right.edgeMean || right.edgeP95 || right.edgeMax);  // the gap hides the edge
    const ErrorMetrics wrong = measureError(g, visibility({"LLLSS", "LLSSL", "LLSSS"}));
    EXPECT_DOUBLE_EQ(wrong.error, 1.0 / 12);
    EXPECT_DOUBLE_EQ(wrong.falseLightInterior, 1.0 / 12);  // G has no boundary at all
    EXPECT_FALSE(wrong.edgeMean);
}

TEST(Metrics, MissingShadowHasAreaButNoDistance) {
    const Reference g = image({"LLLL", "LSSL", "LLLL"});
    const ErrorMetrics m = measureError(g, std::vector<float>(12, 1.0f));
    EXPECT_DOUBLE_EQ(m.falseLight, 2.0 / 12);
    EXPECT_FALSE(m.edgeMean || m.edgeP95 || m.edgeMax);
}

TEST(Metrics, ThresholdIsOneHalfAndMeanAbsoluteIsNot) {
    const Reference g = image({"LSLS"});
    const ErrorMetrics m = measureError(g, std::vector<float>{0.5f, 0.49f, 0.25f, 1.0f});
    EXPECT_DOUBLE_EQ(m.falseShadow, 0.25);
    EXPECT_DOUBLE_EQ(m.falseLight, 0.25);
    EXPECT_NEAR(m.meanAbsolute, (0.5 + 0.49 + 0.75 + 1.0) / 4, 1e-7);
}

TEST(Metrics, NotANumberIsWhollyWrongAndStaysFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const ErrorMetrics m = measureError(image({"LLSS"}), std::vector<float>(4, nan));
    EXPECT_DOUBLE_EQ(m.falseShadow, 0.5);
    EXPECT_DOUBLE_EQ(m.meanAbsolute, 1);
}

TEST(Metrics, EmptyOmegaGivesZeros) {
    for (const Reference& g : {image({"...", "..."}), Reference{}}) {
        const ErrorMetrics m = measureError(g, std::vector<float>(g.label.size(), 0.0f));
        for (const double value : {m.error, m.falseShadow, m.falseLight, m.falseShadowBoundary, m.falseShadowInterior, m.falseLightBoundary,
                                   m.falseLightInterior, m.meanAbsolute, m.valid, m.ambiguous, m.shadowed, halfPixelSensitivity(g, std::span(&g, 1))})
            EXPECT_EQ(value, 0);
        EXPECT_FALSE(m.edgeMean);
    }
    EXPECT_EQ(measureError(image({"AA"}), std::vector<float>(2, 0.0f)).ambiguous, 1);
}

TEST(Metrics, RandomImagesAgreeWithDirectCounting) {
    std::mt19937 random(3);
    for (int trial = 0; trial < 100; ++trial) {
        const int w = 3 + int(random() % 14), h = 3 + int(random() % 14);
        Reference g{w, h, {}};
        std::vector<float> v;
        for (int i = 0; i < w * h; ++i) {
            const unsigned r = random() % 12;
            g.label.push_back(r == 0 ? Label::excluded : r == 1 ? Label::ambiguous : i % w < w / 2 ? Label::lit : Label::shadowed);
            v.push_back(i % w + int(random() % 3) < w / 2 ? 1.0f : 0.0f);
        }
        const auto valid = [&](int x, int y) {
            return x >= 0 && y >= 0 && x < w && y < h && (g.label[size_t(y * w + x)] == Label::lit || g.label[size_t(y * w + x)] == Label::shadowed);
        };
        const auto edgesOf = [&](auto dark) {
            std::vector<std::pair<int, int>> edges;
            for (int y = 0; y < h; ++y)
                for (int x = 0; x < w; ++x)
                    for (const auto& [a, b] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
                        if (valid(x, y) && valid(x + a, y + b) && dark(x, y) != dark(x + a, y + b)) {
                            edges.emplace_back(x, y);
                            break;
                        }
            return edges;
        };
        const auto nearest = [](const std::vector<std::pair<int, int>>& set, int x, int y) {
            double best = std::numeric_limits<double>::infinity();
            for (const auto& [a, b] : set) best = std::min(best, std::hypot(a - x, b - y));
            return best;
        };
        const auto darkG = [&](int x, int y) { return g.label[size_t(y * w + x)] == Label::shadowed; };
        const auto darkV = [&](int x, int y) { return v[size_t(y * w + x)] < 0.5f; };
        const auto edgesG = edgesOf(darkG), edgesV = edgesOf(darkV);
        double omega = 0, boundary = 0, interior = 0;
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) {
                if (!valid(x, y)) continue;
                ++omega;
                if (darkG(x, y) != darkV(x, y)) ++(nearest(edgesG, x, y) <= 2 ? boundary : interior);
            }
        const ErrorMetrics m = measureError(g, v);
        EXPECT_NEAR(m.falseShadowBoundary + m.falseLightBoundary, boundary / omega, 1e-12);
        EXPECT_NEAR(m.falseShadowInterior + m.falseLightInterior, interior / omega, 1e-12);
        EXPECT_NEAR(m.error, (boundary + interior) / omega, 1e-12);
        ASSERT_EQ(m.edgeMean.has_value(), !edgesG.empty() && !edgesV.empty());
        if (!m.edgeMean) continue;
        double sum = 0, most = 0;
        for (const auto& [x, y] : edgesV) sum += nearest(edgesG, x, y), most = std::max(most, nearest(edgesG, x, y));
        for (const auto& [x, y] : edgesG) sum += nearest(edgesV, x, y), most = std::max(most, nearest(edgesV, x, y));
        EXPECT_NEAR(*m.edgeMean, sum / double(edgesG.size() + edgesV.size()), 1e-5);
        EXPECT_NEAR(*m.edgeMax, most, 1e-5);
        EXPECT_LE(*m.edgeP95, *m.edgeMax);
    }
}

TEST(HalfPixelSensitivity, IsTheMeanErrorOfTheShiftedTruthsWhereBothAreValid) {
    const Reference here = image({"LLSSA.", "LLSSLL"});
    // 10 pixels of the first are valid beside one of its own, of which 2 differ; 9 of the second, of which none does.
    const std::vector<Reference> shifted{image({"LSSSLL", "LSSSLL"}), image({"LLSSL.", "LLSSL."})};
    EXPECT_DOUBLE_EQ(halfPixelSensitivity(here, std::span(shifted).first(1)), 2.0 / 10);
    EXPECT_DOUBLE_EQ(halfPixelSensitivity(here, std::span(shifted).last(1)), 0);
    EXPECT_DOUBLE_EQ(halfPixelSensitivity(here, shifted), 0.1);
    EXPECT_EQ(halfPixelSensitivity(here, {}), 0);
    const Reference nothing = image({"......", "AAAAAA"});
    EXPECT_EQ(halfPixelSensitivity(nothing, std::span(&here, 1)), 0);
}

TEST(Flips, CountOnlyWhatIsValidInBothFrames) {
    const Reference before = image({"LLSSA.", "LLSS.A"}), now = image({"LSSLLL", "ALS.SS"});
    const std::vector<float> v0{1, 1, 0, 0.5f, 0, 0, 1, 0, 0, 0, 0, 0}, v1{1, 0, 0.25f, 0.5f, 1, 1, 0, 1, 0, 1, 1, 1};
    // Both valid: the first four pixels of the first row, the second and third of the second.
    const Flips flips = measureFlips(before, now, v0, v1);
    EXPECT_DOUBLE_EQ(flips.image, (1 + 0.25 + 1) / 6);
    EXPECT_DOUBLE_EQ(flips.reference, 2.0 / 6);
    EXPECT_DOUBLE_EQ(flips.excess(), 0.25 / 6);
    EXPECT_EQ(measureFlips(image({"A."}), image({"LL"}), std::vector<float>{0, 0}, std::vector<float>{1, 1}).image, 0);
}

TEST(Flips, CompareWhatAMovingCameraSawOfTheSameSurface) {
    const Reference before = image({"LSLL"}), now = image({"SLLS"});
    const std::vector<int32_t> same{1, 2, -1, 3};
    const Flips flips = measureFlips(before, now, std::vector<float>{0, 0.25f, 1, 1}, std::vector<float>{0, 0, 0, 1}, same);
    EXPECT_DOUBLE_EQ(flips.image, (0.25 + 1 + 0) / 3);
    EXPECT_DOUBLE_EQ(flips.reference, 1.0 / 3);
}

/// What an eye sees that looks along +y, half a right angle to each side: a floor 2 m below it, and a wall at y = `wall` where x < `end`.
Receivers yard(int size, const glm::dvec3& eye, double wall, double end) {
    const auto n = size_t(size) * size_t(size);
    Receivers r{size, size, std::vector<glm::vec3>(n), std::vector<glm::vec3>(n), std::vector<uint8_t>(n)};
    for (int row = 0; row < size; ++row)
        for (int col = 0; col < size; ++col) {
            const glm::dvec3 ray(2 * (col + 0.5) / size - 1, 1, 1 - 2 * (row + 0.5) / size);
            const auto i = size_t(row * size + col);
            const double toWall = wall - eye.y, toFloor = ray.z < 0 ? (-2 - eye.z) / ray.z : 1e9;
            const bool hitsWall = eye.x + toWall * ray.x < end && toWall < toFloor;
            if (!hitsWall && toFloor > 500) continue;
            r.present[i] = 1;
            r.position[i] = ray * (hitsWall ? toWall : toFloor);
            r.normal[i] = hitsWall ? glm::vec3(0, -1, 0) : glm::vec3(0, 0, 1);
        }
    return r;
}

TEST(Correspondence, FindsTheSameSurfaceOrNothing) {
    constexpr int kSize = 64;
    const glm::dmat4 clip = glm::transpose(glm::dmat4(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 0, 1, 0), glm::dvec4(0, 0, 0, 0.1), glm::dvec4(0, 1, 0, 0)));
    const glm::dvec3 moved(0.7, 0.4, 0.05);
    const Receivers before = yard(kSize, {0, 0, 0}, 20, 1), now = yard(kSize, moved, 20, 1);
    const std::vector<int32_t> same = correspondence(before, clip, now, moved);
    int found = 0, floor = 0, hidden = 0;
    for (size_t i = 0; i < same.size(); ++i) {
        if (!now.present[i]) {
            EXPECT_EQ(same[i], -1);
            continue;
        }
        const glm::dvec3 p = glm::dvec3(now.position[i]) + moved;
        // The point that was seen lies half a pixel away at most, as the eye that was saw both.
        const glm::dvec2 seen = kSize / 2.0 * glm::dvec2(p.x / p.y, p.z / p.y);
        if (same[i] < 0) {
            const bool inPicture = std::max(std::abs(seen.x), std::abs(seen.y)) < kSize / 2.0;
            hidden += inPicture;
            continue;
        }
        ++found;
        const glm::dvec3 q(before.position[size_t(same[i])]);
        EXPECT_EQ(now.normal[i], before.normal[size_t(same[i])]);
        floor += now.normal[i].z > 0.5f;
        EXPECT_LE(glm::length(seen - kSize / 2.0 * glm::dvec2(q.x / q.y, q.z / q.y)), std::sqrt(0.5) + 1e-3);
    }
    EXPECT_GT(floor, kSize * kSize / 5);
    EXPECT_GT(found - floor, kSize * kSize / 5);
    EXPECT_GT(hidden, 0);   // floor that the wall's end hid
    EXPECT_LT(hidden, kSize * 2);
    const std::vector<int32_t> still = correspondence(before, clip, before, glm::dvec3(0));
    for (size_t i = 0; i < still.size(); ++i) EXPECT_EQ(still[i], before.present[i] ? int32_t(i) : -1);
}

}  // namespace
}  // namespace dapple::truth
