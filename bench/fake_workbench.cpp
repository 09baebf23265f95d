#include "bench/workbench.h"

#include "base/random.h"
#include "bench/plan.h"
#include "bench/stress.h"

#include <cmath>

namespace dapple::bench {
namespace {

/// Seconds that the fake machine has worked; nothing else moves it, so that a run's times are reproducible.
using Clock = std::shared_ptr<double>;

double sizeOf(const PointSpec& spec) {
    const auto size = spec.settings.find("size");
    return size == spec.settings.end() ? 0 : std::stod(size->second);
}

/// A point that costs what its settings say: passes in fixed shares, noise of 2 %, now and then a slow frame.
class FakePoint : public OpenPoint {
public:
    FakePoint(const PointSpec& spec, uint64_t seed, Clock clock)
        : spec_(spec), noise_(seed, std::stoull(pointId(spec, 0), nullptr, 16), 0), clock_(std::move(clock)) {
        costMs_ = 4 + (hasMap() ? 1 + sizeOf(spec) * sizeOf(spec) * 1e-6 : 0);
        costMs_ *= 1 + 0.2 * static_cast<double>(noise_.uniform(uint64_t{1} << 40));
    }

    const std::vector<std::string>& passNames() const override {
        static const std::vector<std::string> kMapped{"gbuffer", "shadow_map", "resolve", "shade"}, kPlain{"gbuffer", "shade"};
        return hasMap() ? kMapped : kPlain;
    }
    void submitFrame(bool perPass) override {
        const double u = static_cast<double>(noise_.next()), slow = noise_.next() > 0.98f ? 1.5 : 1.0;
        measure::FrameTimes frame;
        frame.frameMs = costMs_ * slow * (0.98 + 0.04 * u);
        *clock_ += frame.frameMs * 1e-3;
        if (perPass) frame.passMs.assign(passNames().size(), 0.95 * frame.frameMs / static_cast<double>(passNames().size()));
        pending_.push_back(std::move(frame));
    }
    std::vector<measure::FrameTimes> drain() override { return std::exchange(pending_, {}); }

    std::vector<Figure> counters() override {
        return {{"", "triangles_submitted", "triangles", "lower", 36000.0, ""},
                {"", "texture_bytes", "B", "lower", 4 * sizeOf(spec_) * sizeOf(spec_), ""}};
    }
    std::vector<Figure> errors() override {
        const double error = hasMap() ? costMs_ / (4 * sizeOf(spec_)) : 0.3;
        return {{"", "error", "", "lower", error, ""},
                {"", "edge_mean", "px", "lower", hasMap() ? std::optional(1000 * error) : std::nullopt, ""},
                {"", "half_pixel_sensitivity", "", "none", 1e-5, ""}};
    }
    std::vector<PassNote> leftOut() const override {
        if (hasMap()) return {};
        return {{"shadow_map", "the technique has no map"}, {"resolve", "no map, nothing to look up"}};
    }
    std::string fallback() const override {
        const auto fit = spec_.settings.find("fit");
        const bool warps = fit != spec_.settings.end() && fit->second == "lispsm";
        return warps && spec_.stressCase.starts_with("parallel") ? "lispsm → focused: light ∥ view" : "";
    }

private:
    bool hasMap() const { return sizeOf(spec_) > 0; }

    PointSpec spec_;
    base::Random noise_;
    Clock clock_;
    double costMs_ = 0;
    std::vector<measure::FrameTimes> pending_;
};

class FakeWorkbench : public Workbench {
public:
    FakeWorkbench(uint64_t seed, const shadow::Limits& limits) : seed_(seed), limits_(limits) {}

    std::string backend() const override { return "fake"; }
    shadow::Limits limits() const override { return limits_; }
    SceneFacts sceneFacts(const std::string& name, const std::vector<std::string>& settings, const std::string& stress) override {
        const scenegen::Scene scene = loadScene(name, settings, stress);
        SceneFacts facts{scene.facts(), scene.contentHash(), {}, scene.sun};
        for (const scenegen::View& view : scene.views) facts.views.push_back(view.name);
        return facts;
    }
    std::unique_ptr<OpenPoint> open(const PointSpec& spec) override { return std::make_unique<FakePoint>(spec, seed_, clock_); }
    std::string identityJson() override { return R"({"driver_class":"fake"})"; }
    std::function<double()> clock() const override {
        return [clock = clock_] { return *clock; };
    }
    void releaseScene(const std::string&) override {}

private:
    uint64_t seed_;
    shadow::Limits limits_;
    Clock clock_ = std::make_shared<double>(0.0);
};

}  // namespace

std::unique_ptr<Workbench> makeFakeWorkbench(uint64_t seed, const shadow::Limits& limits) {
    return std::make_unique<FakeWorkbench>(seed, limits);
}

}  // namespace dapple::bench
