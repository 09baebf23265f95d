#pragma once

#include "scenegen/library.h"
#include "scenegen/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// glTF 2.0 (gltf_reader.h), OBJ (obj_file.h), and any other file that Assimp opens (AC3D, Blender, COLLADA, …), as a scene.
///
/// Up axis and unit: what the file or its format says (file_space.h), else y and metres. Polygons may be concave.
/// Alpha testing and closedness are derived from the content, closed parts that face inwards are turned
/// (orientation.h), meshes that several nodes use become one prototype with several instances, and
/// sun and views come from the file or are chosen (scenegen/import/auto_views.h).
/// A .glb that writeGlb() made comes back as the scene that it was, to the bit.
/// A small TOML beside the file, NAME.toml for NAME.ext, overrides all this: scenegen/import/sidecar.h.
///
/// A child process reads: where a reader crashes, takes longer than 8 s and one more for each MB, or asks for too much
/// memory, the file is refused.
///
/// The result is validate()d. Throws UsageError naming the file: missing, empty, truncated, not a scene,
/// without a triangle, or with a vertex or node transform that is not finite (naming the node).
Scene importFile(const std::filesystem::path& file);

/// Scenes that a script prepares in base::cacheFolder()/real, sorted by name; the description says whether the scene is
/// there already, or which script fetches it.
std::vector<SceneEntry> listRealScenes();

bool isRealScene(const std::string& name);

/// What fetches a real scene: a Python script, relative to base::homeFolder(), and its argument (empty: none).
struct RealSceneScript {
    const char* file;
    const char* argument;
};
/// Throws UsageError: not a real scene.
RealSceneScript realSceneScript(const std::string& name);

/// File of the real scene `name`, a recipe or what importFile() reads. Throws UsageError: not a real scene, or not fetched yet (with the command).
std::filesystem::path realScenePath(const std::string& name);

}  // namespace dapple::scenegen
