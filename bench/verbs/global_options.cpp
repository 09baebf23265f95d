#include "base/error.h"
#include "bench/verbs/verbs.h"
#include "scenegen/import/file_access.h"

#include <algorithm>
#include <array>

namespace dapple::bench {

void addGlobalOptions(CLI::App& app) {
    app.add_option("--device", "EGL device as `dapple doctor` lists them; default: the first that works")
        ->expected(1)
        ->type_name("N")
        ->check(CLI::Validator(CLI::NonNegativeNumber).description(""));
    app.add_option("--backend", "timer: gpu_timestamp, gpu_elapsed, cpu_finish, or fake (no GL, invented times, for tests of the tool)")
        ->expected(1)
        ->type_name("NAME");
    app.add_flag_callback("--allow-outside", [] { scenegen::allowOutside(true); }, "let scene files read what lies outside their folders");
}

GlobalOptions globalOptions(const CLI::App& app) {
    GlobalOptions options;
    if (app.count("--device") > 0) options.device = app.get_option("--device")->as<int>();
    if (app.count("--backend") > 0) options.backend = app.get_option("--backend")->as<std::string>();
    return options;
}

std::unique_ptr<Workbench> makeWorkbench(const CLI::App& app) {
    static const std::array<std::string, 4> kBackends{"gpu_timestamp", "gpu_elapsed", "cpu_finish", "fake"};
    const GlobalOptions options = globalOptions(app);
    if (options.backend == "fake") return makeFakeWorkbench(1);
    if (!options.backend.empty() && std::find(kBackends.begin(), kBackends.end(), options.backend) == kBackends.end())
        throw base::UsageError(base::unknownName("timer back-end", options.backend, kBackends));
    return makeGlWorkbench(options.device, options.backend);
}

}  // namespace dapple::bench
