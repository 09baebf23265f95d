#include "bench/summary.h"

#include "base/error.h"
#include "base/log.h"
#include "bench/best_points.h"
#include "bench/manifest.h"
#include "bench/pictures.h"
#include "bench/scripts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPictures = "pictures";

const PlannedPoint* planned(const Plan& plan, const std::string& id) {
    const auto found = std::find_if(plan.points.begin(), plan.points.end(), [&](const PlannedPoint& p) { return p.id == id; });
    return found == plan.points.end() ? nullptr : &*found;
}

}  // namespace

void summarise(const std::string& folder, const Sweep& sweep, const Plan& plan, Workbench& workbench, const RunOutcome& outcome, bool plot) {
    verifyManifest(folder);
    const std::vector<MeasuredPoint> measured = measuredPoints(fs::path(folder) / "metrics.csv");
    std::vector<PlannedPoint> pictured;
    std::string tables;
    std::vector<std::array<std::string, 3>> places;  // scene, variant and view, in the plan's order
    for (const PlannedPoint& point : plan.points)
        if (std::array place{point.spec.scene, point.spec.variant, point.spec.view}; std::ranges::find(places, place) == places.end()) places.push_back(place);
    for (const auto& place : places) {
        // A stiff case is there to be survived, not to be best.
        std::vector<MeasuredPoint> points;
        std::copy_if(measured.begin(), measured.end(), std::back_inserter(points), [&](const MeasuredPoint& p) {
            const PlannedPoint* point = planned(plan, p.pointId);
            return point && std::array{point->spec.scene, point->spec.variant, point->spec.view} == place && point->spec.stressCase.empty();
        });
        if (points.empty()) continue;
        const std::vector<MeasuredPoint> front = paretoFront(points);
        for (const MeasuredPoint& p : front) pictured.push_back(*planned(plan, p.pointId));
        tables += fmt::format("\n{}{}, view {}: {} of {} points have none that is both faster and better, fastest first:\n{}", place[0],
                              place[1].empty() ? "" : " with " + place[1], place[2], front.size(), points.size(), pointsTable(front, plan));
    }
    const fs::path pictures = fs::path(folder) / kPictures;
    const bool drawn = !pictured.empty() && !renderPictures(pictures.string(), workbench, plan, pictured).empty();
    fmt::print("{}\n\n{}/metrics.csv\n{}", sweep.question, folder, drawn ? pictures.string() + "\n" : "");
    std::fflush(stdout);  // the script prints the names of the plots and the table behind it
    std::optional<base::Error> noPlot;
    try {
        if (plot) plotRun(folder);
    } catch (const base::Error& error) {
        noPlot = error;
    }
    fmt::print("{}", tables);
    if (noPlot) base::logWarning(fmt::format("{}; the measurements are safe, draw the plot with: dapple plot {}", noPlot->what(), folder));
    requireClean(outcome, folder);
    if (noPlot) throw base::Error(noPlot->code(), fmt::format("measured, but {}", noPlot->what()));
}

void removeSummary(const std::string& folder) {
    fs::remove_all(fs::path(folder) / kPictures);
    if (!fs::is_directory(folder)) return;
    for (const fs::directory_entry& entry : std::vector<fs::directory_entry>(fs::directory_iterator(folder), {})) {
        const std::string name = entry.path().filename().string(), form = entry.path().extension().string();
        const bool figure = form == ".svg" || form == ".png" || form == ".pdf";
        if ((figure && (name.starts_with("work_precision_") || name.find("_by_") != std::string::npos)) || name == "table.csv" || name == "table.md") fs::remove(entry.path());
    }
}

}  // namespace dapple::bench
