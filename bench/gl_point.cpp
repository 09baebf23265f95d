#include "bench/gl_point.h"

#include "base/error.h"
#include "measure/counters.h"
#include "measure/counters/overdraw.h"
#include "measure/counters/pipeline.h"
#include "truth/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace dapple::bench {
namespace {

Figure figure(std::string_view pass, std::string_view metric, std::optional<double> value, std::string_view flags = {}) {
    const measure::MetricInfo& info = measure::metricInfo(metric);
    return {std::string(pass), std::string(metric), std::string(info.unit), std::string(measure::betterName(info.better)), value,
            std::string(flags)};
}

class TimedPasses final : public frame::PassObserver {
public:
    explicit TimedPasses(measure::Timer& timer) : timer_(timer) {}
    void beginPass(const frame::Pass&) override { timer_.beginPass(); }
    void endPass(const frame::Pass&, const measure::Ledger&) override { timer_.endPass(); }

private:
    measure::Timer& timer_;
};

class CountedPasses final : public frame::PassObserver {
public:
    void beginPass(const frame::Pass& pass) override { counters_.begin(pass.name, pass.asksOcclusion); }
    measure::Counters* counters() override { return &counters_; }
    void endPass(const frame::Pass&, const measure::Ledger& ledger) override {
        counters_.end();
        ledgers.push_back(ledger);
    }
    std::vector<measure::PassCounters> results() { return counters_.results(); }
    std::vector<measure::Ledger> ledgers;

private:
    measure::Counters counters_;
};

class GlPoint final : public OpenPoint {
public:
    GlPoint(std::shared_ptr<SharedFrame> shared, measure::Timer& timer, const PointSpec& spec)
        : shared_(std::move(shared)), timer_(timer), freeBefore_(measure::driverFreeBytes()),
          renderer_(shared_->frame, shadow::technique(spec.technique), spec.settings), passNames_(frame::runningPasses(renderer_.passes())), path_(spec.path) {
        gl::checkErrors(("making technique " + spec.technique).c_str());
        driverBytes_ = measure::driverFreeBytes();
        if (driverBytes_) driverBytes_ = *freeBefore_ - std::min(*driverBytes_, *freeBefore_);
        if (!path_) return;
        // Passes that only a sun that has moved makes necessary are passes of every frame.
        shared_->moveTo(*path_, 1);
        renderer_.replan();
        passNames_ = frame::runningPasses(renderer_.passes());
    }

    const std::vector<std::string>& passNames() const override { return passNames_; }

    void beginBlocks() override {
        submitted_ = 0;
        if (path_) restart();
    }

    void submitFrame(bool perPass) override {
        if (path_) moveTo(path_->frameOf(submitted_++));
        TimedPasses observer(timer_);
        timer_.beginFrame(perPass);
        renderer_.render(observer);
        timer_.endFrame();
    }

    std::vector<measure::FrameTimes> drain() override {
        std::vector<measure::FrameTimes> frames = timer_.drain();
        gl::checkErrors("timed frames");
        return frames;
    }

    std::vector<Figure> counters() override {
        if (!path_) return countersOfFrame(true);
        return overPath([&](int frame) { return countersOfFrame(frame == path_->frames - 1); });
    }

    std::vector<Figure> errors() override {
        if (!renderer_.hasVisibility()) return {};
        if (!path_) return errorsOfFrame();
        std::vector<float> before;
        const truth::Reference* referenceBefore = nullptr;
        truth::Receivers receiversBefore;
        std::optional<frame::Camera> cameraBefore;
        const auto remember = [&](const truth::Reference& reference, std::vector<float> visibility) {
            before = std::move(visibility);
            referenceBefore = &reference;
            if (!path_->movesCamera()) return;
            receiversBefore = shared_->receivers();
            cameraBefore = shared_->frame.camera();
        };
        return overPath([&](int frame) {
            if (frame == 1) {
                std::vector<float> first = renderer_.visibility();
                moveTo(0);
                remember(shared_->reference(), std::move(first));
                moveTo(1);
            }
            std::vector<Figure> figures = errorsOfFrame();
            std::vector<float> now = renderer_.visibility();
            const truth::Reference& reference = shared_->reference();
            std::vector<int32_t> same;
            if (cameraBefore) {
                const frame::Camera& camera = shared_->frame.camera();
                same = truth::correspondence(receiversBefore, cameraBefore->clipFromRelative, shared_->receivers(), camera.eye - cameraBefore->eye);
            }
            const truth::Flips flips = truth::measureFlips(*referenceBefore, reference, before, now, same);
            figures.push_back(figure("", "flips", flips.image));
            figures.push_back(figure("", "reference_flips", flips.reference));
            figures.push_back(figure("", "excess_flips", flips.excess()));
            const auto staleness = renderer_.technique() ? renderer_.technique()->staleness() : std::nullopt;  // of the sun that moves
            if (staleness) {
                figures.push_back(figure("", "map_age_mean", staleness->meanFrames));
                figures.push_back(figure("", "map_age_worst", staleness->worstFrames));
                figures.push_back(figure("", "map_lag_mean", staleness->meanDegrees));
                figures.push_back(figure("", "map_lag_worst", staleness->worstDegrees));
            }
            remember(reference, std::move(now));
            return figures;
        });
    }

    std::vector<PassNote> leftOut() const override {
        std::vector<PassNote> notes;
        for (const std::string& dropped : shared_->loaded->scene.dropped) notes.push_back({"scene", dropped});
        for (const frame::Pass& pass : renderer_.passes())
            if (!pass.leftOut.empty()) notes.push_back({pass.name, pass.leftOut});
        return notes;
    }
    std::string fallback() const override { return renderer_.fallback(); }

private:
    void moveTo(int frame) {
        shared_->moveTo(*path_, frame);
        if (!path_->movesCamera()) return;
        renderer_.replan();
        if (frame::runningPasses(renderer_.passes()) != passNames_)
            throw base::Error(base::ExitCode::failed, fmt::format("frame {} of the path needs other passes than frame 1, so that their times cannot be told together", frame));
    }

    /// To the path's beginning, with nothing late.
    void restart() {
        moveTo(0);
        renderer_.refresh();
    }

    /// Means of what `figuresOf` gives in frames 1, 2 … of the path, after a frame 0; one that any frame misses is missing.
    template <class Figures>
    std::vector<Figure> overPath(const Figures& figuresOf) {
        restart();
        frame::PassObserver silent;
        renderer_.render(silent);
        std::vector<Figure> figures;
        std::map<std::pair<std::string, std::string>, std::pair<size_t, std::vector<double>>> series;  // by pass and metric
        for (int frame = 1; frame < path_->frames; ++frame) {
            moveTo(frame);
            for (Figure& f : figuresOf(frame)) {
                const auto [entry, isNew] = series.try_emplace({f.pass, f.metric}, figures.size(), std::vector<double>{});
                if (f.value) entry->second.second.push_back(*f.value);
                if (isNew) figures.push_back(std::move(f));
            }
        }
        for (auto& [key, found] : series) {
            auto& [index, values] = found;
            if (values.empty()) continue;
            figures[index].value = std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
            if (values.size() > 1) figures[index].spread = measure::summarise(std::span(&values, 1), 0);
        }
        return figures;
    }

    /// `all`: with those that take frames of their own.
    std::vector<Figure> countersOfFrame(bool all) {
        CountedPasses observer;
        renderer_.render(observer);
        const std::vector<measure::PassCounters> passes = observer.results();
        std::vector<Figure> figures;
        std::map<std::string_view, std::optional<uint64_t>> totals;
        measure::Ledger total;
        for (size_t i = 0; i < passes.size(); ++i) {
            for (const measure::CounterValue& counter : passes[i].values) {
                figures.push_back(figure(passes[i].pass, counter.metric, counter.value, counter.missing));
                auto& sum = totals.try_emplace(counter.metric, 0).first->second;
                sum = sum && counter.value ? std::optional(*sum + *counter.value) : std::nullopt;
            }
            if (passes[i].overshade()) figures.push_back(figure(passes[i].pass, "overshade", passes[i].overshade()));
            appendLedger(figures, passes[i].pass, observer.ledgers[i]);
            total += observer.ledgers[i];
        }
        for (const auto& [metric, sum] : totals) figures.push_back(figure("", metric, sum));
        appendLedger(figures, "", total);
        appendQueries(figures);
        double texels = 0, texelsInUse = 0;
        std::optional<double> planned;
        for (size_t sun = 0; sun < renderer_.suns(); ++sun) {
            const shadow::Technique* technique = renderer_.technique(sun);
            if (!technique) continue;
            texels += double(technique->texels());
            texelsInUse += double(technique->texelsInUse());
            if (const auto bytes = technique->plannedMapBytes()) planned = planned.value_or(0) + double(*bytes);
        }
        figures.push_back(figure("", "texels_in_use", texelsInUse));
        if (!all) return figures;
        figures.push_back(figure("", "texels_allocated", texels));
        figures.push_back(figure("", "texture_bytes", double(renderer_.mapBytes())));
        if (planned) figures.push_back(figure("", "planned_map_bytes", planned));
        figures.push_back(figure("", "driver_bytes", driverBytes_, driverBytes_ ? "" : "the driver does not tell"));
        appendCasters(figures);
        if (renderer_.hasVisibility()) appendOverdraw(figures, "geometry", renderer_.geometryOverdraw());
        if (const auto volumes = renderer_.volumeOverdraw()) appendOverdraw(figures, "volume", *volumes);
        if (const auto volumes = renderer_.candidates()) {
            const std::vector<float>& n = volumes->texels;
            figures.push_back(figure("", "candidates", double(std::count_if(n.begin(), n.end(), [](float v) { return v > 0; }))));
            figures.push_back(figure("", "candidates_mean", std::accumulate(n.begin(), n.end(), 0.0) / double(n.size())));
        }
        if (const auto referenced = renderer_.texelsReferenced())
            figures.push_back(figure("", "texels_referenced", double(*referenced)));
        return figures;
    }

    /// Of the frame as it is, rendered once more: of each sun, in rows of its own where there are several, and their means.
    std::vector<Figure> errorsOfFrame() {
        const size_t suns = shared_->frame.suns();
        for (size_t sun = 0; sun < suns; ++sun) shared_->halfPixelSensitivity(sun);  // it renders, as the reference does
        frame::PassObserver silent;
        renderer_.render(silent);
        std::vector<Figure> means = errorsOf(0);
        if (suns == 1) return means;
        std::vector<Figure> figures;
        for (size_t sun = 0; sun < suns; ++sun) {
            std::vector<Figure> own = errorsOf(sun);
            for (size_t i = 0; i < own.size(); ++i) {
                own[i].pass = fmt::format("sun {}", sun + 1);
                if (sun == 0) continue;
                if (means[i].value && own[i].value) *means[i].value += *own[i].value;
                else means[i].value.reset();
                if (means[i].flags.empty()) means[i].flags = own[i].flags;
            }
            figures.insert(figures.end(), own.begin(), own.end());
        }
        for (Figure& mean : means)
            if (mean.value) *mean.value /= double(suns);
        figures.insert(figures.begin(), means.begin(), means.end());
        return figures;
    }

    std::vector<Figure> errorsOf(size_t sun) {
        const truth::Reference& reference = shared_->reference(sun);
        const std::vector<float> visibility = renderer_.visibility(sun);
        const bool finite = std::all_of(visibility.begin(), visibility.end(), [](float v) { return std::isfinite(v); });
        const truth::ErrorMetrics e = truth::measureError(reference, visibility);
        const std::string flags = finite ? "" : "nonfinite";
        std::vector<Figure> figures;
        const auto add = [&](const char* metric, std::optional<double> value) { figures.push_back(figure("", metric, value, flags)); };
        add("error", e.error);
        add("false_shadow", e.falseShadow);
        add("false_shadow_boundary", e.falseShadowBoundary);
        add("false_shadow_interior", e.falseShadowInterior);
        add("false_light", e.falseLight);
        add("false_light_boundary", e.falseLightBoundary);
        add("false_light_interior", e.falseLightInterior);
        add("mean_absolute", e.meanAbsolute);
        add("edge_mean", e.edgeMean);
        add("edge_p95", e.edgeP95);
        add("edge_max", e.edgeMax);
        add("half_pixel_sensitivity", shared_->halfPixelSensitivity(sun));
        add("valid", e.valid);
        add("ambiguous", e.ambiguous);
        add("shadowed", e.shadowed);
        return figures;
    }

    static void appendLedger(std::vector<Figure>& figures, std::string_view pass, const measure::Ledger& ledger) {
        figures.push_back(figure(pass, "draw_calls", double(ledger.drawCalls)));
        figures.push_back(figure(pass, "triangles_submitted", double(ledger.trianglesSubmitted)));
        figures.push_back(figure(pass, "texels_written", double(ledger.texelsWritten)));
        if (ledger.texelsWritten == 0) return;
        figures.push_back(figure(pass, "map_fragments", double(ledger.mapFragments)));
        figures.push_back(figure(pass, "map_texels_filled", double(ledger.mapTexelsFilled)));
        if (ledger.mapTexelsFilled > 0) figures.push_back(figure(pass, "map_overdraw", double(ledger.mapFragments) / double(ledger.mapTexelsFilled)));
    }

    void appendCasters(std::vector<Figure>& figures) {
        const scenegen::Scene& scene = shared_->loaded->scene;
        double drawn = 0, drawnTriangles = 0, contributing = 0, triangles = 0;  // under all suns
        bool draws = false;
        for (size_t sun = 0; sun < renderer_.suns(); ++sun) {
            const auto casters = renderer_.technique(sun) ? renderer_.technique(sun)->castersDrawn() : std::nullopt;
            if (!casters) continue;
            draws = true;
            drawn += double(casters->instances);
            drawnTriangles += double(casters->triangles);
            for (const uint32_t i : shared_->contributors(sun)) ++contributing, triangles += double(scene.prototypes[scene.instances[i].prototype].triangles());
        }
        if (!draws) return;
        figures.push_back(figure("", "casters_drawn", drawn));
        figures.push_back(figure("", "caster_triangles_drawn", drawnTriangles));
        figures.push_back(figure("", "casters_contributing", contributing));
        figures.push_back(figure("", "caster_triangles_contributing", triangles));
        if (contributing > 0) figures.push_back(figure("", "casters_efficiency", drawn / contributing));
    }

    void appendQueries(std::vector<Figure>& figures) {
        for (const auto& [pass, s] : renderer_.queryStatistics()) {
            const auto add = [&, &pass = pass](const char* metric, double value) { figures.push_back(figure(pass, metric, value)); };
            add("occlusion_queries", double(s.queries));
            add("occlusion_multiqueries", double(s.multiqueries));
            add("occlusion_boxes", double(s.boxes));
            add("occlusion_bursts", double(s.bursts));
            add("occlusion_stalls", double(s.stalls));
            add("occlusion_stall_time", double(s.stallNs) * 1e-6);
            add("occlusion_nodes_visited", double(s.nodesVisited));
        }
    }

    /// `of`: geometry or volume.
    static void appendOverdraw(std::vector<Figure>& figures, const std::string& of, const base::ImageF& counts) {
        const measure::OverdrawHistogram histogram = measure::overdrawHistogram(counts.texels);
        figures.push_back(figure("", of + "_overdraw_mean", histogram.mean));
        figures.push_back(figure("", of + "_overdraw_max", double(histogram.max)));
        for (size_t i = 0; i < measure::kOverdrawBins; ++i)
            figures.push_back(figure("", of + "_overdraw_" + std::string(measure::kOverdrawBinNames[i]), double(histogram.pixels[i])));
    }

    std::shared_ptr<SharedFrame> shared_;
    measure::Timer& timer_;
    std::optional<uint64_t> freeBefore_, driverBytes_;
    shadow::Renderer renderer_;
    std::vector<std::string> passNames_;
    std::optional<MotionPath> path_;
    long submitted_ = 0;  ///< timed frames
};

}  // namespace

std::unique_ptr<OpenPoint> makeGlPoint(std::shared_ptr<SharedFrame> shared, measure::Timer& timer, const PointSpec& spec) {
    return std::make_unique<GlPoint>(std::move(shared), timer, spec);
}

}  // namespace dapple::bench
