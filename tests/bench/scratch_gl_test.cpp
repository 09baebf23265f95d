// Scratch: not to be committed. argv via env VARIANTS="settings|settings", TECH="technique axis=value ...;..."
#include "bench/gl_workbench.h"
#include "scenegen/library.h"
#include <gtest/gtest.h>
#include <chrono>
#include <sstream>
#include <cstdlib>
#include <map>
#include <algorithm>
namespace dapple::bench {
namespace {
std::vector<std::string> split(const std::string& s, char c) { std::vector<std::string> r; std::istringstream in(s); for (std::string t; std::getline(in, t, c);) if (!t.empty()) r.push_back(t); return r; }
struct Timer : frame::PassObserver {
    std::map<std::string, std::vector<double>> ms; std::map<std::string, measure::Ledger> tally; std::chrono::steady_clock::time_point t;
    void beginPass(const frame::Pass&) override { glFinish(); t = std::chrono::steady_clock::now(); }
    void endPass(const frame::Pass& p, const measure::Ledger& l) override { glFinish(); ms[p.name].push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - t).count()); tally[p.name] = l; }
};
double median(std::vector<double> v) { if (v.empty()) return 0; std::sort(v.begin(), v.end()); return v[v.size() / 2]; }
TEST(Scratch, Times) {
    if (!std::getenv("TECH")) GTEST_SKIP();
    GlWorkbench bench(-1, "cpu_finish");
    const std::string sceneName = std::getenv("SCENE");
    const int frames = std::getenv("FRAMES") ? atoi(std::getenv("FRAMES")) : 5;
    const int w = std::getenv("W") ? atoi(std::getenv("W")) : 800, h = w * 3 / 4;
    struct Arm { std::string name; std::unique_ptr<shadow::Renderer> renderer; frame::Frame* frame; std::vector<double> whole; Timer timer; };
    std::vector<std::unique_ptr<scenegen::Scene>> scenes; std::vector<std::unique_ptr<gpuscene::GpuScene>> gpus; std::vector<std::unique_ptr<frame::Frame>> fr; std::vector<Arm> arms;
    for (const std::string& variant : split(std::getenv("VARIANTS") ? std::getenv("VARIANTS") : " ", '|')) {
        scenes.push_back(std::make_unique<scenegen::Scene>(scenegen::loadScene(sceneName, split(variant, ' '))));
        gpus.push_back(std::make_unique<gpuscene::GpuScene>(*scenes.back()));
        const scenegen::View* view = &scenes.back()->views.front();
        if (std::getenv("VIEW")) for (auto& v : scenes.back()->views) if (v.name == std::getenv("VIEW")) view = &v;
        fr.push_back(std::make_unique<frame::Frame>(*gpus.back(), *view, w, h));
        for (const std::string& tech : split(std::getenv("TECH"), ';')) {
            auto words = split(tech, ' ');
            shadow::Settings axes;
            for (size_t i = 1; i < words.size(); ++i) axes[words[i].substr(0, words[i].find('='))] = words[i].substr(words[i].find('=') + 1);
            const auto& info = shadow::technique(words[0]);
            const auto settings = shadow::resolve(info, axes);
            if (auto reason = shadow::pruneReason(info, settings, gpus.back()->facts(), bench.limits())) { printf("pruned: %s: %s\n", tech.c_str(), reason->c_str()); continue; }
            arms.push_back({variant + " :: " + tech, std::make_unique<shadow::Renderer>(*fr.back(), info, settings), fr.back().get(), {}, {}});
        }
    }
    frame::PassObserver silent;
    for (Arm& a : arms) for (int i = 0; i < 6; ++i) a.renderer->render(silent);
    glFinish();
    for (int f = 0; f < frames; ++f) for (size_t k = 0; k < arms.size(); ++k) {
        Arm& a = arms[f % 2 ? arms.size() - 1 - k : k];
        a.renderer->render(silent); glFinish();
        for (int rep = 0; rep < 2; ++rep) {
        const auto t = std::chrono::steady_clock::now();
        a.renderer->render(silent); glFinish();
        a.whole.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - t).count()); }
        a.renderer->render(a.timer);
    }
    for (Arm& a : arms) {
        printf("%-60s whole %8.1f ms |", a.name.c_str(), median(a.whole));
        for (auto& [n, v] : a.timer.ms) printf(" %s %.1f (%zu draws)", n.c_str(), median(v), size_t(a.timer.tally[n].drawCalls));
        if (a.renderer->technique()) if (auto d = a.renderer->technique()->castersDrawn()) printf(" casters %zu tri %zu", d->instances, d->triangles);
        printf("\n");
    }
}
}
}
