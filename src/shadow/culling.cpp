#include "shadow/culling.h"

#include "visibility/hiz_culling.h"
#include "visibility/query_culling.h"

#include <algorithm>

namespace dapple::shadow {

const gpuscene::Items& cullItems(const gpuscene::GpuScene& scene, const Settings& settings) { return scene.items(uint32_t(std::stoul(settings.at("cluster")))); }

std::unique_ptr<visibility::Culling> makeCulling(const gpuscene::GpuScene& scene, const Settings& settings, const std::string& method, bool sun, const glm::ivec2& pixels) {
    const gpuscene::Items& items = cullItems(scene, settings);
    if (method == "none" || method == "frustum") return std::make_unique<visibility::ListCulling>(items, sun);
    if (method == "hiz") return std::make_unique<visibility::HizCulling>(items, visibility::HizCulling::Options{.pixels = pixels, .castersOnly = sun, .reversed = !sun});
    visibility::QueryCulling::Options options;
    options.settings.algorithm = method == "chc" ? visibility::Algorithm::chc : visibility::Algorithm::chcpp;
    options.settings.batch = std::stoi(settings.at("batch"));
    options.settings.assumedVisible = std::stoi(settings.at("assumed-visible"));
    options.leafTriangles = std::stoull(settings.at("leaf"));
    options.castersOnly = sun;
    return std::make_unique<visibility::QueryCulling>(items, options);
}

CameraCulling::CameraCulling(const frame::Frame& frame, const Settings& settings)
    : frame_(frame), everything_(settings.at("camera") == "none"),
      culling_(makeCulling(frame.scene(), settings, settings.at("camera"), false, {frame.camera().width, frame.camera().height})) {}

frame::Frame::Culling CameraCulling::culling() {
    return [this](const gpuscene::Submit& submit) {
        const frame::Camera& camera = frame_.camera();
        // Up to twice the near plane's distance, so that no corner is close to where depths have no end.
        visibility::ViewFrame frame{.view = visibility::CullView::camera(camera.eye, camera.clipFromRelative, camera.near), .leastW = 2 * camera.near, .depth = &frame_.depth()};
        if (everything_) frame.view.planes.clear();
        culling_->draw(frame, submit);
    };
}

}  // namespace dapple::shadow
