#include "bench/plan.h"
#include "bench/verbs/sweep_options.h"
#include "bench/verbs/verbs.h"

#include <fmt/format.h>

namespace dapple::bench {

void addPlan(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("plan", "Print the points of a sweep as plan.csv, and why others are pruned");
    auto options = std::make_shared<SweepOptions>();
    options->addTo(*verb);
    verb->footer("Examples:\n  dapple plan quick\n  dapple plan bench/sweeps/forest-105.toml --filter 'uniform|lispsm' -a size=512,1024\n"
                 "  dapple --backend fake plan stability   (without GL)");
    verb->callback([&app, options] {
        const Sweep sweep = options->read();
        const PointFilter filter(options->filters);
        fmt::print("{}", makePlan(sweep, *makeWorkbench(app), filter).csv());
    });
}

}  // namespace dapple::bench
