#include "bench/best_points.h"
#include "bench/pictures.h"
#include "bench/run.h"
#include "bench/run_folder.h"
#include "bench/scripts.h"
#include "bench/verbs/verbs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

constexpr size_t kBest = 5;
constexpr const char* kSweep = "quick";
constexpr const char* kPictures = "pictures";

/// Removes what an earlier quick left, and nothing else: a folder that is not one is refused.
void removeEarlierQuick(const fs::path& folder) {
    RunFolder::removeRun(folder, kSweep);
    fs::remove_all(folder / kPictures);
    if (!fs::is_directory(folder)) return;
    for (const fs::directory_entry& entry : std::vector<fs::directory_entry>(fs::directory_iterator(folder), {})) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("work_precision_") || name == "table.csv" || name == "table.md") fs::remove(entry.path());
    }
}

std::vector<PointSpec> specsOf(const std::vector<MeasuredPoint>& points, const Plan& plan) {
    std::vector<PointSpec> specs;
    for (const PlannedPoint& planned : plan.points)
        if (std::any_of(points.begin(), points.end(), [&](const MeasuredPoint& p) { return p.pointId == planned.id; }))
            specs.push_back(planned.spec);
    return specs;
}

void quick(const CLI::App& app, const std::string& folder) {
    const Sweep sweep = readSweep(kSweep);
    RunFolder::check(folder, true);
    const auto workbench = makeWorkbench(app);
    const Plan plan = makePlan(sweep, *workbench);
    removeEarlierQuick(folder);
    const RunOutcome outcome = runPlan(plan, *workbench, {.folder = folder, .resume = false});

    const std::vector<MeasuredPoint> best = bestPoints(measuredPoints(fs::path(folder) / "metrics.csv"), kBest);
    const std::vector<std::string> pictures = renderPictures((fs::path(folder) / kPictures).string(), *workbench, specsOf(best, plan));
    plotRun(folder);

    fmt::print("{}\n\nplot      {}\ntable     {}/table.md\npictures  {}\n\n", sweep.question, plotOf(folder), folder,
               pictures.empty() ? std::string("none: the fake back-end draws nothing") : (fs::path(folder) / kPictures).string());
    fmt::print("The best of {} points, fastest first:\n{}", outcome.points, bestPointsTable(best, plan));
    requireClean(outcome, folder);
}

}  // namespace

void addQuick(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("quick", "The main result in minutes: measure forest-small, draw the plot and pictures, name the best points");
    auto folder = std::make_shared<std::string>("out/quick");
    verb->add_option("-o,--output", *folder, "folder for the result; an earlier quick's is replaced")->capture_default_str();
    verb->footer("Examples:\n  dapple quick\n  dapple quick -o /tmp/quick");
    verb->callback([&app, folder] { quick(app, *folder); });
}

}  // namespace dapple::bench
