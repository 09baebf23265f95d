#include "bench/run.h"

#include "base/log.h"
#include "bench/run_folder.h"
#include "bench/scripts.h"
#include "bench/verbs/sweep_options.h"
#include "bench/verbs/verbs.h"

#include <fmt/format.h>

namespace dapple::bench {

void addRun(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("run", "Measure every point of a sweep and write the files of a run");
    auto options = std::make_shared<SweepOptions>();
    auto run = std::make_shared<RunOptions>();
    options->addTo(*verb);
    verb->add_option("-o,--output", run->folder, "folder for plan.csv, metrics.csv, samples.csv and run.json; new or empty")->required();
    verb->add_flag("--resume", run->resume, "go on with a run that was killed; finished points are kept");
    verb->footer("Examples:\n  dapple run quick -o out/quick\n  dapple run bench/sweeps/real.toml -o out/real --filter forza\n"
                 "  dapple run forest-105 -o out/f105 --resume\n  dapple run convergence -o out/c -a size=256,4096");
    verb->callback([&app, options, run] {
        const Sweep sweep = options->read();
        const PointFilter filter(options->filters);
        RunFolder::check(run->folder, run->resume);
        fetchRealScenes(sweep.scenes);
        const auto workbench = makeWorkbench(app);
        const Plan plan = makePlan(sweep, *workbench, filter);
        requireClean(runPlan(plan, *workbench, *run), run->folder);
        base::logInfo(fmt::format("wrote {0}/metrics.csv; draw it with: dapple plot {0}", run->folder));
    });
}

}  // namespace dapple::bench
