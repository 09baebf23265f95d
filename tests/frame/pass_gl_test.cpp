#include "frame/pass.h"

#include "gl/context.h"
#include "gl/objects.h"

#include <gtest/gtest.h>

namespace dapple::frame {
namespace {

struct Log : PassObserver {
    std::vector<std::string> lines;
    std::vector<measure::Ledger> ledgers;
    void beginPass(const Pass& pass) override { lines.push_back("begin " + pass.name); }
    void endPass(const Pass& pass, const measure::Ledger& ledger) override {
        lines.push_back("end " + pass.name);
        ledgers.push_back(ledger);
    }
};

TEST(Execute, RunsInOrderWithTheObserverAroundEachPass) {
    const gl::Context context = gl::Context::headless();
    Log log;
    const auto recording = [&](const std::string& name, uint64_t draws) {
        return Pass{name, {}, {}, "", "", [&log, name, draws](measure::Ledger& tally) {
                        log.lines.push_back("record " + name);
                        EXPECT_EQ(tally, measure::Ledger{});
                        tally.drawCalls += draws;
                    }};
    };
    std::vector<Pass> passes{recording("a", 3), recording("b", 0), recording("c", 5)};
    passes[1].leftOut = "not needed";
    execute(passes, log);
    EXPECT_EQ(log.lines, (std::vector<std::string>{"begin a", "record a", "end a", "begin c", "record c", "end c"}));
    ASSERT_EQ(log.ledgers.size(), 2u);
    EXPECT_EQ(log.ledgers[0].drawCalls, 3u);
    EXPECT_EQ(log.ledgers[1].drawCalls, 5u);
    EXPECT_NO_THROW(gl::checkErrors("test"));
}

TEST(Execute, LeaksNoStateFromPassToPass) {
    const gl::Context context = gl::Context::headless();
    const gl::VertexArray vertexArray = gl::makeVertexArray();
    glEnable(GL_BLEND);  // left behind by somebody before the frame
    int recorded = 0;
    const Pass dirty{"dirty", {}, {}, "", "", [&](measure::Ledger&) {
                         ++recorded;
                         EXPECT_FALSE(glIsEnabled(GL_BLEND));
                         EXPECT_FALSE(glIsEnabled(GL_DEPTH_TEST));
                         GLint bound = -1, function = 0;
                         glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &bound);
                         glGetIntegerv(GL_DEPTH_FUNC, &function);
                         EXPECT_EQ(bound, 0);
                         EXPECT_EQ(function, GL_LESS);
                         glEnable(GL_BLEND);
                         glEnable(GL_DEPTH_TEST);
                         glDepthFunc(GL_GREATER);
                         glBindVertexArray(vertexArray.name());
                     }};
    PassObserver nobody;
    execute(std::vector<Pass>{dirty, dirty}, nobody);
    EXPECT_EQ(recorded, 2);
    EXPECT_FALSE(glIsEnabled(GL_BLEND));
    EXPECT_FALSE(glIsEnabled(GL_DEPTH_TEST));
    GLint depth = -1;
    glGetIntegerv(GL_DEBUG_GROUP_STACK_DEPTH, &depth);
    EXPECT_EQ(depth, 1);  // every label was popped
    EXPECT_NO_THROW(gl::checkErrors("test"));
}

}  // namespace
}  // namespace dapple::frame
