#include "bench/scripts.h"

#include "base/error.h"
#include "base/file.h"
#include "bench/process.h"
#include "scenegen/import/import.h"

#include <fmt/format.h>

#include <filesystem>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

void runScript(const std::vector<std::string>& args, const std::string& what) {
    if (!fs::exists(args[1])) throw base::UsageError(fmt::format("{} is not part of this installation: use the source tree", args[1]));
    const int status = runProgram(args);
    if (status == 127) throw base::UsageError(fmt::format("cannot start {}; install it to {}", args[0], what));
    // A script answers 2 or 4, with its line; whatever else it ends with (a signal, a trace) is no code of ours.
    if (status != 0)
        throw base::Error(status == static_cast<int>(base::ExitCode::corrupt) ? base::ExitCode::corrupt : base::ExitCode::usage,
                          status > 128 ? fmt::format("could not {}: signal {} ended {}", what, status - 128, args[1]) : fmt::format("could not {}: see the line above", what));
}

}  // namespace

void plotRun(const std::string& folder, const std::vector<std::string>& options) {
    if (!fs::exists(fs::path(folder) / "metrics.csv"))
        throw base::UsageError(fmt::format("{} holds no metrics.csv; name the folder of a finished run", folder));
    std::vector<std::string> args{"/usr/bin/python3", (base::homeFolder() / "bench/report/plot.py").string(), folder};
    args.insert(args.end(), options.begin(), options.end());
    runScript(args, "draw the plot");
}

void fetchRealScenes(const std::vector<std::string>& scenes) {
    for (const std::string& scene : scenes) {
        if (!scenegen::isRealScene(scene)) continue;
        try {
            scenegen::realScenePath(scene);
        } catch (const base::UsageError&) {  // not in the cache yet; the script says how much it downloads
            const scenegen::RealSceneScript script = scenegen::realSceneScript(scene);
            std::vector<std::string> args{"/usr/bin/python3", (base::homeFolder() / script.file).string()};
            if (*script.argument) args.emplace_back(script.argument);
            runScript(args, "fetch the scene " + scene);
        }
    }
}

void writeBundle(const std::string& file) {
    runScript({"/bin/bash", (base::homeFolder() / "bench/bundle.sh").string(), "-o", file, "-p", fs::read_symlink("/proc/self/exe").string()},
              "write the bundle");
}

}  // namespace dapple::bench
