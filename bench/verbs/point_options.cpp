#include "bench/verbs/point_options.h"

#include "base/error.h"
#include "bench/stress.h"

#include <fmt/format.h>

#include <cstdio>

namespace dapple::bench {

void PointOptions::addTo(CLI::App& verb) {
    verb.add_option("scene", scene, "name of a scene (dapple list scenes) or a file")->required();
    verb.add_option("technique", technique, "name of a technique (dapple list techniques)")->required();
    verb.add_option("-a,--axis", axes, "axis=value, e.g. size=1024; repeatable (dapple list axes)");
    verb.add_option("-s,--set", settings, "key=value of the scene's recipe; repeatable");
    verb.add_option("--view", view, "name of a view (dapple scene NAME --stats lists them); the first if not named");
    verb.add_option("--stress", stress, "a stiff case to push the scene to (dapple list stress)");
    verb.add_option("-r,--resolution", resolution, "WIDTHxHEIGHT in pixels")->capture_default_str();
}

PointSpec PointOptions::spec(Workbench& workbench) const {
    PointSpec spec;
    const shadow::TechniqueInfo& info = shadow::technique(technique);
    shadow::Settings overrides;
    for (const std::string& item : axes) {
        const size_t equals = item.find('=');
        if (equals == std::string::npos) throw base::UsageError(fmt::format("-a {}: write axis=value", item));
        overrides[item.substr(0, equals)] = item.substr(equals + 1);
    }
    spec.settings = shadow::resolve(info, overrides);
    char rest = 0;
    if (std::sscanf(resolution.c_str(), "%dx%d%c", &spec.width, &spec.height, &rest) != 2)
        throw base::UsageError(fmt::format("resolution '{}': write WIDTHxHEIGHT, e.g. 1024x768", resolution));
    if (!stress.empty()) stressCase(stress);  // rejects an unknown name before a scene is made
    spec.scene = scene;
    spec.sceneSettings = settings;
    spec.stressCase = stress;
    spec.technique = technique;
    spec.view = view;
    if (spec.view.empty()) spec.view = workbench.sceneFacts(scene, settings, stress).views.front();
    return spec;
}

}  // namespace dapple::bench
