#include "bench/rows.h"
#include "bench/stress.h"
#include "bench/sweep.h"
#include "bench/table.h"
#include "bench/verbs/verbs.h"
#include "base/error.h"
#include "scenegen/import/import.h"
#include "scenegen/library.h"

#include <CLI/Error.hpp>
#include <fmt/format.h>

#include <array>

namespace dapple::bench {
namespace {

using Rows = std::vector<std::vector<std::string>>;

Rows scenes() {
    Rows rows;
    for (const auto& entries : {scenegen::listScenes(), scenegen::listRealScenes()})
        for (const scenegen::SceneEntry& s : entries) rows.push_back({s.name, s.description});
    return rows;
}

Rows techniques() {
    Rows rows;
    for (const shadow::TechniqueInfo& t : shadow::techniques()) {
        std::string axes;
        for (const auto& [axis, value] : t.defaults) axes += fmt::format("{}{}={}", axes.empty() ? "" : " ", axis, value);
        rows.push_back({t.name, t.family, t.description});
        if (!axes.empty()) rows.push_back({"", "", axes});
    }
    return rows;
}

Rows axes() {
    Rows rows;
    for (const shadow::Axis& axis : shadow::axes()) {
        std::string values;
        for (const shadow::Axis::Value& v : axis.values) values += (values.empty() ? "" : ", ") + v.name;
        if (axis.takesNumbers()) values += fmt::format("{}{} … {}", values.empty() ? "" : ", ", axis.lo, axis.hi);
        rows.push_back({axis.name, values, axis.description});
    }
    return rows;
}

Rows metricNames() {
    Rows rows;
    for (const auto& table : {measure::metrics(), runMetrics()})
        for (const measure::MetricInfo& m : table)
            rows.push_back({std::string(m.name), std::string(m.unit), std::string(betterName(m.better)),
                            m.deterministic ? "deterministic" : "varies", std::string(m.description)});
    return rows;
}

Rows sweeps() {
    Rows rows;
    for (const SweepFile& file : listSweeps()) rows.push_back({file.name, readSweep(file.path.string()).question});
    return rows;
}

Rows stress() {
    Rows rows;
    for (const StressCase& c : stressCases()) rows.push_back({c.name, c.description});
    return rows;
}

struct Kind {
    std::string name;
    Rows (*rows)();
};
const std::array kKinds{Kind{"scenes", scenes}, Kind{"techniques", techniques}, Kind{"axes", axes},
                        Kind{"metrics", metricNames}, Kind{"sweeps", sweeps}, Kind{"stress", stress}};

void list(const std::string& name) {
    std::vector<std::string> names;
    for (const Kind& kind : kKinds) {
        if (kind.name == name) {
            fmt::print("{}", alignColumns(kind.rows()));
            return;
        }
        names.push_back(kind.name);
    }
    throw base::UsageError(base::unknownName("list", name, names));
}

}  // namespace

void addList(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("list", "List what is known: scenes, techniques, axes, metrics, sweeps, stress");
    auto what = std::make_shared<std::string>();
    verb->add_option("what", *what, "scenes, techniques, axes, metrics, sweeps or stress")->required();
    verb->footer("Examples:\n  dapple list techniques\n  dapple list axes");
    verb->callback([what] { list(*what); });
}

}  // namespace dapple::bench
