#include "base/log.h"
#include "bench/picture.h"
#include "bench/verbs/point_options.h"
#include "bench/verbs/verbs.h"

#include "base/error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace dapple::bench {

void addRender(CLI::App& app) {
    CLI::App* verb = app.add_subcommand("render", "Make one picture, with a .json beside it that lets anybody check it");
    auto point = std::make_shared<PointOptions>();
    auto what = std::make_shared<std::string>("shaded");
    auto file = std::make_shared<std::string>();
    point->addTo(*verb);
    std::vector<std::string> kinds;
    for (const PictureKind& kind : pictureKinds()) kinds.push_back(kind.name);
    verb->add_option("--what", *what, fmt::format("{}", fmt::join(kinds, ", ")))->capture_default_str();
    verb->add_option("-o,--output", *file, "FILE.png (colours) or FILE.exr (numbers)")->required();
    verb->footer("Examples:\n  dapple render forest-small instanced -o tree.png\n"
                 "  dapple render forest-105 cascaded -a size=2048 --view walk1 --what error -o error.png\n"
                 "  dapple render model.glb lispsm --what map -o map.exr");
    verb->callback([&app, point, what, file] {
        const GlobalOptions global = globalOptions(app);
        requireGl(global, "render");
        PointSpec spec = point->spec();
        GlWorkbench workbench(global.device, "cpu_finish");  // pictures are not timed: the timer needs no self-test
        if (spec.view.empty())
            spec.view = workbench.sceneFacts(spec.scene, spec.sceneSettings, spec.stressCase).views.front();
        renderPicture(workbench, spec, *what, *file);
        base::logInfo("wrote " + *file);
    });
}

}  // namespace dapple::bench
