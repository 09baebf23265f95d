#pragma once

#include "bench/workbench.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <memory>
#include <string>

/// One function per verb of the command line: it adds the subcommand, whose callback does the work and
/// throws base::Error for every exit code but 0. main() maps exceptions to exit codes and one line.
namespace dapple::bench {

void addQuick(CLI::App& app);
void addScene(CLI::App& app);
void addList(CLI::App& app);
void addPlan(CLI::App& app);
void addRun(CLI::App& app);
void addRender(CLI::App& app);
void addPlot(CLI::App& app);
void addDoctor(CLI::App& app);
void addView(CLI::App& app);
void addBundle(CLI::App& app);

/// The options before the verb.
struct GlobalOptions {
    int device = -1;      ///< index of an EGL device as `doctor` lists them; −1: automatic
    std::string backend;  ///< of the timer; "": the best that passes the self-test
};
void addGlobalOptions(CLI::App& app);
GlobalOptions globalOptions(const CLI::App& app);

/// The workbench that --device and --backend ask for. Throws UsageError: unknown back-end, no GL.
std::unique_ptr<Workbench> makeWorkbench(const CLI::App& app);

}  // namespace dapple::bench
