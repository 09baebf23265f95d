#pragma once

#include "scenegen/import/file_scene.h"
#include "scenegen/import/gltf_document.h"

#include <filesystem>

namespace dapple::scenegen {

/// True for names that end as those of glTF do.
bool isGltf(const std::filesystem::path& file);

/// The document's scene: nodes with meshes, EXT_mesh_gpu_instancing, skins and morph targets as they stand, cameras, and the lights
/// of KHR_lights_punctual. Its notes are added to the scene's. Throws the UsageErrors of importFile().
FileScene readGltf(GltfDocument& document, const Sidecar& sidecar);

}  // namespace dapple::scenegen
