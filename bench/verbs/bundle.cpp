#include "bench/scripts.h"
#include "bench/verbs/verbs.h"

namespace dapple::bench {

void addBundle(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("bundle", "Pack the program and all it needs into an archive that runs on another machine");
    auto file = std::make_shared<std::string>();
    verb->add_option("-o,--output", *file, "archive to write, .tar.xz")->required();
    verb->footer("Example:\n  dapple bundle -o dapple.tar.xz\nThere:\n  tar xf dapple.tar.xz && dapple/dapple doctor");
    verb->callback([file] { writeBundle(*file); });
}

}  // namespace dapple::bench
