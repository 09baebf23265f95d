#include "shadow/instanced/resolution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace dapple::shadow {
namespace {
double env(const char* n, double d) { const char* v = std::getenv(n); return v ? atof(v) : d; }
}  // namespace

int SizeChooser::wanted(const Demand& demand, int most) {
    uint64_t all = 0, above = 0;
    for (const uint32_t n : demand.receivers) all += n;
    static const double q = env("Q", 0.05), bias = env("B", 0), mode = env("M", 0);
    if (mode == 1) {
        double sum = 0;
        for (int b = 0; b < Demand::kBins; ++b) sum += demand.receivers[size_t(b)] * 16 * std::pow(2.0, (b + .5) / 2);
        const double s = q * std::pow(sum, 1.0 / 3);
        return std::clamp(int(std::pow(2.0, std::round(std::log2(std::max(s, 1.0))))), 16, most);
    }
    const auto spared = uint64_t(q * double(all));
    int bin = Demand::kBins - 1;
    while (bin > 0 && above + demand.receivers[size_t(bin)] <= spared) above += demand.receivers[size_t(bin--)];
    return std::clamp(int(std::pow(2.0, std::round(std::log2(16 * std::pow(2.0, (bin + .5 + 2 * bias) / 2))))), Demand::kLeast, most);
}

const std::vector<int>& SizeChooser::update(std::span<const Demand> demands) {
    for (size_t i = sides_.size(); i < demands.size(); ++i) {
        sides_.push_back(wanted(demands[i], most_));
        waits_.emplace_back();
    }
    for (size_t i = 0; i < demands.size(); ++i) {
        const int wish = wanted(demands[i], most_);
        Wait& wait = waits_[i];
        if (2 * wish > sides_[i]) {
            sides_[i] = std::max(sides_[i], wish);
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

DemandEstimate::DemandEstimate(const frame::Frame& frame, const std::vector<std::string>& defines) : frame_(frame) {
    std::vector<std::string> all = defines;
    all.push_back(fmt::format("BINS {}", Demand::kBins));
    all.push_back(fmt::format("BINS_PER_OCTAVE {}.0", Demand::kBinsPerOctave));
    all.push_back(fmt::format("LEAST {}.0", Demand::kLeast));
    // A plane that grazes the light wants texels without bound for shadows that nobody sees on it.
    all.push_back("LEAST_FACING 0.05");
    program_ = gl::Program::compute("shadow/instanced_demand.comp", all);
}

DemandEstimate::~DemandEstimate() {
    for (Slot& slot : slots_) glDeleteSync(slot.fence);
}

void DemandEstimate::record(size_t maps, const std::function<void(const gl::Program&)>& bind, measure::Ledger& tally) {
    Slot& slot = slots_[next_];
    if (slot.fence) return;  // three are under way: this frame is not measured
    next_ = (next_ + 1) % slots_.size();
    slot.maps = maps;
    const std::vector<Demand> zero(maps);
    slot.buffer.update(maps * sizeof(Demand), zero.data());
    bind(program_);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, slot.buffer.name());
    constexpr int kTile = 64;  // pixels: 16 threads, every fourth pixel
    glDispatchCompute(GLuint(frame_.camera().width + kTile - 1) / kTile, GLuint(frame_.camera().height + kTile - 1) / kTile, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    slot.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    ++tally.drawCalls;
}

std::optional<std::vector<Demand>> DemandEstimate::result(bool wait) {
    std::optional<std::vector<Demand>> latest;
    for (size_t i = 0; i < slots_.size(); ++i) {
        Slot& slot = slots_[(next_ + i) % slots_.size()];  // oldest first
        if (!slot.fence) continue;
        const GLenum state = glClientWaitSync(slot.fence, wait ? GL_SYNC_FLUSH_COMMANDS_BIT : 0, wait ? ~GLuint64(0) : 0);
        if (state == GL_TIMEOUT_EXPIRED) break;
        glDeleteSync(std::exchange(slot.fence, nullptr));
        latest.emplace(slot.maps);
        glGetNamedBufferSubData(slot.buffer.name(), 0, GLsizeiptr(slot.maps * sizeof(Demand)), latest->data());
    }
    return latest;
}

}  // namespace dapple::shadow
