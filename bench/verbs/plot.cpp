#include "base/error.h"
#include "bench/scripts.h"
#include "bench/verbs/verbs.h"

#include <fmt/format.h>

#include <cstdlib>

namespace dapple::bench {
namespace {

/// Throws UsageError for what is no width of a page.
std::string inches(const std::string& text) {
    char* rest = nullptr;
    const double width = std::strtod(text.c_str(), &rest);
    if ((*rest != '\0' && std::string(rest) != "in") || !(width >= 2 && width <= 40))
        throw base::UsageError(fmt::format("--width {}: write inches from 2 to 40, e.g. 3.33 or 7in", text));
    return fmt::format("{}", width);
}

}  // namespace

void addPlot(CLI::App& app) {
    struct Options {
        std::string folder, width;
        bool noTitle = false;
    };
    CLI::App* verb = app.add_subcommand("plot", "Draw the figures of a run: error against time, and what its sweep asks for");
    auto options = std::make_shared<Options>();
    verb->add_option("DIR", options->folder, "folder of a run")->required();
    verb->add_option("--width", options->width, "inches that each figure is wide in print, e.g. 3.33 for a column, 7in for a page");
    verb->add_flag("--no-title", options->noTitle, "leave out title and machine: a paper's caption says them");
    verb->footer("Examples:\n  dapple plot out/quick\n  dapple plot out/f105 --width 3.33 --no-title");
    verb->callback([options] {
        std::vector<std::string> words;
        if (!options->width.empty()) words = {"--width", inches(options->width)};
        if (options->noTitle) words.emplace_back("--no-title");
        plotRun(options->folder, words);
    });
}

}  // namespace dapple::bench
