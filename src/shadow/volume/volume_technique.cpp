// Shadow volumes (Crow 1977, "Shadow Algorithms for Computer Graphics") of silhouettes extruded on the GPU, counted behind
// the scene, so that neither the eye nor the near plane need lie outside of them (z-fail with depth clamp: Everitt & Kilgard
// 2002, "Practical and Robust Stenciled Shadow Volumes for Hardware-Accelerated Rendering", section 3). Exact up to the
// rasteriser's grid: no map, no bias. Closed casters only.
#include "shadow/families.h"

#include "shadow/lit_start.h"
#include "shadow/volume/silhouette_volumes.h"

namespace dapple::shadow {
namespace {

class VolumeTechnique final : public Technique {
public:
    VolumeTechnique(frame::Frame& frame, const Settings& settings)
        : frame_(frame), sums_(settings.at("count") == "sum"), start_(frame, sums_ ? LitStart::Depth::none : LitStart::Depth::withStencil),
          volumes_(frame, [](const scenegen::Prototype&) { return true; }, sums_ ? SilhouetteVolumes::Count::sum : SilhouetteVolumes::Count::stencil,
                   settings.at("cull") == "frustum", sums_ ? frame.depth() : start_.depth()) {}

    std::vector<frame::Pass> passes() override {
        const std::string leftOut = !volumes_.empty() ? "" : "the scene has no caster";
        const std::string depth = sums_ ? "depth" : "depth-copy";
        frame::Pass begin{"begin", {"gbuffer", "depth"}, {"visibility"}, "lit where the surface faces the sun", "",
                          [this](measure::Ledger& tally) { start_.record(tally); }};
        if (!sums_) {
            begin.writes.push_back(depth);
            begin.why += "; depth with a stencil";
        }
        return {begin,
                {"volumes", {depth}, {"count"}, "shadow volumes that begin and end behind each pixel", leftOut,
                 [this](measure::Ledger& tally) { volumes_.count(tally); }},
                {"dark", {"visibility", "count"}, {"visibility"}, "dark where a volume holds the pixel", leftOut,
                 [this](measure::Ledger& tally) { volumes_.darken(tally); }}};
    }

    bool countOverdraw() override {
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, frame_.overdrawTarget().name());
        const float zero[4] = {0, 0, 0, 0};
        glClearBufferfv(GL_COLOR, 0, zero);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        volumes_.addOverdraw();
        gl::resetState();
        return true;
    }

private:
    frame::Frame& frame_;
    bool sums_;
    LitStart start_;
    SilhouetteVolumes volumes_;
};

}  // namespace

std::unique_ptr<Technique> makeVolume(frame::Frame& frame, const Settings& settings) {
    return std::make_unique<VolumeTechnique>(frame, settings);
}

}  // namespace dapple::shadow
