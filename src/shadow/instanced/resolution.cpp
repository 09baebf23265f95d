#include "shadow/instanced/resolution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dapple::shadow {
namespace {

constexpr int kStride = 4;   ///< pixels between those measured
constexpr double kUnit = 8;  ///< texels: at 16384 a side, the sums of an 8K picture stay within 32 bits

/// A map grows only if it would also for this share of its demand: measured again, a demand may differ by its rounding.
constexpr double kClearly = 0.9;

/// Share of a map's width, per radian between a map and its caster, below which texels are not worth having. On forest-105
/// with 12 shared maps, 0.06 leaves 7.4 % error with 0.57 Mi texels (walk1), and 0 leaves 7.1 % with 4.7 Mi: what is spared
/// is most of the texels, and what they would show is the rotation's error.
constexpr double kRotation = 0.06;

/// Cosine of a receiver's normal and the direction to the sun: below, its plane wants texels without bound.
constexpr double kLeastFacing = 0.05;

}  // namespace

int SizeChooser::wanted(double demand, int most) {
    const double side = std::cbrt(std::max(demand, 1.0));
    return std::clamp(1 << int(std::lround(std::log2(side))), kLeast, most);
}

const std::vector<int>& SizeChooser::update(std::span<const double> demands) {
    for (size_t i = sides_.size(); i < demands.size(); ++i) {
        sides_.push_back(wanted(demands[i], most_));
        waits_.emplace_back();
    }
    for (size_t i = 0; i < demands.size(); ++i) {
        const int wish = wanted(demands[i], most_);
        Wait& wait = waits_[i];
        if (2 * wish > sides_[i]) {
            if (wanted(kClearly * demands[i], most_) > sides_[i]) sides_[i] = wish;
            wait = {};
            continue;
        }
        wait.largest = std::max(wait.largest, wish);
        if (++wait.measurements < kPatience) continue;
        sides_[i] = wait.largest;
        wait = {};
    }
    return sides_;
}

DemandEstimate::DemandEstimate(const frame::Frame& frame, std::vector<std::string> defines, int most) : frame_(frame), most_(most) {
    defines.push_back(fmt::format("STRIDE {}", kStride));
    defines.push_back(fmt::format("UNIT {:.1f}", kUnit));
    defines.push_back(fmt::format("ROTATION {}", kRotation));
    defines.push_back(fmt::format("LEAST_FACING {}", kLeastFacing));
    program_ = gl::Program::compute("shadow/instanced_demand.comp", defines);
}

DemandEstimate::~DemandEstimate() {
    for (Slot& slot : slots_) glDeleteSync(slot.fence);
}

void DemandEstimate::record(size_t maps, const std::function<void(const gl::Program&)>& bind, measure::Ledger& tally) {
    Slot& slot = slots_[next_];
    if (slot.fence) return;
    next_ = (next_ + 1) % slots_.size();
    slot.maps = maps;
    const std::vector<uint32_t> zero(maps);
    slot.buffer.update(maps * sizeof(uint32_t), zero.data());
    program_.set("uMost", float(most_));
    bind(program_);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, slot.buffer.name());
    constexpr int kTile = 16 * kStride;
    glDispatchCompute(GLuint(frame_.camera().width + kTile - 1) / kTile, GLuint(frame_.camera().height + kTile - 1) / kTile, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    slot.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    ++tally.drawCalls;
}

std::optional<std::vector<double>> DemandEstimate::result(bool wait) {
    std::optional<std::vector<double>> latest;
    for (size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[(next_ + i) % slots_.size()];  // oldest first
        if (!slot.fence) continue;
        if (glClientWaitSync(slot.fence, wait ? GL_SYNC_FLUSH_COMMANDS_BIT : 0, wait ? ~GLuint64(0) : 0) == GL_TIMEOUT_EXPIRED) break;
        glDeleteSync(std::exchange(slot.fence, nullptr));
        std::vector<uint32_t> sums(slot.maps);
        glGetNamedBufferSubData(slot.buffer.name(), 0, GLsizeiptr(sums.size() * sizeof(uint32_t)), sums.data());
        latest.emplace();
        for (const uint32_t sum : sums) latest->push_back(sum * kUnit * kStride * kStride);
    }
    return latest;
}

}  // namespace dapple::shadow
