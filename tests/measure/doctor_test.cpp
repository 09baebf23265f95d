#include "measure/doctor.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>

namespace dapple::measure {
namespace {

/// Trials whose wall time is `wallMs` give or take 2 %, and whose timer sees `ratio` of it.
std::vector<TimerTrial> trials(double wallMs, double ratio) {
    std::vector<TimerTrial> list;
    for (double jitter : {1.0, 0.98, 1.02, 0.99, 1.01}) list.push_back({wallMs * jitter, wallMs * jitter * ratio});
    return list;
}

TEST(Doctor, AcceptsAnHonestTimer) {
    const auto v = judgeTimer("gpu_timestamp", 64, trials(8, 0.97), trials(32, 0.99));
    EXPECT_TRUE(v.accepted) << v.reason;
    EXPECT_NEAR(v.ratioLong, 0.99, 1e-9);
    EXPECT_DOUBLE_EQ(v.shortLoad.wallMs, 8);
}

TEST(Doctor, RejectsEachKindOfLie) {
    const auto reason = [](int bits, const auto& shorts, const auto& longs) {
        const auto v = judgeTimer("gpu_elapsed", bits, shorts, longs);
        EXPECT_FALSE(v.accepted) << v.reason;
        return v.reason;
    };
    EXPECT_NE(reason(0, trials(8, 1), trials(32, 1)).find("0 bits"), std::string::npos);
    // llvmpipe's: 0.26 ms for a draw of 63.6 ms.
    EXPECT_NE(reason(64, trials(15.9, 0.004), trials(63.6, 0.004)).find("sees only"), std::string::npos);
    EXPECT_NE(reason(64, trials(8, 1.01), trials(32, 1.1)).find("more time than"), std::string::npos);
    auto once = trials(32, 0.99);
    once[3].timerMs = 40;  // a single impossible reading is enough
    EXPECT_NE(reason(64, trials(8, 0.99), once).find("more time than"), std::string::npos);
    EXPECT_NE(reason(64, trials(8, 0.5), trials(32, 0.9)).find("grows by"), std::string::npos);
    EXPECT_NE(reason(64, trials(8, 0), trials(32, 0.9)).find("grows by"), std::string::npos);
}

TEST(Doctor, AcceptsTheWallOnlyIfFinishWaits) {
    EXPECT_TRUE(judgeTimer("cpu_finish", 0, trials(8, 1), trials(31, 1)).accepted);
    EXPECT_FALSE(judgeTimer("cpu_finish", 0, trials(0.02, 1), trials(0.021, 1)).accepted);
    EXPECT_FALSE(judgeTimer("cpu_finish", 0, trials(8, 1), trials(90, 1)).accepted);
}

TEST(Doctor, ReportIsJsonAndText) {
    TimerReport report;
    report.verdicts = {judgeTimer("gpu_timestamp", 64, trials(8, 0.004), trials(32, 0.004)),
                       judgeTimer("cpu_finish", 0, trials(8, 1), trials(32, 1))};
    report.chosen = "cpu_finish";
    report.drawsShort = 8;
    const auto j = nlohmann::json::parse(report.json());
    EXPECT_EQ(j["chosen"], "cpu_finish");
    EXPECT_EQ(j["verdicts"][0]["accepted"], false);
    EXPECT_EQ(j["verdicts"][0]["bits"], 64);
    EXPECT_NEAR(j["verdicts"][0]["ratio_long"].get<double>(), 0.004, 1e-6);
    EXPECT_NEAR(j["verdicts"][1]["long"]["wall_ms"].get<double>(), 32, 1e-3);
    EXPECT_EQ(j["verdicts"][1]["reason"], report.verdicts[1].reason);
    EXPECT_NE(report.text().find("chosen: cpu_finish"), std::string::npos);
}

}  // namespace
}  // namespace dapple::measure
