#include "measure/timers/gpu_queries.h"

#include <cassert>
#include <thread>
#include <utility>

namespace dapple::measure {

namespace {

/// A frame that takes longer than this has hung or lost its context.
constexpr double kLostAfterSeconds = 10;

}  // namespace

uint64_t counterDifference(uint64_t begin, uint64_t end, int bits, bool& wrapped) {
    wrapped = end < begin;
    const uint64_t mask = bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
    return (end - begin) & mask;
}

GpuQueryTimer::GpuQueryTimer(GLenum target) { glGetQueryiv(target, GL_QUERY_COUNTER_BITS, &bits_); }

GpuQueryTimer::~GpuQueryTimer() {
    for (Slot& slot : slots_) glDeleteQueries(GLsizei(slot.queries.size()), slot.queries.data());
}

GLuint GpuQueryTimer::nextQuery() {
    assert(open_);
    if (open_->used == open_->queries.size()) {
        GLuint query = 0;
        glGenQueries(1, &query);
        open_->queries.push_back(query);
    }
    return open_->queries[open_->used++];
}

void GpuQueryTimer::beginFrame(bool perPass) {
    assert(!open_);
    while (!pending_.empty() && collectOldest(Wait::no)) {}
    if (pending_.size() == kRingSlots) collectOldest(Wait::yes);
    open_ = &slots_[next_++ % kRingSlots];
    open_->used = 0;
    open_->perPass = perPass;
    onBeginFrame();
}

void GpuQueryTimer::endFrame() {
    onEndFrame();
    pending_.push_back(std::exchange(open_, nullptr));
}

/// False if the oldest frame's results have not arrived and nobody waits for them.
bool GpuQueryTimer::collectOldest(Wait wait) {
    const Slot& slot = *pending_.front();
    const double deadline = monotonicSeconds() + kLostAfterSeconds;
    bool lost = false;
    if (wait == Wait::yes) glFlush();
    for (size_t i = 0; i < slot.used && !lost; ++i) {
        GLint available = GL_FALSE;
        while (glGetQueryObjectiv(slot.queries[i], GL_QUERY_RESULT_AVAILABLE, &available), !available) {
            if (wait == Wait::no) return false;
            if ((lost = monotonicSeconds() > deadline)) break;
            std::this_thread::yield();
        }
    }
    if (lost) {
        done_.push_back({.frameMs = 0, .passMs = {}, .flags = {std::string(flag::kLost)}});
    } else {
        std::vector<uint64_t> results(slot.used);
        for (size_t i = 0; i < slot.used; ++i) {
            GLuint64 value = 0;
            glGetQueryObjectui64v(slot.queries[i], GL_QUERY_RESULT, &value);
            results[i] = value;
        }
        done_.push_back(convert(results, slot.perPass));
    }
    pending_.pop_front();
    return true;
}

std::vector<FrameTimes> GpuQueryTimer::drain() {
    assert(!open_);
    while (!pending_.empty()) collectOldest(Wait::yes);
    return std::exchange(done_, {});
}

}  // namespace dapple::measure
