#include "base/error.h"
#include "base/log.h"
#include "bench/provenance.h"
#include "bench/verbs/verbs.h"

#include <CLI/Error.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>

namespace dapple::bench {
namespace {

std::string versionLine() {
    const nlohmann::ordered_json build = buildJson();
    const std::string commit = build["commit"].is_string() ? build["commit"].get<std::string>() : "unknown";
    const bool changed = build["dirty"].is_boolean() && build["dirty"].get<bool>();
    return fmt::format("dapple {}, commit {}{}, {} build by compiler {}", DAPPLE_VERSION, commit,
                       changed ? " with changes" : "", build["type"].get<std::string>(),
                       build["compiler"].get<std::string>());
}

/// Throws UsageError about a word or an option that the command line has no place for.
[[noreturn]] void refuse(const CLI::App& app, const std::string& extra, const std::vector<std::string>& words) {
    std::vector<std::string> options;
    const std::vector<CLI::App*> parsed = app.get_subcommands();
    const std::string verb = parsed.empty() ? "" : parsed.front()->get_name();
    const std::string help = verb.empty() ? "dapple --help" : fmt::format("dapple {} --help", verb);
    if (extra.starts_with("-")) {
        for (const CLI::App* level : {&app, parsed.empty() ? &app : static_cast<const CLI::App*>(parsed.front())})
            for (const CLI::Option* option : level->get_options())
                for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
        const std::string nearest = base::nearestName(extra, options);
        throw base::UsageError(fmt::format("unknown option {}{}; see {}", extra,
                                           nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest), help));
    }
    const auto verbAt = std::find(words.begin(), words.end(), verb);
    if (verb.empty() || std::find(words.begin(), verbAt, extra) != verbAt)
        throw base::UsageError(base::unknownName("verb", extra, verbNames(app)));
    throw base::UsageError(fmt::format("'{}' is one word too many for dapple {}; see {}", extra, verb, help));
}

int parseAndRun(int argc, char** argv) {
    CLI::App app{
        "Dapple measures sun shadows in outdoor scenes: error against time.\n"
        "stdout is data, stderr is progress; nothing is coloured. Exit codes: 0 clean, 2 usage, 4 damaged data, "
        "5 a measurement failed, 130 interrupted.\n"
        "The options below may stand before or after the verb; dapple VERB --help lists a verb's own.",
        "dapple"};
    app.formatter(helpFormatter());
    app.set_version_flag("--version", versionLine, "print version, commit and build");
    app.fallthrough();  // verbs inherit it, so that global options may follow them
    app.require_subcommand(0, 1);
    addGlobalOptions(app);
    for (auto* add : {addQuick, addScene, addList, addPlan, addRun, addRender, addPlot, addDoctor, addView, addBundle,
                      addHelp, addCompletion})
        add(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e);  // --help
        if (const std::vector<std::string> extra = app.remaining(true); !extra.empty())
            refuse(app, extra.front(), {argv + 1, argv + argc});
        throw base::UsageError(fmt::format("{}; see dapple {}--help", e.what(),
                                           app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name() + " "));
    }
    if (!app.get_subcommands().empty()) return 0;
    throw base::UsageError(
        fmt::format("name a verb: {}; dapple quick does the main job", fmt::join(verbNames(app), ", ")));
}

int report(base::ExitCode code, std::string line) {
    std::replace(line.begin(), line.end(), '\n', ' ');
    fmt::print(stderr, "dapple: {}\n", base::printable(line));
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
