#include "measure/gl_scene.h"

#include "measure/counters.h"
#include "measure/counters/overdraw.h"
#include "measure/counters/pipeline.h"

#include <vector>

namespace dapple::measure {
namespace {

class CountersGl : public GlScene {
protected:
    static constexpr uint64_t kPixels = uint64_t{kSize} * kSize;
};

TEST_F(CountersGl, SamplesAreExactAndHalvedByDiscard) {
    const auto all = program(kQuad, "value = 1;");
    const auto half = program(kQuad, "if ((int(gl_FragCoord.x) & 1) == 1) discard; value = 1;");
    Counters counters;
    const auto draw = [&](const auto& p, const char* pass) {
        counters.begin(pass);
        glUseProgram(p.name());
        glDrawArrays(GL_TRIANGLES, 0, 6);
        counters.end();
    };
    draw(all, "all");
    draw(half, "half");
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_NEVER);
    draw(all, "hidden");
    counters.begin("nothing");
    counters.end();

    const auto passes = counters.results();
    ASSERT_EQ(passes.size(), 4u);
    const std::array<uint64_t, 4> expected{kPixels, kPixels / 2, 0, 0};
    for (size_t i = 0; i < 4; ++i) EXPECT_EQ(passes[i].value(metric::kSamplesPassed), expected[i]) << passes[i].pass;
    EXPECT_EQ(passes[1].pass, "half");
    EXPECT_TRUE(counters.results().empty());

    for (const auto& pass : passes)
        for (const auto& v : pass.values) EXPECT_NE(v.value.has_value(), !v.missing.empty()) << v.metric;
    if (passes[0].value(metric::kFragmentInvocations)) {
        EXPECT_GE(*passes[0].overshade(), 1);
        EXPECT_GE(*passes[1].overshade(), 2);  // the discarded half was shaded too
        EXPECT_FALSE(passes[2].overshade());
    }
    if (const auto vertices = passes[0].value(metric::kVertexInvocations)) {
        EXPECT_EQ(*vertices, 6u);
        EXPECT_EQ(passes[0].value(metric::kPrimitivesSubmitted), 2u);
        EXPECT_EQ(passes[3].value(metric::kPrimitivesSubmitted), 0u);
    }
}

TEST_F(CountersGl, APassMayAskOcclusionQueriesOfItsOwn) {
    const auto all = program(kQuad, "value = 1;");
    GLuint query = 0;
    glGenQueries(1, &query);
    const auto ask = [&](Counters& counters, bool says) {
        counters.begin("pass", says);
        glUseProgram(all.name());
        glBeginQuery(GL_ANY_SAMPLES_PASSED, query);
        const GLenum error = glGetError();
        glDrawArrays(GL_TRIANGLES, 0, 6);
        if (error == GL_NO_ERROR) glEndQuery(GL_ANY_SAMPLES_PASSED);
        counters.end();
        return error;
    };
    Counters counters;
    EXPECT_EQ(ask(counters, false), GLenum(GL_INVALID_OPERATION));  // why it has to say so
    EXPECT_EQ(ask(counters, true), GLenum(GL_NO_ERROR));
    const auto passes = counters.results();
    EXPECT_EQ(passes[0].value(metric::kSamplesPassed), kPixels);
    EXPECT_FALSE(passes[1].value(metric::kSamplesPassed));
    EXPECT_NE(passes[1].values[0].missing, "");
    EXPECT_EQ(passes[1].value(metric::kVertexInvocations), passes[0].value(metric::kVertexInvocations));
    GLuint any = 0;
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &any);
    EXPECT_EQ(any, 1u);
    glDeleteQueries(1, &query);
}

// 65,536 triangles, each over the pixels (0,0), (1,0) and (0,1) of its own block of 4 × 4 pixels: a shader runs on
// whole quads of 2 × 2 at least, so that four invocations are spent on three samples.
TEST_F(CountersGl, TinyTrianglesOvershade) {
    const auto tiny = program(
        "vec2 block = vec2(gl_InstanceID & 255, gl_InstanceID >> 8) * 4.0;"
        "vec2 c = vec2(gl_VertexID == 1 ? 2.2 : 0.2, gl_VertexID == 2 ? 2.2 : 0.2);"
        "gl_Position = vec4((block + c) / 512.0 - 1.0, 0.5, 1);",
        "value = 1;");
    Counters counters;
    counters.begin("tiny");
    glUseProgram(tiny.name());
    glDrawArraysInstanced(GL_TRIANGLES, 0, 3, 65536);
    counters.end();
    const auto pass = counters.results().at(0);
    EXPECT_EQ(pass.value(metric::kSamplesPassed), 196608u);
    if (pass.value(metric::kFragmentInvocations)) {
        EXPECT_GE(*pass.overshade(), 4.0 / 3.0);
        EXPECT_LE(*pass.overshade(), 16.0);
        RecordProperty("overshade", std::to_string(*pass.overshade()));
    }
    if (pass.value(metric::kPrimitivesSubmitted)) {
        EXPECT_EQ(pass.value(metric::kPrimitivesSubmitted), 65536u);
        EXPECT_EQ(pass.value(metric::kVertexInvocations), 3u * 65536);
    }
}

TEST_F(CountersGl, AdditiveTargetGivesTheOverdrawHistogram) {
    const auto half = program(kQuad, "if (gl_FragCoord.x > 512.0) discard; value = 1;");
    const auto all = program(kQuad, "value = 1;");
    const float zero = 0;
    glClearTexImage(target_.name(), 0, GL_RED, GL_FLOAT, &zero);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    Counters counters;
    counters.begin("overdraw");
    glUseProgram(all.name());
    for (int i = 0; i < 5; ++i) glDrawArrays(GL_TRIANGLES, 0, 6);
    glUseProgram(half.name());
    for (int i = 0; i < 12; ++i) glDrawArrays(GL_TRIANGLES, 0, 6);
    counters.end();
    std::vector<float> texels(kPixels);
    glGetTextureImage(target_.name(), 0, GL_RED, GL_FLOAT, GLsizei(texels.size() * sizeof(float)), texels.data());
    const auto h = overdrawHistogram(texels);
    EXPECT_EQ(h.pixels, (std::array<uint64_t, kOverdrawBins>{0, 0, 0, 0, kPixels / 2, 0, kPixels / 2}));
    EXPECT_EQ(h.max, 17u);
    EXPECT_DOUBLE_EQ(h.mean, 11);
    // Two independent counts of the same fragments.
    EXPECT_EQ(counters.results().at(0).value(metric::kSamplesPassed), uint64_t(h.mean * double(kPixels)));
}

}  // namespace
}  // namespace dapple::measure
