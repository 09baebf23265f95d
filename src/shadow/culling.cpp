#include "shadow/culling.h"

namespace dapple::shadow {

visibility::ViewCulling::Options cullOptions(const Settings& settings, const std::string& method, bool castersOnly) {
    visibility::ViewCulling::Options options;
    options.settings.algorithm = method == "chc" ? visibility::Algorithm::chc : visibility::Algorithm::chcpp;
    options.settings.batch = std::stoi(settings.at("batch"));
    options.settings.assumedVisible = std::stoi(settings.at("assumed-visible"));
    options.leafTriangles = std::stoull(settings.at("leaf"));
    options.castersOnly = castersOnly;
    return options;
}

CameraCulling::CameraCulling(const frame::Frame& frame, const Settings& settings)
    : frame_(frame), everything_(settings.at("camera") == "none") {
    const std::string& method = settings.at("camera");
    if (method == "chc" || method == "chcpp") view_ = std::make_unique<visibility::ViewCulling>(frame.scene(), cullOptions(settings, method, false));
    if (method == "hiz") hiz_ = std::make_unique<visibility::HizCulling>(frame.scene(), false, true);
}

frame::Frame::Culling CameraCulling::culling() {
    if (everything_)
        return [this](const gpuscene::Submit& submit) {
            frame_.scene().collect(frame_.camera().eye, [](uint32_t) { return true; }, list_);
            submit(list_);
        };
    if (hiz_)
        return [this](const gpuscene::Submit& submit) {
            const frame::Camera& camera = frame_.camera();
            // Up to twice the near plane's distance, so that no corner is close to where depths have no end.
            hiz_->draw({camera.clipFromRelative, camera.eye, 2 * camera.near, frame_.depth()}, submit);
        };
    if (!view_) return {};
    return [this](const gpuscene::Submit& submit) {
        const frame::Camera& camera = frame_.camera();
        view_->draw(visibility::CullView::camera(camera.eye, camera.clipFromRelative, camera.near), {.width = camera.width, .height = camera.height}, submit);
    };
}

}  // namespace dapple::shadow
