#include "bench/sweep.h"

#include "base/config.h"
#include "base/error.h"
#include "base/file.h"
#include "bench/stress.h"
#include "measure/counters.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace dapple::bench {
namespace fs = std::filesystem;
namespace {

/// Runs `read`, and gives a UsageError that it throws the file and line of `key`.
template <class Read>
auto located(const base::ConfigTable& table, std::string_view key, Read read) {
    try {
        return read();
    } catch (const base::UsageError& e) {
        table.fail(key, e.what());
    }
}

measure::SamplingPlan readSampling(base::ConfigTable& table) {
    measure::SamplingPlan s;
    const auto whole = [&](const char* key, int fallback, int lo, int hi) { return static_cast<int>(table.integer(key, fallback, lo, hi)); };
    s.maxWarmupFrames = whole("max_warmup_frames", s.maxWarmupFrames, 1, 1000);
    s.framesPerBlock = whole("frames_per_block", s.framesPerBlock, 5, 10);  // the sampler's own limits
    s.passFramesPerBlock = whole("pass_frames_per_block", s.passFramesPerBlock, 0, 10);
    s.minBlocks = whole("min_blocks", s.minBlocks, 1, 1000);
    s.maxBlocks = whole("max_blocks", std::max(s.minBlocks, s.maxBlocks), s.minBlocks, 10000);
    s.ciTarget = table.number("ci_percent", 100 * s.ciTarget, 0.01, 100) / 100;
    s.timeoutSeconds = table.number("timeout_s", s.timeoutSeconds, 0.01, 86400);
    s.budgetSeconds = table.number("budget_s", s.budgetSeconds, 0.01, 1e9);
    s.seed = static_cast<uint64_t>(table.integer("seed", static_cast<int64_t>(s.seed), 0, INT64_MAX));
    table.finish();
    return s;
}

TechniqueEntry readEntry(base::ConfigTable& table) {
    const std::string name = table.text("name");
    const shadow::TechniqueInfo& info = located(table, "name", [&]() -> const shadow::TechniqueInfo& { return shadow::technique(name); });
    TechniqueEntry entry{name, {}, {}};
    for (const shadow::Axis& axis : shadow::axes()) {
        if (!info.defaults.contains(axis.name) || !table.has(axis.name)) continue;
        std::vector<std::string> values = table.values(axis.name);
        for (std::string& value : values) value = located(table, axis.name, [&] { return axis.canonical(value); });
        entry.axes.emplace_back(axis.name, std::move(values));
    }
    for (const std::string& key : table.keys())
        if (!info.defaults.contains(key) && std::any_of(shadow::axes().begin(), shadow::axes().end(), [&](const auto& a) { return a.name == key; }))
            table.fail(key, fmt::format("technique {} has no such axis", name));
    if (table.has("zip")) entry.zip = table.values("zip");
    size_t length = 0;
    for (const std::string& zipped : entry.zip) {
        const auto found = std::find_if(entry.axes.begin(), entry.axes.end(), [&](const auto& a) { return a.first == zipped; });
        if (found == entry.axes.end()) table.fail("zip", fmt::format("'{}' is not an axis that this table sets", zipped));
        if (length != 0 && found->second.size() != length) table.fail("zip", "zipped axes must have equally many values");
        length = found->second.size();
    }
    table.finish();
    return entry;
}

MotionPath readMotion(base::ConfigTable& table) {
    MotionPath path;
    path.azimuthPerFrame = table.number("sun_azimuth_per_frame", 0, -90, 90);
    path.elevationPerFrame = table.number("sun_elevation_per_frame", 0, -10, 10);
    path.secondsPerFrame = table.number("seconds_per_frame", 0, 0, 3600);
    path.frames = static_cast<int>(table.integer("frames", 16, 2, 1000));
    path.metresPerFrame = table.number("camera_metres_per_frame", 0, -1e4, 1e4);
    path.heading = table.number("camera_heading", 0, -180, 180);
    path.turnPerFrame = table.number("camera_turn_per_frame", 0, -180, 180);
    if (path.heading != 0 && path.metresPerFrame == 0) table.fail("camera_heading", "is the way of a camera that walks: camera_metres_per_frame");
    if (!path.movesSun() && !path.movesCamera() && path.secondsPerFrame == 0)
        table.fail("frames", "a [motion] needs sun_azimuth_per_frame, sun_elevation_per_frame camera_turn_per_frame (degrees), camera_metres_per_frame or seconds_per_frame");
    table.finish();
    return path;
}

PlotRequest readPlot(base::ConfigTable& table, const Sweep& sweep) {
    PlotRequest plot{table.text("x"), table.text("y", "error"), table.text("columns", "")};
    located(table, "y", [&] { measure::metricInfo(plot.y); });
    for (const auto& asked : {std::pair("x", plot.x), std::pair("columns", plot.columns)}) {
        const std::string& name = asked.second;
        const bool varies = name == "variant" ? sweep.variants.size() > 1 : std::any_of(sweep.entries.begin(), sweep.entries.end(), [&](const TechniqueEntry& entry) {
            return std::any_of(entry.axes.begin(), entry.axes.end(), [&](const auto& axis) { return axis.first == name; });
        });
        if (!name.empty() && !varies) table.fail(asked.first, fmt::format("'{}' is neither an axis that a [[technique]] of this sweep sets nor \"variant\" of several", name));
    }
    if (plot.x == plot.columns) table.fail("columns", "must be another than x");
    table.finish();
    return plot;
}

void requireUnique(const base::ConfigTable& table, std::string_view key, std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    const auto twice = std::adjacent_find(names.begin(), names.end());
    if (twice != names.end()) table.fail(key, fmt::format("'{}' is named twice", *twice));
}

}  // namespace

std::vector<SweepFile> listSweeps() {
    std::vector<SweepFile> sweeps;
    const fs::path folder = base::homeFolder() / "bench" / "sweeps";
    std::error_code missing;
    for (const fs::directory_entry& file : fs::directory_iterator(folder, missing))
        if (file.path().extension() == ".toml") sweeps.push_back({file.path().stem().string(), file.path()});
    std::sort(sweeps.begin(), sweeps.end(), [](const SweepFile& a, const SweepFile& b) { return a.name < b.name; });
    return sweeps;
}

Sweep readSweep(const std::string& nameOrPath) {
    std::vector<std::string> names;
    for (const SweepFile& sweep : listSweeps()) {
        if (sweep.name == nameOrPath) return parseSweep(base::readFile(sweep.path), sweep.path.string());
        names.push_back(sweep.name);
    }
    if (fs::exists(nameOrPath)) return parseSweep(base::readFile(nameOrPath), nameOrPath);
    if (nameOrPath.ends_with(".toml") || nameOrPath.find('/') != std::string::npos)
        throw base::UsageError(fmt::format("there is no sweep file {}; name a file or one of: {}", nameOrPath, fmt::join(names, ", ")));
    throw base::UsageError(base::unknownName("sweep", nameOrPath, names));
}

Sweep parseSweep(const std::string& toml, const std::string& fileName) {
    base::ConfigTable root = base::ConfigTable::parseText(toml, fileName);
    if (root.keys().empty()) throw base::UsageError(fmt::format("{}: the sweep is empty; it needs question, scenes and [[technique]]", fileName));
    Sweep sweep;
    sweep.name = fs::path(fileName).stem().string();
    sweep.question = root.text("question");
    sweep.scenes = root.values("scenes");
    requireUnique(root, "scenes", sweep.scenes);
    if (root.has("scene_settings")) sweep.sceneSettings = root.values("scene_settings");
    if (root.has("variants")) sweep.variants = root.values("variants");
    requireUnique(root, "variants", sweep.variants);
    for (const std::string& variant : sweep.variants)
        for (const std::string& setting : variantSettings(variant))
            if (setting.find('=') == std::string::npos) root.fail("variants", fmt::format("'{}': write key=value, several divided by ;", variant));
    if (root.has("views")) sweep.views = root.values("views");
    requireUnique(root, "views", sweep.views);
    if (root.has("stress")) sweep.stress = root.values("stress");
    requireUnique(root, "stress", sweep.stress);
    for (const std::string& name : sweep.stress) located(root, "stress", [&] { stressCase(name); });
    if (root.has("resolution")) {
        const std::vector<double> size = root.numbers("resolution", 2);
        for (const double side : size)
            if (side != static_cast<int>(side) || side < 1 || side > 16384) root.fail("resolution", "must be two whole numbers in 1 … 16384");
        sweep.width = static_cast<int>(size[0]);
        sweep.height = static_cast<int>(size[1]);
    }
    if (auto sampling = root.table("sampling")) sweep.sampling = readSampling(*sampling);
    if (auto motion = root.table("motion")) sweep.path = readMotion(*motion);
    for (base::ConfigTable& table : root.tables("technique")) sweep.entries.push_back(readEntry(table));
    if (auto plot = root.table("plot")) sweep.plot = readPlot(*plot, sweep);
    root.finish();
    if (sweep.entries.empty()) throw base::UsageError(fmt::format("{}: the sweep names no [[technique]]", fileName));
    return sweep;
}

std::vector<std::string> variantSettings(const std::string& variant) {
    std::vector<std::string> settings;
    std::istringstream list(variant);
    for (std::string setting; std::getline(list, setting, ';');) {
        setting.erase(0, setting.find_first_not_of(' '));
        setting.erase(setting.find_last_not_of(' ') + 1);
        settings.push_back(setting);
    }
    return settings;
}

void overrideAxis(Sweep& sweep, const std::string& assignment) {
    const size_t equals = assignment.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == assignment.size())
        throw base::UsageError(fmt::format("-a {}: write axis=value or axis=value,value", assignment));
    const std::string name = assignment.substr(0, equals);
    const shadow::Axis& axis = shadow::axis(name);
    std::vector<std::string> values;
    std::istringstream list(assignment.substr(equals + 1));
    for (std::string value; std::getline(list, value, ',');) values.push_back(axis.canonical(value));
    bool used = false;
    for (TechniqueEntry& entry : sweep.entries) {
        if (!shadow::technique(entry.technique).defaults.contains(name)) continue;
        used = true;
        std::erase(entry.zip, name);
        const auto found = std::find_if(entry.axes.begin(), entry.axes.end(), [&](const auto& a) { return a.first == name; });
        if (found != entry.axes.end()) found->second = values;
        else entry.axes.emplace_back(name, values);
    }
    if (!used) throw base::UsageError(fmt::format("-a {}: no technique of sweep '{}' has the axis '{}'", assignment, sweep.name, name));
}

std::vector<shadow::Settings> expand(const TechniqueEntry& entry) {
    const shadow::TechniqueInfo& info = shadow::technique(entry.technique);
    const auto isZipped = [&](const std::string& axis) { return std::find(entry.zip.begin(), entry.zip.end(), axis) != entry.zip.end(); };
    std::vector<shadow::Settings> products(1);
    bool zipDone = false;
    for (const auto& [name, values] : entry.axes) {
        if (isZipped(name) && zipDone) continue;
        std::vector<shadow::Settings> next;
        for (const shadow::Settings& product : products)
            for (size_t i = 0; i < values.size(); ++i) {
                next.push_back(product);
                next.back()[name] = values[i];
                if (!isZipped(name)) continue;
                for (const auto& [other, otherValues] : entry.axes)
                    if (isZipped(other)) next.back()[other] = otherValues[i];
            }
        zipDone = zipDone || isZipped(name);
        products = std::move(next);
    }
    for (shadow::Settings& product : products) product = shadow::resolve(info, product);
    return products;
}

}  // namespace dapple::bench
