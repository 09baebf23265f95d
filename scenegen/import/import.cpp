#include "scenegen/import/import.h"

#include "base/child.h"
#include "base/error.h"
#include "base/file_name.h"
#include "base/log.h"
#include "base/memory.h"
#include "scenegen/import/auto_views.h"
#include "scenegen/import/file_kind.h"
#include "scenegen/import/file_scene.h"
#include "scenegen/import/gltf_reader.h"
#include "scenegen/import/own_gltf.h"
#include "scenegen/import/prototypes.h"
#include "scenegen/import/scene_bytes.h"
#include "scenegen/import/sidecar.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace dapple::scenegen {
namespace {
namespace fs = std::filesystem;

constexpr float kFarthest = 1e9f;  ///< metres; squares and cubes of such lengths are still floats
constexpr size_t kMemory = size_t(3) << 29;  ///< bytes beyond what the program has, and so many more for each of the file's:
constexpr size_t kMemoryPerByte = 16;

/// Bytes of what a scene file brings along: images, buffers and material libraries in its folder and below. Formats that
/// name no other file have nothing.
size_t bytesBeside(const fs::path& file) {
    constexpr int kMostEntries = 2000;
    static const std::set<std::string> kAlone{".stl", ".off", ".raw", ".glb"},
        kBrought{".png", ".jpg", ".jpeg", ".tga", ".bmp", ".rgb", ".webp", ".ktx2", ".bin", ".mtl"};
    if (kAlone.contains(lowerExtension(file))) return 0;
    std::error_code error;
    size_t bytes = 0;
    int entries = 0;
    const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
    for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, error), end; !error && it != end && ++entries < kMostEntries; it.increment(error))
        if (std::error_code ignored; kBrought.contains(lowerExtension(it->path())) && it->is_regular_file(ignored)) bytes += it->file_size(ignored);
    return bytes;
}

base::Child::Limits limitsFor(const fs::path& file) {
    const size_t bytes = fs::file_size(file) + bytesBeside(file);
    return {8 + double(bytes) / 1e6, std::min(kMemory + kMemoryPerByte * bytes, base::availableMemory() / 4 * 3)};
}

/// All but the views that are chosen by looking at the scene.
Scene readContent(const fs::path& file) {
    const Sidecar sidecar = readSidecar(file);
    FileScene content;
    if (isGltf(file)) {
        GltfDocument document(file);
        // A sidecar changes what a file says, which only a reading of its triangles allows.
        if (!hasSidecar(file))
            if (std::optional<Scene> own = readOwnGltf(document)) {
                own->notes = document.notes.lines();
                dropBadInstances(*own);
                validate(*own);
                return *own;
            }
        content = readGltf(document, sidecar);
    } else {
        content = readFileScene(file, sidecar);
    }
    if (!sidecar.views.empty()) content.views = sidecar.views;

    Scene scene;
    scene.name = file.stem().string();
    scene.source = file.string();
    const CutCounts counts = cutIntoPrototypes(content, sidecar.cell, scene);
    if (counts.degenerate > 0) content.notes.add("degenerate triangles are dropped", "", counts.degenerate);
    if (counts.turned > 0) content.notes.add("closed parts are wound inwards and turned outwards", "", counts.turned);
    const Facts facts = scene.facts();
    if (facts.triangles == 0) throw base::UsageError(file.string() + ": has no triangle");
    const glm::vec3 reach = glm::max(glm::abs(facts.box.lo), glm::abs(facts.box.hi));
    if (!(std::max({reach.x, reach.y, reach.z}) <= kFarthest))
        throw base::UsageError(fmt::format("{}: reaches beyond {:g} m from its middle; is its unit right?", file.string(), kFarthest));

    scene.sun = sidecar.sun ? *sidecar.sun : content.sun.value_or(Sun{});
    for (View view : content.views) {
        view.eye -= scene.origin;
        if (view.far == 0) view.far = chooseFar(facts.box, view.eye, view.near);
        scene.views.push_back(std::move(view));
    }
    for (const FileScene::Lamp& lamp : content.lamps) {
        scene.lights.push_back(lamp.light);
        scene.lights.back().position = glm::vec3(lamp.position - scene.origin);
    }
    if (!sidecar.sun) scene.furtherSuns = content.furtherSuns;
    scene.notes = content.notes.lines();
    return scene;
}

/// Readers of other people's formats crash, run away and ask for all memory on some files: a child process reads.
Scene readInChild(const fs::path& file) {
    try {
        base::Child child(limitsFor(file), [&](base::Child::Output& out) {
            put(out, readContent(file));
            put(out, base::notedInputs());
        });
        Scene scene = getScene(child);
        for (const std::string& input : getFiles(child)) base::noteInput(input);
        return scene;
    } catch (const base::Child::Failure& e) {
        throw base::UsageError(fmt::format("{}: cannot be read: its reader {}", file.string(), e.what()));
    }
}

}  // namespace

Scene importFile(const fs::path& file) {
    std::error_code error;
    const auto fail = [&](const char* why) { throw base::UsageError(fmt::format("{}: {}", file.string(), why)); };
    if (!fs::exists(file, error)) fail("no such file");
    if (fs::is_directory(file, error)) fail("is a folder, not a scene");
    if (!fs::is_regular_file(file, error)) fail("is not a regular file");
    if (fs::file_size(file, error) == 0) fail("is empty");
    Scene scene = readInChild(file);
    if (scene.views.empty()) scene.views = chooseViews(scene);
    for (const std::string& note : scene.notes) base::logWarning(fmt::format("{}: {}", file.string(), note));
    validate(scene);
    return scene;
}

}  // namespace dapple::scenegen
