#include "bench/verbs/point_options.h"

#include "base/error.h"
#include "bench/stress.h"

#include <fmt/format.h>

#include <cstdio>
#include <tuple>

namespace dapple::bench {

void PointOptions::addTo(CLI::App& verb) {
    for (const auto& [name, value, text] :
         {std::tuple("scene", &scene, "name of a scene (dapple list scenes) or a file"),
          std::tuple("technique", &technique, "name of a technique (dapple list techniques)")}) {
        CLI::Option* option = verb.add_option(name, *value, text);
        if (value->empty()) option->required();
        else option->capture_default_str();
    }
    verb.add_option("-a,--axis", axes, "axis=value, e.g. size=1024; may be repeated (dapple list axes)")
        ->allow_extra_args(false);
    verb.add_option("-s,--set", settings, "key=value of the scene's recipe; may be repeated")->allow_extra_args(false);
    verb.add_option("--view", view, "name of a view (dapple scene NAME --stats lists them); the first if not named");
    verb.add_option("--stress", stress, "a stiff case to push the scene to (dapple list stress)");
    verb.add_option("-r,--resolution", resolution, "WIDTHxHEIGHT in pixels")->capture_default_str();
}

shadow::Settings PointOptions::overrides() const {
    shadow::Settings asked;
    for (const std::string& item : axes) {
        const size_t equals = item.find('=');
        if (equals == std::string::npos) throw base::UsageError(fmt::format("-a {}: write axis=value", item));
        asked[item.substr(0, equals)] = item.substr(equals + 1);
    }
    return asked;
}

PointSpec PointOptions::spec() const {
    PointSpec spec;
    spec.settings = shadow::resolve(shadow::technique(technique), overrides());
    char rest = 0;
    if (std::sscanf(resolution.c_str(), "%dx%d%c", &spec.width, &spec.height, &rest) != 2)
        throw base::UsageError(fmt::format("resolution '{}': write WIDTHxHEIGHT, e.g. 1024x768", resolution));
    if (!stress.empty()) stressCase(stress);  // rejects an unknown name before a scene is made
    spec.scene = scene;
    spec.sceneSettings = settings;
    spec.stressCase = stress;
    spec.technique = technique;
    spec.view = view;
    return spec;
}

}  // namespace dapple::bench
