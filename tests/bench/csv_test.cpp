#include "bench/csv.h"

#include "base/error.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>

namespace dapple::bench {
namespace {

using Row = std::vector<std::string>;

TEST(Csv, QuotesAsRfc4180) {
    EXPECT_EQ(csvRow(Row{"a", "b c", ""}), "a,b c,\n");
    EXPECT_EQ(csvRow(Row{"a,b", "say \"x\"", "two\nlines"}), "\"a,b\",\"say \"\"x\"\"\",\"two\nlines\"\n");
}

TEST(Csv, AnyTextSurvivesTheRoundTrip) {
    std::mt19937 random(3);
    const std::string alphabet = "ab,\"\n\r é";
    for (int i = 0; i < 2000; ++i) {
        Row row(1 + random() % 4);
        for (std::string& field : row)
            for (size_t n = random() % 6; n > 0; --n) field += alphabet[random() % alphabet.size()];
        std::string header;
        for (size_t c = 0; c < row.size(); ++c) header += (c ? "," : "") + std::to_string(c);
        const CsvTable table(header + "\n" + csvRow(row) + csvRow(row), "t.csv");
        ASSERT_EQ(table.rows(), 2u);
        for (size_t c = 0; c < row.size(); ++c) ASSERT_EQ(table.at(1, std::to_string(c)), row[c]);
    }
}

TEST(Csv, NumbersReadBackAsTheSameDouble) {
    std::mt19937_64 random(4);
    for (int i = 0; i < 20000; ++i) {
        const double value = std::bit_cast<double>(random());
        if (!std::isfinite(value)) continue;
        EXPECT_EQ(std::strtod(csvNumber(value).c_str(), nullptr), value);
    }
    EXPECT_EQ(csvNumber(0.1), "0.1");
    EXPECT_EQ(csvNumber(36000), "36000");
    EXPECT_EQ(csvNumber(std::nan("")), "");
    EXPECT_EQ(csvNumber(INFINITY), "");
}

TEST(Csv, DamageIsReportedWithItsLine) {
    const auto why = [](const char* text) {
        try {
            CsvTable(text, "t.csv");
        } catch (const base::Error& e) {
            EXPECT_EQ(e.code(), base::ExitCode::corrupt);
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    EXPECT_NE(why("").find("empty"), std::string::npos);
    EXPECT_NE(why("a,b\n1,2\n3\n").find("t.csv:3"), std::string::npos);
    EXPECT_NE(why("a,b\n1,2\n3,4").find("cut off"), std::string::npos);
    EXPECT_NE(why("a,b\n1,\"2\n3,4\n").find("t.csv:2: a quote"), std::string::npos);
}

}  // namespace
}  // namespace dapple::bench
