#include "base/file_name.h"
#include "base/hash.h"
#include "base/error.h"
#include "base/log.h"
#include "bench/contact_sheet.h"
#include "bench/verbs/verbs.h"
#include "gpuscene/pack.h"
#include "scenegen/export/glb.h"
#include "scenegen/export/obj.h"
#include "scenegen/library.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

namespace dapple::bench {
namespace {

void printStats(const scenegen::Scene& scene, double seconds) {
    const scenegen::Facts f = scene.facts();
    const auto line = [](std::string_view key, const std::string& value) { fmt::print("{:<18} {}\n", key, base::printable(value)); };
    const auto fact = [](bool has) { return has ? "yes" : "no"; };
    line("scene", scene.name);
    line("hash", base::hex16(scene.contentHash()));
    line("triangles", fmt::format("{} in all, {} stored", f.triangles, f.uniqueTriangles));
    line("instances", fmt::format("{} of {} prototypes", f.instances, f.prototypes));
    for (const std::string& dropped : scene.dropped) line("left out", dropped);
    for (const std::string& note : scene.notes) line("not as the file", note);
    line("materials", fmt::format("{}, {} textures", f.materials, scene.textures.size()));
    if (!f.box.empty())
        line("bounds [m]", fmt::format("({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g})", f.box.lo.x, f.box.lo.y, f.box.lo.z, f.box.hi.x, f.box.hi.y, f.box.hi.z));
    line("origin [m]", fmt::format("({:.10g}, {:.10g}, {:.10g})", scene.origin.x, scene.origin.y, scene.origin.z));
    line("sun [degrees]", fmt::format("azimuth {:.6g}, elevation {:.6g}", scene.sun.azimuth, scene.sun.elevation));
    for (const scenegen::Sun& s : scene.furtherSuns)
        line("further sun",
             fmt::format("azimuth {:.6g}, elevation {:.6g}, strength {:.6g}", s.azimuth, s.elevation, s.strength));
    for (const auto& [name, has] : {std::pair{"alpha-tested", f.alphaTested}, {"rotated", f.rotated}, {"scaled", f.scaled},
                                    {"closed casters", f.closed}, {"moving", f.moving}, {"casters", f.casters}, {"receivers", f.receivers}})
        line(name, fact(has));
    line("local lights", f.lights > 0 ? fmt::format("{}", f.lights) : "no");
    line("depth range", fmt::format("{:.6g} (largest far / near)", f.depthRange));
    for (const scenegen::View& v : scene.views)
        line("view", fmt::format("{}: eye ({:.6g}, {:.6g}, {:.6g}), {:.4g}° across the height, {:.6g} … {:.6g} m",
                                 v.name, v.eye.x, v.eye.y, v.eye.z, v.fovY, v.near, v.far));
    const size_t packed = gpuscene::packedBytes(scene), instances = scene.instances.size() * sizeof(scenegen::Instance);
    line("memory", fmt::format("{:.1f} MiB of packed meshes, {:.1f} bytes per stored triangle; {:.1f} MiB of instances, {} bytes each", double(packed) / (1 << 20),
                               double(packed) / double(std::max<size_t>(f.uniqueTriangles, 1)), double(instances) / (1 << 20), sizeof(scenegen::Instance)));
    line("made in", fmt::format("{:.3f} s", seconds));
}

}  // namespace

void addScene(CLI::App& app) {
    struct Options {
        std::string scene, file, picture;
        std::vector<std::string> settings;
        bool stats = false;
    };
    CLI::App* verb = app.add_subcommand("scene", "Make or import a scene: print what it has, write it as glTF or OBJ, picture it");
    auto options = std::make_shared<Options>();
    verb->add_option("scene", options->scene, "name of a scene (dapple list scenes) or a file that Assimp opens")->required();
    verb->add_option("-s,--set", options->settings, "key=value of the recipe; may be repeated")
        ->allow_extra_args(false);
    verb->add_flag("--stats", options->stats, "print triangles, instances, bounds, facts, views, time and memory");
    verb->add_option("-o,--output", options->file, "FILE.glb: glTF 2.0 with instancing; FILE.obj: every instance written out");
    verb->add_option("--picture", options->picture, "FILE.png: a contact sheet of all views");
    verb->footer("Examples:\n  dapple scene forest-105 --stats\n  dapple scene forest-small -s seed=7 -o forest.glb\n  dapple scene model.obj --stats\n  dapple scene city-vienna -s scale=0.1 --picture vienna.png");
    verb->callback([&app, options] {
        const std::string suffix = std::filesystem::path(options->file).extension().string();
        if (!options->file.empty() && suffix != ".glb" && suffix != ".obj")
            throw base::UsageError(fmt::format("{}: a scene is written as .glb or .obj", options->file));
        const auto start = std::chrono::steady_clock::now();
        const scenegen::Scene scene = scenegen::loadScene(options->scene, options->settings);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::vector<std::filesystem::path> written{options->file};
        if (suffix == ".obj") written = scenegen::objFiles(scene, options->file);
        written.emplace_back(options->picture);
        for (const std::filesystem::path& file : written) base::requireNotAnInput(file);
        if (options->stats || (options->file.empty() && options->picture.empty())) printStats(scene, seconds);
        if (!options->file.empty()) {
            (suffix == ".obj" ? scenegen::writeObj : scenegen::writeGlb)(scene, options->file);
            base::logInfo("wrote " + options->file);
        }
        if (!options->picture.empty()) {
            requireGl(globalOptions(app), "scene --picture");
            writeContactSheet(scene, globalOptions(app).device, options->picture);
            base::logInfo("wrote " + options->picture);
        }
    });
}

}  // namespace dapple::bench
