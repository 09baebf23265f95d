#pragma once

#include "bench/workbench.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <memory>
#include <span>
#include <string>
#include <vector>

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
void addHelp(CLI::App& app);
void addCompletion(CLI::App& app);
std::vector<std::string> verbNames(const CLI::App& app);
const CLI::App* findVerb(const CLI::App& app, const std::string& name);  ///< nullptr: no such verb
std::shared_ptr<CLI::FormatterBase> helpFormatter();  ///< wraps at the terminal's width

/// What `dapple list` can list.
std::vector<std::string> listNames();

/// The options that stand before or after any verb.
struct GlobalOptions {
    int device = -1;      ///< index of an EGL device as `doctor` lists them; −1: automatic
    std::string backend;  ///< of the timer, one of timerNames(); "": the best that passes the self-test
};
/// gpu_timestamp, gpu_elapsed, cpu_finish, and fake, which needs no GL and invents its times.
std::span<const std::string> timerNames();
/// Throws UsageError if --backend is fake, which draws nothing.
void requireGl(const GlobalOptions& options, const std::string& verb);
void addGlobalOptions(CLI::App& app);
GlobalOptions globalOptions(const CLI::App& app);

/// The workbench that --device and --backend ask for. Throws UsageError: no GL.
std::unique_ptr<Workbench> makeWorkbench(const CLI::App& app);

}  // namespace dapple::bench
