#pragma once

#include "bench/motion_path.h"
#include "measure/statistics.h"
#include "measure/subject.h"
#include "shadow/registry.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

/// What a run needs from the renderer. The GL workbench does the work; the fake one serves tests of the
/// tool itself with seeded costs, and needs no GL.
namespace dapple::bench {

/// One point of a sweep: what is rendered, and how.
struct PointSpec {
    std::string scene;                       ///< name or file
    std::vector<std::string> sceneSettings;  ///< key=value overrides of the recipe, the variant's among them
    std::string stressCase;                  ///< stiff case of the stability sweep; empty = as the scene is
    std::string technique;
    shadow::Settings settings;               ///< resolved: every axis of the technique
    std::string view;                        ///< name of a view of the scene
    int width = 1024, height = 768;          ///< pixels
    std::string variant;                     ///< the sweep's name for those settings that set this point's scene apart
    std::optional<MotionPath> path = {};     ///< empty: all stand still
};

/// One figure about a point, not a time: a counter or an error metric.
struct Figure {
    std::string pass;    ///< empty = the whole frame
    std::string metric;  ///< e.g. samples_passed, error
    std::string unit;    ///< "1", "px", "B", …
    std::string better;  ///< "lower", "higher" or "" (neither)
    std::optional<double> value;  ///< empty = missing
    std::string flags;
    std::optional<measure::Summary> spread = {};  ///< over the frames that `value` is the mean of; empty: of one frame
};

struct PassNote {
    std::string pass;
    std::string reason;  ///< why it is left out for this scene
};

/// A point made ready: its resources live until it is destroyed. All points of one comparison are open at once.
class OpenPoint : public measure::Subject {
public:
    virtual std::vector<Figure> counters() = 0;  ///< deterministic, from untimed frames
    virtual std::vector<Figure> errors() = 0;    ///< against the ray-traced reference; deterministic
    virtual std::vector<PassNote> leftOut() const = 0;
    virtual std::string fallback() const = 0;    ///< stated fallback in force ("lispsm → focused: light ∥ view"), or ""
};

/// Identity of what is measured and where, for run.json and for point ids.
struct SceneFacts {
    scenegen::Facts facts;
    uint64_t contentHash = 0;
    std::vector<std::string> views;
    scenegen::Sun sun = {};
};

class Workbench {
public:
    virtual ~Workbench() = default;
    virtual std::string backend() const = 0;  ///< gpu_timestamp, gpu_elapsed, cpu_finish or fake
    /// Why the self-test rejected that timer, which only --backend can force; empty where it may be trusted.
    virtual std::string timerRejected() { return {}; }
    virtual shadow::Limits limits() const = 0;
    virtual SceneFacts sceneFacts(const std::string& scene, const std::vector<std::string>& settings,
                                  const std::string& stressCase) = 0;
    /// Throws base::Error when the point cannot be made; the run records it as a failed row and goes on.
    virtual std::unique_ptr<OpenPoint> open(const PointSpec& spec) = 0;
    /// JSON text of the machine's identity: GL strings, driver class, query bits, doctor's results, CPU model.
    virtual std::string identityJson() = 0;
    /// Clock in seconds that sampled times are held against; empty: CLOCK_MONOTONIC. The fake one is simulated.
    virtual std::function<double()> clock() const { return {}; }
    /// Drops caches of a scene that no later point needs.
    virtual void releaseScene(const std::string& scene) = 0;
};

std::unique_ptr<Workbench> makeGlWorkbench(int device, const std::string& backend);  ///< device −1: automatic; backend "": by self-test
std::unique_ptr<Workbench> makeFakeWorkbench(uint64_t seed, const shadow::Limits& limits = {});

}  // namespace dapple::bench
