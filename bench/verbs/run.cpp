#include "bench/run_folder.h"
#include "bench/scripts.h"
#include "bench/summary.h"
#include "bench/verbs/sweep_options.h"
#include "bench/verbs/verbs.h"

namespace dapple::bench {

void addRun(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("run", "Measure every point of a sweep, write its files, draw its plots and pictures");
    auto options = std::make_shared<SweepOptions>();
    auto run = std::make_shared<RunOptions>();
    options->addTo(*verb);
    verb->add_option("-o,--output", run->folder, "folder for plan.csv, metrics.csv, samples.csv and run.json; new or empty")->required();
    auto plot = std::make_shared<bool>(true);
    CLI::Option* resume = verb->add_flag("--resume", run->resume, "go on with a run that was killed; finished points are kept");
    verb->add_flag("--retry-failed", run->retryFailed, "with --resume: measure again what failed, together with what it is compared with")->needs(resume);
    verb->add_flag("--mix", run->mix, "with --resume: go on although the program or the machine is another; every row is then flagged 'mixed'")->needs(resume);
    verb->add_flag("!--no-plot", *plot, "measure only: for machines without Python");
    verb->footer("Examples:\n  dapple run quick -o out/quick\n  dapple run bench/sweeps/real.toml -o out/real --filter forza\n"
                 "  dapple run forest-105 -o out/f105 --resume --retry-failed\n  dapple run convergence -o out/c -a size=256,4096");
    verb->callback([&app, options, run, plot] {
        const Sweep sweep = options->read();
        const PointFilter filter(options->filters);
        RunFolder::check(run->folder, run->resume);
        fetchRealScenes(sweep.scenes);
        const auto workbench = makeWorkbench(app);
        const Plan plan = makePlan(sweep, *workbench, filter);
        const auto lock = FolderLock::hold(run->folder);  // until the plots are drawn
        summarise(run->folder, sweep, plan, *workbench, runPlan(plan, *workbench, *run), *plot);
    });
}

}  // namespace dapple::bench
