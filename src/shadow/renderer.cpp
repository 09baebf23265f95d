#include "shadow/renderer.h"

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
    : frame_(frame), info_(info), lamps_(frame), hasVisibility_(info.name != "bare"), shadowed_(info.family != "baseline") {
    if (hasVisibility_) camera_.emplace(frame, settings);
    if (shadowed_ && frame.sunUp()) technique_ = makeTechnique(frame, info, settings);
    if (shadowed_ && !frame.sunUp()) fallback_ = info.name + " → night: the sun is not above the horizon";
    replan();
}

void Renderer::replan() {
    passes_.clear();
    if (!hasVisibility_) {
        passes_.push_back(frame_.barePass());
        return;
    }
    passes_.push_back(frame_.gbufferPass(camera_->culling(), camera_->asksOcclusion()));
    if (technique_) {
        for (frame::Pass& pass : technique_->passes()) passes_.push_back(std::move(pass));
    } else if (shadowed_) {
        passes_.push_back({info_.name, {}, {}, info_.description, "the sun is not above the horizon", {}});
        passes_.push_back(nightPass(frame_));
    }
    passes_.push_back(frame_.shadePass(shadowed_));
    passes_.push_back(lamps_.pass());
    const std::vector<std::string> cached{"maps"};
    frame::check(passes_, cached);
}

std::vector<float> Renderer::visibility() const {
    if (!shadowed_) return std::vector<float>(size_t(frame_.camera().width) * size_t(frame_.camera().height), 1.0f);
    return frame_.readVisibility();
}

std::string Renderer::fallback() const {
    if (!technique_) return fallback_;
    std::string text = technique_->fallback();
    if (frame_.scene().facts().translucent && info_.family != "instanced") {
        if (!text.empty()) text += "; ";
        text += info_.name + " → opaque casters: only maps of single objects can tell how much light each lets through";
    }
    return text;
}

base::ImageF Renderer::overdraw() {
    frame::PassObserver silent;
    render(silent);  // the depth that the count is tested against
    if (!technique_ || !technique_->countOverdraw()) frame_.countGeometry();
    return frame_.readChannel(frame_.overdraw());
}

std::optional<base::ImageF> Renderer::candidates() {
    frame::PassObserver silent;
    render(silent);
    if (!technique_ || !technique_->countCandidates()) return std::nullopt;
    return frame_.readChannel(frame_.overdraw());
}

std::optional<size_t> Renderer::texelsReferenced() {
    frame::PassObserver silent;
    render(silent);
    return technique_ ? technique_->countTexelsReferenced() : std::nullopt;
}

}  // namespace dapple::shadow
