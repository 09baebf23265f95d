#include "measure/counters/pipeline.h"

#include "measure/counters.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace dapple::measure {

std::optional<uint64_t> PassCounters::value(std::string_view metric) const {
    const auto found = std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.metric == metric; });
    assert(found != values.end());
    return found->value;
}

std::optional<double> PassCounters::overshade() const {
    const auto samples = value(metric::kSamplesPassed), fragments = value(metric::kFragmentInvocations);
    if (!samples || !fragments || *samples == 0) return {};
    return double(*fragments) / double(*samples);
}

Counters::Counters() {
    targets_ = {{GL_SAMPLES_PASSED, metric::kSamplesPassed, {}},
                {GL_FRAGMENT_SHADER_INVOCATIONS_ARB, metric::kFragmentInvocations, {}},
                {GL_VERTEX_SHADER_INVOCATIONS_ARB, metric::kVertexInvocations, {}},
                {GL_PRIMITIVES_SUBMITTED_ARB, metric::kPrimitivesSubmitted, {}}};
    const bool statistics = epoxy_gl_version() >= 46 || epoxy_has_gl_extension("GL_ARB_pipeline_statistics_query");
    for (Target& t : targets_) {
        if (t.target != GL_SAMPLES_PASSED && !statistics) {
            t.missing = "no GL_ARB_pipeline_statistics_query";
            continue;
        }
        GLint bits = 0;
        glGetQueryiv(t.target, GL_QUERY_COUNTER_BITS, &bits);
        if (bits == 0) t.missing = "the driver's counter has 0 bits";
    }
}

Counters::~Counters() {
    for (Pass& pass : passes_)
        for (const std::vector<GLuint>& stretch : pass.queries) glDeleteQueries(GLsizei(stretch.size()), stretch.data());
}

std::string Counters::missing(const Target& target, bool asksOcclusion) {
    if (asksOcclusion && target.target == GL_SAMPLES_PASSED && target.missing.empty()) return "the pass asks occlusion queries of its own";
    return target.missing;
}

void Counters::begin(std::string_view pass, bool asksOcclusion) {
    passes_.push_back({std::string(pass), asksOcclusion});
    open();
}

void Counters::open() {
    std::vector<GLuint>& stretch = passes_.back().queries.emplace_back(targets_.size(), 0);
    for (size_t i = 0; i < targets_.size(); ++i) {
        if (!missing(targets_[i], passes_.back().asksOcclusion).empty()) continue;
        // Not glCreateQueries: Mesa (22.3) refuses it the statistics targets that glBeginQuery takes.
        glGenQueries(1, &stretch[i]);
        glBeginQuery(targets_[i].target, stretch[i]);
    }
}

void Counters::close() {
    for (const Target& t : targets_)
        if (missing(t, passes_.back().asksOcclusion).empty()) glEndQuery(t.target);
}

void Counters::end() {
    close();
    passes_.back().ended = true;
}

uint64_t Counters::aside(const std::function<void()>& draw) {
    const bool within = !passes_.empty() && !passes_.back().ended;
    if (within) close();
    GLuint query = 0;
    glGenQueries(1, &query);
    glBeginQuery(GL_SAMPLES_PASSED, query);
    draw();
    glEndQuery(GL_SAMPLES_PASSED);
    GLuint64 samples = 0;
    glGetQueryObjectui64v(query, GL_QUERY_RESULT, &samples);
    glDeleteQueries(1, &query);
    if (within) open();
    return samples;
}

std::vector<PassCounters> Counters::results() {
    std::vector<PassCounters> results;
    for (Pass& pass : passes_) {
        results.push_back({pass.name, {}});
        for (size_t i = 0; i < targets_.size(); ++i) {
            CounterValue value{targets_[i].metric, {}, missing(targets_[i], pass.asksOcclusion)};
            for (const std::vector<GLuint>& stretch : pass.queries) {
                if (!value.missing.empty()) break;
                GLuint64 count = 0;
                glGetQueryObjectui64v(stretch[i], GL_QUERY_RESULT, &count);
                value.value = value.value.value_or(0) + count;
            }
            results.back().values.push_back(std::move(value));
        }
        for (const std::vector<GLuint>& stretch : pass.queries) glDeleteQueries(GLsizei(stretch.size()), stretch.data());
    }
    passes_.clear();
    return results;
}

std::optional<uint64_t> driverFreeBytes() {
    std::array<GLint, 4> kibibytes{};
    if (epoxy_has_gl_extension("GL_NVX_gpu_memory_info"))
        glGetIntegerv(GL_GPU_MEMORY_INFO_CURRENT_AVAILABLE_VIDMEM_NVX, kibibytes.data());
    else if (epoxy_has_gl_extension("GL_ATI_meminfo"))
        glGetIntegerv(GL_TEXTURE_FREE_MEMORY_ATI, kibibytes.data());
    else
        return {};
    return uint64_t(kibibytes[0]) * 1024;
}

}  // namespace dapple::measure
