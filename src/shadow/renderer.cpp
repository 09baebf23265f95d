#include "shadow/renderer.h"

#include <algorithm>
#include <functional>

namespace dapple::shadow {
namespace {

/// At and below the horizon the sun reaches nothing: no technique runs, everything is dark.
frame::Pass nightPass(frame::Frame& frame) {
    return {"night", {"depth"}, {"visibility"}, "the sun is not above the horizon: no direct light anywhere", "",
            [&frame](measure::Ledger&) {
                const float dark[4] = {0, 0, 0, 0};
                glBindFramebuffer(GL_FRAMEBUFFER, frame.visibilityTarget().name());
                glClearBufferfv(GL_COLOR, 0, dark);
            }};
}

}  // namespace

Renderer::Renderer(frame::Frame& frame, const TechniqueInfo& info, const Settings& settings)
    : frame_(frame), info_(info), lamps_(frame), hasVisibility_(info.name != "bare"), shadowed_(info.family != "baseline"), techniques_(frame.suns()) {
    if (hasVisibility_) camera_.emplace(frame, settings);
    for (size_t sun = 0; shadowed_ && sun < frame.suns(); ++sun)
        forSun(sun, [&] {
            if (frame.sunUp()) techniques_[sun] = makeTechnique(frame, info, settings);
        });
    replan();
}

/// The technique's own, each under its sun. What they write is the sun's; what the view is stays common.
void Renderer::addPassesOf(size_t sun) {
    std::vector<frame::Pass> passes;
    if (techniques_[sun]) {
        passes = techniques_[sun]->passes();
    } else {
        passes.push_back({info_.name, {}, {}, info_.description, "the sun is not above the horizon", {}});
        passes.push_back(nightPass(frame_));
    }
    for (frame::Pass& pass : passes) {
        pass.name = frame::ofSun(pass.name, sun);
        for (std::vector<std::string>* resources : {&pass.reads, &pass.writes})
            for (std::string& resource : *resources)
                if (resource != "gbuffer" && resource != "depth") resource = frame::ofSun(resource, sun);
        if (sun > 0 && pass.record)
            pass.record = [this, sun, record = std::move(pass.record)](measure::Ledger& tally) { forSun(sun, [&] { record(tally); }); };
        passes_.push_back(std::move(pass));
    }
}

void Renderer::replan() {
    passes_.clear();
    if (!hasVisibility_) {
        passes_.push_back(frame_.barePass());
        return;
    }
    passes_.push_back(frame_.gbufferPass(camera_->culling(), camera_->asksOcclusion()));
    std::vector<std::string> cached;
    for (size_t sun = 0; shadowed_ && sun < frame_.suns(); ++sun) {
        forSun(sun, [&] { addPassesOf(sun); });
        cached.push_back(frame::ofSun("maps", sun));
    }
    passes_.push_back(frame_.shadePass(shadowed_));
    passes_.push_back(lamps_.pass());
    frame::check(passes_, cached);
}

std::vector<float> Renderer::visibility(size_t sun) const {
    if (!shadowed_) return std::vector<float>(size_t(frame_.camera().width) * size_t(frame_.camera().height), 1.0f);
    std::vector<float> v;
    forSun(sun, [&] { v = frame_.readVisibility(); });
    return v;
}

size_t Renderer::mapBytes() const {
    size_t bytes = 0;
    for (const auto& technique : techniques_)
        if (technique) bytes += technique->mapBytes();
    return bytes;
}

std::string Renderer::fallback() const {
    std::string text;
    const auto add = [&](size_t sun, const std::string& reason) {
        if (reason.empty()) return;
        if (!text.empty()) text += "; ";
        text += frame_.suns() > 1 ? "sun " + std::to_string(sun + 1) + ": " + reason : reason;
    };
    for (size_t sun = 0; shadowed_ && sun < techniques_.size(); ++sun)
        add(sun, techniques_[sun] ? techniques_[sun]->fallback() : info_.name + " → night: the sun is not above the horizon");
    const bool any = std::ranges::any_of(techniques_, [](const auto& technique) { return technique != nullptr; });
    if (any && frame_.scene().facts().translucent && info_.family != "instanced") {
        if (!text.empty()) text += "; ";
        text += info_.name + " → opaque casters: only maps of single objects can tell how much light each lets through";
    }
    return text;
}

std::optional<base::ImageF> Renderer::counted(bool (Technique::*count)()) {
    std::optional<base::ImageF> sum;
    for (size_t sun = 0; sun < techniques_.size(); ++sun) {
        bool has = false;
        if (techniques_[sun]) forSun(sun, [&] { has = (techniques_[sun].get()->*count)(); });
        if (!has) continue;
        const base::ImageF counts = frame_.readChannel(frame_.overdraw());
        if (!sum) sum = counts;
        else std::ranges::transform(sum->texels, counts.texels, sum->texels.begin(), std::plus());
    }
    return sum;
}

std::vector<std::pair<std::string, visibility::Statistics>> Renderer::queryStatistics() const {
    std::vector<std::pair<std::string, visibility::Statistics>> result;
    for (size_t sun = 0; sun < techniques_.size(); ++sun) {
        if (!techniques_[sun]) continue;
        for (auto& [pass, statistics] : techniques_[sun]->queryStatistics()) result.emplace_back(frame::ofSun(pass, sun), statistics);
    }
    if (camera_ && camera_->statistics()) result.insert(result.begin(), {"gbuffer", *camera_->statistics()});
    return result;
}

base::ImageF Renderer::geometryOverdraw() {
    frame_.countGeometry();
    return frame_.readChannel(frame_.overdraw());
}

std::optional<base::ImageF> Renderer::volumeOverdraw() {
    frame::PassObserver silent;
    render(silent);  // the depth that the count is tested against
    return counted(&Technique::countOverdraw);
}

std::optional<base::ImageF> Renderer::candidates() {
    frame::PassObserver silent;
    render(silent);
    return counted(&Technique::countCandidates);
}

std::optional<size_t> Renderer::texelsReferenced() {
    frame::PassObserver silent;
    render(silent);
    std::optional<size_t> sum;
    for (size_t sun = 0; sun < techniques_.size(); ++sun)
        if (techniques_[sun])
            forSun(sun, [&] {
                if (const auto texels = techniques_[sun]->countTexelsReferenced()) sum = sum.value_or(0) + *texels;
            });
    return sum;
}

}  // namespace dapple::shadow
