#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// A coarser level of detail: about `keep` (0 < keep ≤ 1) of the triangles.
/// Closed meshes are decimated by quadric error metrics (Garland and Heckbert 1997) and stay closed; in open ones,
/// whose components are leaves or cards, whole components go and the rest grow so that the area remains.
Prototype decimate(const Prototype& prototype, double keep);

}  // namespace dapple::scenegen
