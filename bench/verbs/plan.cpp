#include "base/error.h"
#include "base/log.h"
#include "bench/plan.h"
#include "bench/verbs/sweep_options.h"
#include "bench/verbs/verbs.h"
#include "gl/context.h"

#include <fmt/format.h>

namespace dapple::bench {
namespace {

/// Those of this machine's GL, or the usual ones where there is none: a plan may be made anywhere.
shadow::Limits limitsHere(const GlobalOptions& global) {
    if (global.backend == "fake") return {};
    try {
        const gl::Context context = gl::Context::headless(global.device);
        const gl::Identity id = gl::identify();
        return {id.maxTextureSize, id.maxArrayLayers};
    } catch (const base::UsageError& none) {
        if (global.device >= 0) throw;
        const shadow::Limits usual;
        base::logInfo(fmt::format("planned for textures of {}² texels and {} layers, as no GL is here: {}",
                                  usual.maxTextureSize, usual.maxArrayLayers, none.what()));
        return usual;
    }
}

}  // namespace

void addPlan(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("plan", "Print the points of a sweep as plan.csv, and why others are pruned");
    auto options = std::make_shared<SweepOptions>();
    options->addTo(*verb);
    verb->footer(
        "Examples:\n  dapple plan quick\n  dapple plan bench/sweeps/forest-105.toml --filter 'uniform|lispsm' -a "
        "size=512,1024");
    verb->callback([&app, options] {
        const Sweep sweep = options->read();
        const PointFilter filter(options->filters);
        const auto workbench = makeFakeWorkbench(1, limitsHere(globalOptions(app)));  // nothing is measured
        fmt::print("{}", makePlan(sweep, *workbench, filter).csv());
    });
}

}  // namespace dapple::bench
