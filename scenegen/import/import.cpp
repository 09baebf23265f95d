#include "scenegen/import/import.h"

#include "base/error.h"
#include "base/log.h"
#include "scenegen/import/auto_views.h"
#include "scenegen/import/file_scene.h"
#include "scenegen/import/own_glb.h"
#include "scenegen/import/prototypes.h"
#include "scenegen/import/sidecar.h"

#include <fmt/format.h>

namespace dapple::scenegen {

Scene importFile(const std::filesystem::path& file) {
    // A sidecar changes what a file says, which only a reading of its triangles allows.
    if (!std::filesystem::exists(std::filesystem::path(file).replace_extension(".toml")))
        if (std::optional<Scene> own = readOwnGlb(file)) {
            dropBadInstances(*own);
            validate(*own);
            return *own;
        }
    const Sidecar sidecar = readSidecar(file);
    FileScene content = readFileScene(file, sidecar);

    Scene scene;
    scene.name = file.stem().string();
    scene.source = file.string();
    const CutCounts counts = cutIntoPrototypes(content, sidecar.cell, scene);
    if (counts.degenerate > 0) content.notes.add("degenerate triangles are dropped", "", counts.degenerate);
    const Facts facts = scene.facts();
    if (facts.triangles == 0) throw base::UsageError(file.string() + ": has no triangle");
    if (!base::allFinite(facts.box.lo) || !base::allFinite(facts.box.hi))
        throw base::UsageError(file.string() + ": its extent is beyond what float can hold");

    scene.sun = sidecar.sun ? *sidecar.sun : content.sun.value_or(Sun{});
    for (View view : sidecar.views.empty() ? content.views : sidecar.views) {
        view.eye -= scene.origin;
        if (view.far == 0) view.far = chooseFar(facts.box, view.eye, view.near);
        scene.views.push_back(std::move(view));
    }
    if (scene.views.empty()) scene.views = chooseViews(scene);
    scene.notes = content.notes.lines();
    for (const std::string& note : scene.notes) base::logWarning(fmt::format("{}: {}", file.string(), note));
    validate(scene);
    return scene;
}

}  // namespace dapple::scenegen
