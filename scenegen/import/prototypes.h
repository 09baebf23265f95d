#pragma once

#include "scenegen/import/file_scene.h"

namespace dapple::scenegen {

struct CutCounts {
    size_t degenerate = 0;  ///< triangles dropped, over all instances
    size_t turned = 0;      ///< closed parts that were wound inwards
};

/// Cuts a file into prototypes and instances: origin, materials' sidedness and closedness are set too.
///
/// A node's linear part is L = s · Rz(yaw) · B with s = ∛|det L| and yaw such that B's most horizontal column
/// has no y component: similarities about the vertical have B = 1, and nodes which use the same meshes with
/// the same B share one prototype with B baked in. Prototypes with a single instance are static: when there
/// are more than 64 of them they are merged by material within squares of `cell` metres, which bounds the
/// draw calls and leaves frustum culling something to do.
CutCounts cutIntoPrototypes(FileScene& file, double cell, Scene& scene);

}  // namespace dapple::scenegen
