#include "bench/scripts.h"
#include "bench/verbs/verbs.h"

namespace dapple::bench {

void addPlot(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("plot", "Draw the figures of a run: error against time, and what its sweep asks for");
    auto folder = std::make_shared<std::string>();
    verb->add_option("DIR", *folder, "folder of a run")->required();
    verb->footer("Example:\n  dapple plot out/quick");
    verb->callback([folder] { plotRun(*folder); });
}

}  // namespace dapple::bench
