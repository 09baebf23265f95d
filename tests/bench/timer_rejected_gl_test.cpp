// A forced timer is used; whether it may be trusted is what the self-test says.
#include "bench/gl_workbench.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace dapple::bench {
namespace {

TEST(TimerRejected, SaysWhatTheSelfTestFound) {
    for (const char* backend : {"gpu_elapsed", "gpu_timestamp", "cpu_finish"}) {
        GlWorkbench bench(-1, backend);
        EXPECT_EQ(bench.backend(), backend);
        const nlohmann::json identity = nlohmann::json::parse(bench.identityJson());
        bool found = false;
        for (const auto& verdict : identity["doctor"]["verdicts"]) {
            if (verdict["backend"] != backend) continue;
            found = true;
            EXPECT_EQ(bench.timerRejected(), verdict["accepted"].get<bool>() ? "" : verdict["reason"].get<std::string>());
        }
        EXPECT_TRUE(found) << backend;
    }
}

}  // namespace
}  // namespace dapple::bench
