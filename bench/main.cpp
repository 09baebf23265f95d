#include "base/error.h"
#include "bench/verbs/verbs.h"

#include <CLI/Error.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>

namespace dapple::bench {
namespace {

int parseAndRun(int argc, char** argv) {
    CLI::App app{"Dapple measures sun shadows in outdoor scenes: error against time.\n"
                 "stdout is data, stderr is progress. Exit codes: 0 clean, 2 usage, 4 damaged data, 5 a measurement failed, 130 interrupted.",
                 "dapple"};
    addGlobalOptions(app);
    for (auto* add : {addQuick, addScene, addList, addPlan, addRun, addRender, addPlot, addDoctor, addView, addBundle}) add(app);
    app.allow_extras();  // after the verbs, which do not inherit it: an unknown verb is answered below
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e);  // --help
        throw base::UsageError(fmt::format("{}; see dapple {}--help", e.what(),
                                           app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name() + " "));
    }
    if (!app.get_subcommands().empty()) return 0;
    std::vector<std::string> verbs;
    for (const CLI::App* verb : app.get_subcommands(nullptr)) verbs.push_back(verb->get_name());
    const std::vector<std::string> rest = app.remaining();
    if (rest.empty()) throw base::UsageError(fmt::format("name a verb: {}; dapple quick does the main job", fmt::join(verbs, ", ")));
    if (rest.front().starts_with("-")) throw base::UsageError(fmt::format("unknown option {}; see dapple --help", rest.front()));
    throw base::UsageError(base::unknownName("verb", rest.front(), verbs));
}

int report(base::ExitCode code, std::string line) {
    std::replace(line.begin(), line.end(), '\n', ' ');
    fmt::print(stderr, "dapple: {}\n", line);
    return static_cast<int>(code);
}

int reportStdout() { return report(base::ExitCode::usage, "cannot write to stdout: is the disk full?"); }

int guardedMain(int argc, char** argv) {
    try {
        const int code = parseAndRun(argc, argv);
        return std::fflush(stdout) == 0 ? code : reportStdout();
    } catch (const base::Error& e) {
        std::fflush(stdout);
        return report(e.code(), e.what());
    } catch (const std::filesystem::filesystem_error& e) {
        return report(base::ExitCode::usage, fmt::format("{}: {}", e.path1().string(), e.code().message()));
    } catch (const std::bad_alloc&) {
        return report(base::ExitCode::failed, "out of memory; try a smaller scene or map");
    } catch (const std::exception& e) {
        if (std::ferror(stdout)) return reportStdout();  // more than its buffer holds
        return report(base::ExitCode::failed, fmt::format("internal error: {}", e.what()));
    }
}

}  // namespace
}  // namespace dapple::bench

int main(int argc, char** argv) { return dapple::bench::guardedMain(argc, argv); }
