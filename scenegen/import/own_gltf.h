#pragma once

#include "scenegen/import/gltf_document.h"
#include "scenegen/scene.h"

#include <optional>

namespace dapple::scenegen {

/// The scene that writeGlb() wrote, with the same content hash, whichever program has copied or compressed the file since; nothing
/// for a file of other origin, and for one whose nodes, meshes or materials another program has arranged anew. Throws UsageError
/// when the file is damaged.
std::optional<Scene> readOwnGltf(GltfDocument& document);

}  // namespace dapple::scenegen
