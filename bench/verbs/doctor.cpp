#include "base/error.h"
#include "bench/verbs/verbs.h"
#include "gl/context.h"
#include "measure/doctor.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace dapple::bench {
namespace {

/// Throws Error (exit 5) unless the timer that --backend names, or any, is trusted.
void requireTrusted(const measure::TimerReport& report, const std::string& backend) {
    if (report.chosen.empty()) throw base::Error(base::ExitCode::failed, "no timer can be trusted here");
    for (const measure::BackendVerdict& verdict : report.verdicts)
        if (verdict.backend == backend && !verdict.accepted)
            throw base::Error(base::ExitCode::failed,
                              fmt::format("timer {} cannot be trusted here: {}", backend, verdict.reason));
}

void doctor(const GlobalOptions& global, bool asJson) {
    if (global.backend == "fake") {
        const char* text = asJson ? R"({"devices": [], "timers": {"chosen": "fake"}})"
                                  : "timer fake needs no GL and invents its times, for tests of the tool";
        fmt::print("{}\n", text);
        return;
    }
    const std::vector<gl::DeviceInfo> devices = gl::listDevices();
    const gl::Context context = gl::Context::headless(global.device);
    const gl::Identity id = gl::identify();
    const measure::TimerReport report = measure::testTimers();
    if (asJson) {
        nlohmann::json list = nlohmann::json::array();
        for (const gl::DeviceInfo& d : devices) list.push_back({{"index", d.index}, {"description", d.description}, {"software", d.software}});
        const nlohmann::json out{{"devices", list},         {"platform", context.platform()},   {"gl_vendor", id.vendor},
                                 {"gl_renderer", id.renderer}, {"gl_version", id.version},         {"glsl_version", id.glsl},
                                 {"software", id.software},  {"max_texture_size", id.maxTextureSize}, {"max_array_layers", id.maxArrayLayers},
                                 {"timers", nlohmann::json::parse(report.json())}};
        fmt::print("{}\n", out.dump(2));
    } else {
        fmt::print("EGL devices (choose with --device N)\n");
        for (const gl::DeviceInfo& d : devices) fmt::print("  {}  {}{}\n", d.index, d.description, d.software ? "  [software]" : "");
        if (devices.empty()) fmt::print("  none listed by this EGL\n");
        fmt::print("\nContext   {} on {}\nGL        {}\nLimits    {}² texels, {} layers\n", id.renderer, context.platform(), id.version,
                   id.maxTextureSize, id.maxArrayLayers);
        if (id.software) fmt::print("          a software rasteriser: its times are a CPU's; compare them as ratios only\n");
        fmt::print("\n{}\n", report.text());
    }
    requireTrusted(report, global.backend);
}

}  // namespace

void addDoctor(CLI::App& app) {
    CLI::App* verb = app.add_subcommand(
        "doctor",
        "Say what this machine's GL is, and which timer is reliable here; with --backend, whether that one is");
    auto asJson = std::make_shared<bool>(false);
    verb->add_flag("--json", *asJson, "the same as JSON");
    verb->footer(
        "Examples:\n  dapple doctor\n  dapple doctor --device 1 --json\n  dapple doctor --backend gpu_elapsed");
    verb->callback([&app, asJson] { doctor(globalOptions(app), *asJson); });
}

}  // namespace dapple::bench
