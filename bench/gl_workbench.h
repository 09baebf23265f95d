#pragma once

#include "bench/workbench.h"
#include "gl/context.h"
#include "gpuscene/gpu_scene.h"
#include "measure/doctor.h"
#include "measure/timer.h"
#include "shadow/renderer.h"

#include <map>
#include <optional>

/// The workbench that renders. The verbs that make pictures use it directly.
namespace dapple::bench {

/// A scene in memory, on the GPU and, once it is asked for, in the ray tracer.
struct LoadedScene {
    scenegen::Scene scene;
    uint64_t hash;
    gpuscene::GpuScene gpu;
    std::optional<truth::Tracer> tracer;
    double start;  ///< seconds: time at which it was loaded

    explicit LoadedScene(scenegen::Scene s) : scene(std::move(s)), hash(scene.contentHash()), gpu(scene), start(scene.time) {}
    /// Everything follows but frames, which are to be told.
    void moveTo(double seconds);
};

/// A view at a resolution, shared by all points under comparison, with its reference.
struct SharedFrame {
    std::shared_ptr<LoadedScene> loaded;
    frame::Frame frame;
    scenegen::View view;                     ///< as the scene has it
    /// By frame of the path and sun.
    std::map<std::pair<int, size_t>, truth::Reference> traced;
    std::map<std::pair<int, size_t>, double> sensitivities;
    std::map<std::pair<int, size_t>, std::vector<uint32_t>> contributing;
    int pathFrame = 0;

    SharedFrame(std::shared_ptr<LoadedScene> scene, const scenegen::View& seen, int width, int height)
        : loaded(std::move(scene)), frame(loaded->gpu, seen, width, height), view(seen) {}
    /// Puts sun, camera and moving instances where a path has them.
    void moveTo(const MotionPath& path, int frameOfPath);
    /// Casters that shadow a receiver in sight under a sun as it is now, by the reference's rays; indices into Scene::instances.
    const std::vector<uint32_t>& contributors(size_t sun = 0);
    /// The ray-traced truth of this frame, under a sun as it is now; from the cache where it is there.
    const truth::Reference& reference(size_t sun = 0);
    /// truth::halfPixelSensitivity() of that truth, half a pixel to the right and half a pixel upwards. Renders two G-buffers.
    double halfPixelSensitivity(size_t sun = 0);
    truth::Receivers receivers();  ///< of a G-buffer pass of its own

private:
    truth::Reference trace();  ///< of the G-buffer and the sun as they are
};

class GlWorkbench final : public Workbench {
public:
    /// `backend` empty: the timer is chosen by self-test. Throws UsageError: no GL, or an unknown back-end.
    GlWorkbench(int device, const std::string& backend);

    std::string backend() const override { return std::string(timer_->backend()); }
    std::string timerRejected() override;
    shadow::Limits limits() const override;
    SceneFacts sceneFacts(const std::string& scene, const std::vector<std::string>& settings, const std::string& stressCase) override;
    std::unique_ptr<OpenPoint> open(const PointSpec& spec) override;
    std::string identityJson() override;
    void releaseScene(const std::string& scene) override;

    std::shared_ptr<SharedFrame> sharedFrame(const PointSpec& spec);
    measure::Timer& timer() { return *timer_; }

private:
    const measure::TimerReport& report();
    std::shared_ptr<LoadedScene> load(const std::string& scene, const std::vector<std::string>& settings, const std::string& stressCase);

    gl::Context context_;
    gl::Identity identity_;
    std::optional<measure::TimerReport> report_;
    std::unique_ptr<measure::Timer> timer_;
    std::map<std::string, std::shared_ptr<LoadedScene>> scenes_;  ///< by name, settings and stress case
    std::map<std::string, std::weak_ptr<SharedFrame>> frames_;
};

}  // namespace dapple::bench
