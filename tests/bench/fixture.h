#pragma once

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "bench/csv.h"
#include "bench/plan.h"
#include "bench/rows.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

namespace dapple::bench {

/// The fake workbench with invented scenes "a", "b" and "c", so that tests need neither recipes nor GL, and with
/// hooks for what may go wrong.
class TestWorkbench : public Workbench {
public:
    std::function<void(const PointSpec&)> onOpen = [](const PointSpec&) {};
    std::function<void(const PointSpec&)> onFrame = [](const PointSpec&) {};
    std::vector<std::string> opened, released;
    uint64_t contentSalt = 0;
    std::string rejected;  ///< why the timer is not to be trusted
    shadow::Limits limitsOfGl;

    std::string backend() const override { return fake_->backend(); }
    std::string timerRejected() override { return rejected; }
    shadow::Limits limits() const override { return limitsOfGl; }
    SceneFacts sceneFacts(const std::string& scene, const std::vector<std::string>& settings, const std::string& stress) override {
        static const std::vector<std::string> kScenes{"a", "b", "c"};
        if (scene.size() != 1 || scene < "a" || scene > "c") throw base::UsageError(base::unknownName("scene", scene, kScenes));
        base::Hasher content;
        content.text(scene);
        content.value(contentSalt);
        for (const std::string& setting : settings) content.text(setting);
        content.text(stress);
        return {{}, content.digest(), {"front", "back"}};
    }
    std::unique_ptr<OpenPoint> open(const PointSpec& spec) override {
        opened.push_back(spec.scene + " " + pointText(spec));
        onOpen(spec);
        return std::make_unique<Hooked>(fake_->open(spec), spec, *this);
    }
    std::string identityJson() override { return fake_->identityJson(); }
    std::function<double()> clock() const override { return fake_->clock(); }
    void releaseScene(const std::string& scene) override { released.push_back(scene); }

private:
    struct Hooked : OpenPoint {
        Hooked(std::unique_ptr<OpenPoint> p, const PointSpec& s, TestWorkbench& b) : point(std::move(p)), spec(s), bench(b) {}
        const std::vector<std::string>& passNames() const override { return point->passNames(); }
        void submitFrame(bool perPass) override {
            bench.onFrame(spec);
            point->submitFrame(perPass);
        }
        std::vector<measure::FrameTimes> drain() override { return point->drain(); }
        std::vector<Figure> counters() override { return point->counters(); }
        std::vector<Figure> errors() override { return point->errors(); }
        std::vector<PassNote> leftOut() const override { return point->leftOut(); }
        std::string fallback() const override { return point->fallback(); }
        std::unique_ptr<OpenPoint> point;
        PointSpec spec;
        TestWorkbench& bench;
    };
    std::unique_ptr<Workbench> fake_ = makeFakeWorkbench(5);
};

/// A folder that is gone after the test.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "dapple-test-XXXXXX").string();
        if (!::mkdtemp(name.data())) throw std::runtime_error("mkdtemp");
        path = name;
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    std::filesystem::path path;
};

/// Two scenes, each a comparison of four points.
inline Sweep smallSweep() {
    return parseSweep(R"(
question = "?"
scenes = ["a", "b"]
[sampling]
min_blocks = 10
max_blocks = 12
[[technique]]
name = "unshadowed"
[[technique]]
name = "uniform"
size = [256, 512]
[[technique]]
name = "lispsm"
size = 512
)",
                      "small.toml");
}

inline base::ExitCode codeOf(const std::function<void()>& work) {
    try {
        work();
    } catch (const base::Error& e) {
        return e.code();
    }
    return base::ExitCode::ok;
}

inline std::string messageOf(const std::function<void()>& work) {
    try {
        work();
    } catch (const base::Error& e) {
        return e.what();
    }
    return "";
}

/// metrics.csv without what may differ between two runs: the run's id, and the values of what is not deterministic.
inline std::string deterministicPart(const std::filesystem::path& metricsCsv) {
    const CsvTable table(base::readFile(metricsCsv), metricsCsv.string());
    std::string text = csvRow(table.header());
    for (size_t row = 0; row < table.rows(); ++row) {
        const std::string& metric = table.at(row, "metric");
        bool varies = false;
        for (const auto& infos : {measure::metrics(), runMetrics()})
            for (const auto& info : infos) varies = varies || (info.name == metric && !info.deterministic);
        std::vector<std::string> fields;
        for (const std::string& column : table.header()) {
            const bool value = column == "n" || column == "median" || column.starts_with("ci_") || column == "q1" || column == "q3" ||
                               column == "min" || column == "max" || column == "status" || column == "flags";
            fields.push_back(column == "run_id" || (varies && value) ? "" : table.at(row, column));
        }
        text += csvRow(fields);
    }
    return text;
}

}  // namespace dapple::bench
