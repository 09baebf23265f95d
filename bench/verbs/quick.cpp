#include "bench/run_folder.h"
#include "bench/summary.h"
#include "bench/verbs/verbs.h"

namespace dapple::bench {
namespace {

constexpr const char* kSweep = "quick";

void quick(const CLI::App& app, const std::string& folder) {
    const Sweep sweep = readSweep(kSweep);
    RunFolder::check(folder, true);
    const auto workbench = makeWorkbench(app);
    const Plan plan = makePlan(sweep, *workbench);
    const auto lock = FolderLock::hold(folder);  // until the plots are drawn
    RunFolder::removeRun(folder, kSweep);  // refuses a folder that holds anything else
    removeSummary(folder);
    summarise(folder, sweep, plan, *workbench, runPlan(plan, *workbench, {.folder = folder, .resume = false}));
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
