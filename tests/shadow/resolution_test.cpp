#include "shadow/instanced/resolution.h"

#include "base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dapple::shadow {
namespace {

double cube(double v) { return v * v * v; }

TEST(SizeChooser, AMapSeenOnceByEachPixelGetsATexelPerPixel) {
    for (const int side : {16, 64, 512, 2048}) EXPECT_EQ(SizeChooser::wanted(double(side) * side * side, 4096), side);
    EXPECT_EQ(SizeChooser::wanted(0, 4096), 16);
    EXPECT_EQ(SizeChooser::wanted(1e15, 1024), 1024);
}

// For the texels that it takes, no other choice of powers of two for two maps has much less error Σ w / s.
TEST(SizeChooser, SpendsTexelsWhereTheyHelpMost) {
    base::Random random(5, 0, 0);
    const auto error = [](double da, double db, double a, double b) { return da / a + db / b; };
    for (int i = 0; i < 200; ++i) {
        const double da = cube(std::exp2(double(random.next(4.5f, 10.5f)))), db = cube(std::exp2(double(random.next(4.5f, 10.5f))));
        const double a = SizeChooser::wanted(da, 2048), b = SizeChooser::wanted(db, 2048);
        for (double x = 16; x <= 2048; x *= 2)
            for (double y = 16; y <= 2048; y *= 2)
                if (x * x + y * y <= a * a + b * b) {
                    ASSERT_LE(error(da, db, a, b), 1.5 * error(da, db, x, y)) << da << " " << db;
                }
    }
}

TEST(SizeChooser, GrowsAtOnceAndShrinksLate) {
    SizeChooser chooser(1024);
    const std::vector<double> large{cube(512)}, small{cube(64)}, medium{cube(256)};
    EXPECT_EQ(chooser.update(small)[0], 64);
    EXPECT_EQ(chooser.update(large)[0], 512);
    for (int i = 1; i < SizeChooser::kPatience; ++i) ASSERT_EQ(chooser.update(i == 5 ? medium : small)[0], 512) << i;
    EXPECT_EQ(chooser.update(small)[0], 256) << "the most that was asked for while it waited";
    for (int i = 1; i < SizeChooser::kPatience; ++i) ASSERT_EQ(chooser.update(small)[0], 256) << i;
    EXPECT_EQ(chooser.update(small)[0], 64);
}

// Of a demand that stays, a side asks for at most what it is, and for no less once a tenth of it is given up.
TEST(SizeChooser, SettlesWithinItsHysteresisWhateverWasBefore) {
    base::Random random(9, 0, 0);
    size_t less = 0;
    for (int trial = 0; trial < 300; ++trial) {
        SizeChooser chooser(1024);
        for (int i = 0; i < trial % 50; ++i) chooser.update(std::vector<double>{cube(std::exp2(double(random.next(3, trial % 2 == 0 ? 11 : 5))))});
        // Every third a little above the border between two sides.
        const double demand = cube(std::exp2(trial % 3 == 0 ? std::floor(double(random.next(6, 10))) + 0.5 + double(random.next(0, 0.06f)) : double(random.next(4, 10))));
        int side = 0;
        for (int i = 0; i < 2 * SizeChooser::kPatience; ++i) side = chooser.update(std::vector<double>{demand})[0];
        for (int i = 0; i < 2 * SizeChooser::kPatience; ++i) ASSERT_EQ(chooser.update(std::vector<double>{demand})[0], side);
        EXPECT_LE(side, SizeChooser::wanted(demand, 1024));
        EXPECT_GE(side, SizeChooser::wanted(0.9 * demand, 1024));
        less += side < SizeChooser::wanted(demand, 1024);
    }
    EXPECT_GT(less, 0u);
}

// A demand that swings about the border between two sides, never below it for as long as the patience, changes the map once.
TEST(SizeChooser, DoesNotOscillate) {
    for (const int period : {2, 7, 20, 40}) {
        SizeChooser chooser(1024);
        int changes = 0, before = 0;
        for (int frame = 0; frame < 600; ++frame) {
            const double side = 256 * std::exp2(0.9 * std::sin(6.2831853 * frame / period));
            const int now = chooser.update(std::vector<double>{cube(side)})[0];
            changes += frame > 0 && now != before;
            before = now;
        }
        EXPECT_LE(changes, 2) << period;
    }
}

}  // namespace
}  // namespace dapple::shadow
