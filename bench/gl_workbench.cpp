#include "bench/gl_workbench.h"

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "bench/gl_point.h"
#include "bench/stress.h"
#include "scenegen/texture_size.h"
#include "truth/metrics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace dapple::bench {
namespace {

using nlohmann::json;

std::string sceneKey(const std::string& scene, const std::vector<std::string>& settings, const std::string& stressCase) {
    return fmt::format("{}\n{}\n{}", scene, fmt::join(settings, "\n"), stressCase);
}

}  // namespace

void LoadedScene::moveTo(double seconds) {
    if (scene.motions.empty() || seconds == scene.time) return;
    scene.moveTo(seconds);
    gpu.instancesMoved();
    if (tracer) tracer->instancesMoved(scene);
}

void SharedFrame::moveTo(const MotionPath& path, int frameOfPath) {
    loaded->moveTo(loaded->start + frameOfPath * path.secondsPerFrame);
    if (path.secondsPerFrame != 0) frame.instancesMoved();
    frame.setSun(path.at(loaded->scene.sun, frameOfPath));
    if (path.movesCamera()) frame.look(path.at(view, frameOfPath));
    pathFrame = frameOfPath;
}

truth::Receivers SharedFrame::receivers() {
    frame::PassObserver silent;
    const std::vector<frame::Pass> gbuffer{frame.gbufferPass()};
    frame::execute(gbuffer, silent);
    if (!loaded->tracer) loaded->tracer.emplace(loaded->scene);
    return frame.readReceivers();
}

const std::vector<uint32_t>& SharedFrame::contributors(size_t sun) {
    const frame::OfSun guard(frame, sun);
    const auto [known, made] = contributing.try_emplace({pathFrame, sun});
    if (made) {
        const truth::Receivers seen = receivers();
        known->second = loaded->tracer->contributors(seen, frame.camera().eye, frame.light());
    }
    return known->second;
}

truth::Reference SharedFrame::trace() {
    const truth::Receivers seen = receivers();
    // No direct light at all: nothing that a technique could get right or wrong.
    if (!frame.sunUp()) return {seen.width, seen.height, std::vector<truth::Label>(seen.present.size(), truth::Label::excluded), {}};
    base::Hasher content;  // receivers in sight do not tell where casters out of sight are
    content.value(loaded->hash);
    content.value(loaded->scene.time);
    const uint64_t hash = loaded->scene.time == loaded->start ? loaded->hash : content.digest();
    return truth::cachedReference(*loaded->tracer, hash, seen, frame.camera().eye, frame.light(), base::cacheFolder() / "reference");
}

const truth::Reference& SharedFrame::reference(size_t sun) {
    const frame::OfSun guard(frame, sun);
    const std::pair key{pathFrame, sun};
    if (const auto known = traced.find(key); known != traced.end()) return known->second;
    return traced.emplace(key, trace()).first->second;
}

double SharedFrame::halfPixelSensitivity(size_t sun) {
    const std::pair key{pathFrame, sun};
    if (const auto known = sensitivities.find(key); known != sensitivities.end()) return known->second;
    const truth::Reference& here = reference(sun);
    const frame::OfSun guard(frame, sun);
    std::vector<truth::Reference> shifted;
    for (const glm::dvec2& pixels : {glm::dvec2(0.5, 0), glm::dvec2(0, 0.5)}) {
        frame.shiftBy(pixels);
        shifted.push_back(trace());
    }
    frame.shiftBy({0, 0});
    return sensitivities[key] = truth::halfPixelSensitivity(here, shifted);
}

GlWorkbench::GlWorkbench(int device, const std::string& backend)
    : context_(gl::Context::headless(device)), identity_(gl::identify()) {
    if (backend.empty() && report().chosen.empty())
        throw base::Error(base::ExitCode::failed, "no timer can be trusted here: even glFinish does not wait; `dapple doctor` says more");
    timer_ = measure::makeTimer(backend.empty() ? report().chosen : backend);
}

const measure::TimerReport& GlWorkbench::report() {
    if (!report_) report_ = measure::testTimers();
    return *report_;
}

std::string GlWorkbench::timerRejected() {
    for (const measure::BackendVerdict& verdict : report().verdicts)
        if (verdict.backend == backend() && !verdict.accepted) return verdict.reason;
    return {};
}

shadow::Limits GlWorkbench::limits() const { return {identity_.maxTextureSize, identity_.maxArrayLayers}; }

std::shared_ptr<LoadedScene> GlWorkbench::load(const std::string& name, const std::vector<std::string>& settings, const std::string& stress) {
    auto& entry = scenes_[sceneKey(name, settings, stress)];
    if (!entry) {
        scenegen::Scene scene = loadScene(name, settings, stress);
        scenegen::fitTextures(scene, identity_.maxTextureSize);
        entry = std::make_shared<LoadedScene>(std::move(scene));
    }
    return entry;
}

SceneFacts GlWorkbench::sceneFacts(const std::string& name, const std::vector<std::string>& settings, const std::string& stress) {
    const auto loaded = load(name, settings, stress);
    SceneFacts facts{loaded->gpu.facts(), loaded->hash, {}, loaded->scene.sun};
    for (const scenegen::View& view : loaded->scene.views) facts.views.push_back(view.name);
    return facts;
}

std::shared_ptr<SharedFrame> GlWorkbench::sharedFrame(const PointSpec& spec) {
    const long limit = identity_.maxTextureSize;
    if (spec.width < 1 || spec.height < 1 || spec.width > limit || spec.height > limit)
        throw base::UsageError(fmt::format("resolution {}×{} is outside 1 … {} pixels", spec.width, spec.height, limit));
    const std::string key = fmt::format("{}\n{}\n{}x{}", sceneKey(spec.scene, spec.sceneSettings, spec.stressCase), spec.view, spec.width, spec.height);
    if (auto alive = frames_[key].lock()) return alive;
    auto loaded = load(spec.scene, spec.sceneSettings, spec.stressCase);
    const scenegen::View& view = loaded->scene.views[loaded->scene.viewIndex(spec.view)];
    auto made = std::make_shared<SharedFrame>(loaded, view, spec.width, spec.height);
    frames_[key] = made;
    return made;
}

std::unique_ptr<OpenPoint> GlWorkbench::open(const PointSpec& spec) {
    auto shared = sharedFrame(spec);
    shared->moveTo(spec.path.value_or(MotionPath{}), 0);
    return makeGlPoint(std::move(shared), *timer_, spec);
}

std::string GlWorkbench::identityJson() {
    GLint profileBits = 0;
    glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &profileBits);
    json identity{{"gl_vendor", identity_.vendor},
                  {"gl_renderer", identity_.renderer},
                  {"gl_version", identity_.version},
                  {"glsl_version", identity_.glsl},
                  {"platform", context_.platform()},
                  {"driver_class", identity_.software ? "software" : "hardware"},
                  {"query_bits", {{"time_elapsed", profileBits}}},
                  {"max_texture_size", identity_.maxTextureSize},
                  {"doctor", json::parse(report().json())},
                  {"shader_hash", base::hex16(gl::shaderTreeHash())}};
    return identity.dump();
}

void GlWorkbench::releaseScene(const std::string& scene) {
    std::erase_if(scenes_, [&](const auto& entry) { return entry.first.starts_with(scene + "\n"); });
    std::erase_if(frames_, [](const auto& entry) { return entry.second.expired(); });
}

std::unique_ptr<Workbench> makeGlWorkbench(int device, const std::string& backend) {
    return std::make_unique<GlWorkbench>(device, backend);
}

}  // namespace dapple::bench
