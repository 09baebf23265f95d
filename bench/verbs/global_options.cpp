#include "base/error.h"
#include "bench/verbs/verbs.h"
#include "scenegen/import/file_access.h"

#include <fmt/format.h>

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
        ->type_name("NAME")
        ->check([](const std::string& name) {
            const bool known = std::ranges::find(timerNames(), name) != timerNames().end();
            return known ? std::string() : base::unknownName("timer back-end", name, timerNames());
        });
    app.add_flag_callback("--allow-outside", [] { scenegen::allowOutside(true); }, "let scene files read what lies outside their folders");
}

GlobalOptions globalOptions(const CLI::App& app) {
    GlobalOptions options;
    if (app.count("--device") > 0) options.device = app.get_option("--device")->as<int>();
    if (app.count("--backend") > 0) options.backend = app.get_option("--backend")->as<std::string>();
    return options;
}

std::span<const std::string> timerNames() {
    static const std::array<std::string, 4> kNames{"gpu_timestamp", "gpu_elapsed", "cpu_finish", "fake"};
    return kNames;
}

void requireGl(const GlobalOptions& options, const std::string& verb) {
    if (options.backend == "fake")
        throw base::UsageError(
            fmt::format("dapple {} draws pictures, and --backend fake draws none: leave it out", verb));
}

std::unique_ptr<Workbench> makeWorkbench(const CLI::App& app) {
    const GlobalOptions options = globalOptions(app);
    if (options.backend == "fake") return makeFakeWorkbench(1);
    return makeGlWorkbench(options.device, options.backend);
}

}  // namespace dapple::bench
