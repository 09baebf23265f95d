#pragma once

#include "scenegen/plants/skeleton.h"
#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

/// How finely stems are meshed, from a triangle budget.
struct BarkPlan {
    int coarser = 0;             ///< 0: as the species says; each step takes detail away from every stem
    std::vector<uint32_t> kept;  ///< stems that are meshed, ascending; a child is never kept without its parent
    size_t triangles = 0;
};

/// The finest plan of at most `budget` triangles (0 = no limit). Less budget means, in this order: half of the twigs,
/// levels of subdivision, sides, rings (thinned in `skeleton`), limbs. Coarser levels of detail give up twigs sooner
/// and thin rings further. Trunks always stay, so `triangles` can exceed a budget that is too small for them.
BarkPlan planBark(const Species& species, Skeleton& skeleton, size_t budget, int lod = 0);

/// One closed, oriented tube per kept stem, on the limit surface, in kLanes at a time.
Mesh buildBark(const Species& species, const Skeleton& skeleton, const BarkPlan& plan);

}  // namespace dapple::scenegen
