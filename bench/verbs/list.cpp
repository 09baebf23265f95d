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
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

namespace dapple::bench {
namespace {

using Json = nlohmann::ordered_json;

Json scenes() {
    Json list = Json::array();
    for (const auto& entries : {scenegen::listScenes(), scenegen::listRealScenes()})
        for (const scenegen::SceneEntry& s : entries)
            list.push_back({{"name", s.name}, {"description", s.description}});
    return list;
}

Json techniques() {
    Json list = Json::array();
    for (const shadow::TechniqueInfo& t : shadow::techniques())
        list.push_back({{"name", t.name}, {"family", t.family}, {"description", t.description}, {"axes", t.defaults}});
    return list;
}

Json axes() {
    Json list = Json::array();
    for (const shadow::Axis& axis : shadow::axes()) {
        Json names = Json::array();
        for (const shadow::Axis::Value& v : axis.values) names.push_back(v.name);
        if (axis.takesNumbers()) names.push_back(fmt::format("{} … {}", axis.lo, axis.hi));
        list.push_back({{"name", axis.name}, {"values", names}, {"description", axis.description}});
    }
    return list;
}

Json metricNames() {
    Json list = Json::array();
    for (const auto& table : {measure::metrics(), runMetrics()})
        for (const measure::MetricInfo& m : table)
            list.push_back({{"name", m.name}, {"unit", m.unit}, {"better", betterName(m.better)},
                            {"repeats", m.deterministic ? "deterministic" : "varies"}, {"description", m.description}});
    return list;
}

Json sweeps() {
    Json list = Json::array();
    for (const SweepFile& file : listSweeps())
        list.push_back({{"name", file.name}, {"question", readSweep(file.path.string()).question}});
    return list;
}

Json stress() {
    Json list = Json::array();
    for (const StressCase& c : stressCases()) list.push_back({{"name", c.name}, {"description", c.description}});
    return list;
}

/// A row for each item, a column for each of its keys; what an item maps, such as a technique's axes, stands in a row
/// of its own.
std::vector<std::vector<std::string>> rowsOf(const Json& list) {
    std::vector<std::vector<std::string>> rows;
    const auto texts = [](const Json& values, std::string_view between) {
        return fmt::format("{}", fmt::join(values.get<std::vector<std::string>>(), between));
    };
    for (const Json& item : list) {
        std::vector<std::string> row;
        std::string below;
        for (const Json& value : item) {
            if (value.is_object())
                for (const auto& [key, own] : value.items())
                    below += fmt::format("{}{}={}", below.empty() ? "" : " ", key, own.get<std::string>());
            else row.push_back(value.is_array() ? texts(value, ", ") : value.get<std::string>());
        }
        rows.push_back(row);
        if (!below.empty()) rows.push_back({"", "", below});
    }
    return rows;
}

struct Kind {
    std::string name;
    Json (*items)();
};
const std::array kKinds{Kind{"scenes", scenes}, Kind{"techniques", techniques}, Kind{"axes", axes},
                        Kind{"metrics", metricNames}, Kind{"sweeps", sweeps}, Kind{"stress", stress}};

void list(const std::string& name, bool asJson) {
    const auto kind = std::ranges::find(kKinds, name, &Kind::name);
    if (kind == kKinds.end()) throw base::UsageError(base::unknownName("list", name, listNames()));
    const Json items = kind->items();
    fmt::print("{}", asJson ? items.dump(2) + "\n" : alignColumns(rowsOf(items)));
}

}  // namespace

std::vector<std::string> listNames() {
    std::vector<std::string> names;
    for (const Kind& kind : kKinds) names.push_back(kind.name);
    return names;
}

void addList(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("list", "List what is known: scenes, techniques, axes, metrics, sweeps, stress");
    auto what = std::make_shared<std::string>();
    verb->add_option("what", *what, "scenes, techniques, axes, metrics, sweeps or stress")->required();
    auto asJson = std::make_shared<bool>(false);
    verb->add_flag("--json", *asJson, "as a JSON array of objects");
    verb->footer("Examples:\n  dapple list techniques\n  dapple list axes --json");
    verb->callback([what, asJson] { list(*what, *asJson); });
}

}  // namespace dapple::bench
