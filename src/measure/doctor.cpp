#include "measure/doctor.h"

#include "base/error.h"
#include "gl/context.h"
#include "gl/objects.h"
#include "gl/program.h"
#include "measure/flags.h"
#include "measure/statistics.h"
#include "measure/timer.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace dapple::measure {

namespace {

constexpr double kLeastRatio = 0.8;
constexpr double kScaling = 1.25;
constexpr int kTrials = 5;
constexpr int kScale = 4;
/// One draw lasts at least this long, so that what a driver needs to start a draw is small beside it.
constexpr double kDrawMs = 1;
constexpr double kShortMs = 8;
constexpr int kMaxIterations = 1 << 20;
constexpr int kSize = 512;

constexpr const char* kVertexSource = R"(#version 450 core
void main() {
    gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0);
})";
// The result depends on every iteration, and blending adds every draw to the last: nothing can be skipped.
constexpr const char* kFragmentSource = R"(#version 450 core
layout(location = 0) uniform int iterations;
layout(location = 0) out vec4 colour;
void main() {
    vec2 z = gl_FragCoord.xy / 512.0;
    for (int i = 0; i < iterations; ++i) z = fract(z.yx * 1.7 + z * z);
    colour = vec4(z, 0.0, 1.0);
})";

GLuint compile(GLenum stage, const char* source) {
    const GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    return shader;
}

/// Full-screen draws of adjustable cost into a target of its own.
class Load {
public:
    Load() : target_(GL_RGBA8, kSize, kSize), vertexArray_(gl::makeVertexArray()) {
        const gl::Texture* colour = &target_;
        framebuffer_ = gl::makeFramebuffer({&colour, 1}, nullptr);
        program_ = gl::Handle<gl::deleteProgram>(glCreateProgram());
        for (const GLuint shader : {compile(GL_VERTEX_SHADER, kVertexSource), compile(GL_FRAGMENT_SHADER, kFragmentSource)}) {
            glAttachShader(program_.name(), shader);
            glDeleteShader(shader);
        }
        glLinkProgram(program_.name());
        GLint linked = GL_FALSE;
        glGetProgramiv(program_.name(), GL_LINK_STATUS, &linked);
        if (!linked) throw base::Error(base::ExitCode::failed, "doctor: the driver does not link the test's shaders");
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
        glBindVertexArray(vertexArray_.name());
        glUseProgram(program_.name());
        glViewport(0, 0, kSize, kSize);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        calibrate();
    }
    ~Load() { gl::resetState(); }
    Load(const Load&) = delete;
    Load& operator=(const Load&) = delete;

    int draws() const { return draws_; }

    TimerTrial run(Timer& timer, int draws) const {
        glFinish();
        const double begin = monotonicSeconds();
        timer.beginFrame(false);
        for (int i = 0; i < draws; ++i) glDrawArrays(GL_TRIANGLES, 0, 3);
        timer.endFrame();
        glFinish();
        const double wallMs = (monotonicSeconds() - begin) * 1e3;
        const auto times = timer.drain();
        return {wallMs, times.size() == 1 && times[0].flags.empty() ? times[0].frameMs : 0};
    }

private:
    double wallOf(int draws) const {
        const auto timer = makeCpuFinishTimer();
        double least = run(*timer, draws).wallMs;
        for (int i = 0; i < 2; ++i) least = std::min(least, run(*timer, draws).wallMs);
        return least;
    }
    void calibrate() {
        glUniform1i(0, 1);
        wallOf(1);  // compiles
        double drawMs = 0;
        for (int iterations = 1; iterations <= kMaxIterations && drawMs < kDrawMs; iterations *= 2) {
            glUniform1i(0, iterations);
            drawMs = wallOf(1);
        }
        draws_ = std::clamp(int(kShortMs / drawMs), 4, 64);
    }

    gl::Texture target_;
    gl::VertexArray vertexArray_;
    gl::Framebuffer framebuffer_;
    gl::Handle<gl::deleteProgram> program_;
    int draws_ = 1;
};

TimerTrial medianTrial(const std::vector<TimerTrial>& trials) {
    std::vector<double> wall, timer;
    for (const auto& t : trials) {
        wall.push_back(t.wallMs);
        timer.push_back(t.timerMs);
    }
    return {median(wall), median(timer)};
}

double medianRatio(const std::vector<TimerTrial>& trials) {
    std::vector<double> ratios;
    for (const auto& t : trials) ratios.push_back(t.timerMs / t.wallMs);
    return median(ratios);
}

void judgeQueries(BackendVerdict& v, const std::vector<TimerTrial>& shorts, const std::vector<TimerTrial>& longs) {
    const auto tooLong = [](const TimerTrial& t) { return exceedsWall(t.timerMs, t.wallMs); };
    const double wallGrowth = v.longLoad.wallMs / v.shortLoad.wallMs;
    const double timerGrowth = v.shortLoad.timerMs > 0 ? v.longLoad.timerMs / v.shortLoad.timerMs : 0;
    if (v.bits == 0) v.reason = "the driver's counter has 0 bits";
    else if (std::any_of(shorts.begin(), shorts.end(), tooLong) || std::any_of(longs.begin(), longs.end(), tooLong))
        v.reason = "reports more time than passed on the wall clock";
    else if (v.ratioLong < kLeastRatio)
        v.reason = fmt::format("sees only {:.3f} of the wall time on the long load; {} is needed", v.ratioLong, kLeastRatio);
    else if (timerGrowth > kScaling * wallGrowth || timerGrowth * kScaling < wallGrowth)
        v.reason = fmt::format("grows by {:.2f} for {} times the work while the wall time grows by {:.2f}", timerGrowth,
                               kScale, wallGrowth);
    else {
        v.accepted = true;
        v.reason = fmt::format("sees {:.3f} of the wall time on the long load and grows with it", v.ratioLong);
    }
}

void judgeFinish(BackendVerdict& v) {
    const double growth = v.longLoad.wallMs / v.shortLoad.wallMs;
    v.accepted = growth >= 0.5 * kScale && growth <= 2 * kScale;
    v.reason = v.accepted
                   ? fmt::format("glFinish waits: {} times the work took {:.2f} times as long; it serialises passes",
                                 kScale, growth)
                   : fmt::format("{} times the work took {:.2f} times as long: glFinish does not wait, or the machine is "
                                 "too busy to time anything", kScale, growth);
}

std::string jsonTrial(const TimerTrial& t) {
    return fmt::format(R"({{"wall_ms":{:.6g},"timer_ms":{:.6g}}})", t.wallMs, t.timerMs);
}

int counterBits(const std::string& backend) {
    GLint bits = 0;
    if (backend == "gpu_timestamp") glGetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
    if (backend == "gpu_elapsed") glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
    return bits;
}

}  // namespace

BackendVerdict judgeTimer(const std::string& backend, int bits, const std::vector<TimerTrial>& shorts,
                          const std::vector<TimerTrial>& longs) {
    BackendVerdict v;
    v.backend = backend;
    v.bits = bits;
    v.shortLoad = medianTrial(shorts);
    v.longLoad = medianTrial(longs);
    v.ratioShort = medianRatio(shorts);
    v.ratioLong = medianRatio(longs);
    if (backend == "cpu_finish") judgeFinish(v);
    else judgeQueries(v, shorts, longs);
    return v;
}

TimerReport testTimers() {
    const double begin = monotonicSeconds();
    TimerReport report;
    const Load load;
    report.drawsShort = load.draws();
    for (const std::string backend : {"gpu_timestamp", "gpu_elapsed", "cpu_finish"}) {
        const auto timer = makeTimer(backend);
        std::vector<TimerTrial> shorts, longs;
        load.run(*timer, 1);  // first use creates its queries
        for (int trial = 0; trial < kTrials; ++trial) {
            shorts.push_back(load.run(*timer, load.draws()));
            longs.push_back(load.run(*timer, kScale * load.draws()));
        }
        report.verdicts.push_back(judgeTimer(backend, counterBits(backend), shorts, longs));
        if (report.verdicts.back().accepted && report.chosen.empty()) report.chosen = backend;
    }
    gl::checkErrors("doctor's timer test");
    report.seconds = monotonicSeconds() - begin;
    return report;
}

std::string TimerReport::text() const {
    std::string out = fmt::format("timers (loads of {} and {} draws, {:.1f} s)\n", drawsShort, kScale * drawsShort, seconds);
    for (const auto& v : verdicts)
        out += fmt::format("  {:14} {:9} {:2} bits  timer/wall {:.3f} ({:.2f} ms), {:.3f} ({:.2f} ms): {}\n", v.backend,
                           v.accepted ? "accepted" : "rejected", v.bits, v.ratioShort, v.shortLoad.wallMs, v.ratioLong,
                           v.longLoad.wallMs, v.reason);
    return out + fmt::format("  chosen: {}\n", chosen.empty() ? "none; times mean nothing here" : chosen);
}

std::string TimerReport::json() const {
    std::string list;
    for (const auto& v : verdicts)
        list += fmt::format(R"({}{{"backend":"{}","accepted":{},"reason":"{}","bits":{},"ratio_short":{:.6g},)"
                            R"("ratio_long":{:.6g},"short":{},"long":{}}})",
                            list.empty() ? "" : ",", v.backend, v.accepted, v.reason, v.bits, v.ratioShort, v.ratioLong,
                            jsonTrial(v.shortLoad), jsonTrial(v.longLoad));
    return fmt::format(R"({{"chosen":"{}","draws_short":{},"seconds":{:.3f},"verdicts":[{}]}})", chosen, drawsShort,
                       seconds, list);
}

}  // namespace dapple::measure
