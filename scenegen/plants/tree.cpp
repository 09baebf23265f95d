#include "scenegen/plants/tree.h"

#include "base/error.h"
#include "scenegen/plants/bark.h"

#include <fmt/format.h>

namespace dapple::scenegen {

Tree growTree(const Species& species, const TreeOptions& options) {
    Skeleton skeleton = growSkeleton(species, options.seed);
    const BarkPlan plan = planBark(species, skeleton, size_t(species.barkShare * double(options.triangles)));
    size_t leaves = naturalLeaves(species, skeleton, plan.kept, options.leaves);
    if (options.triangles > 0) {
        if (leaves == 0 || plan.triangles + 4 > options.triangles)
            throw base::UsageError(fmt::format("species {}: {} triangles are too few for a tree with trunk, twigs and leaves",
                                               species.name, options.triangles));
        leaves = (options.triangles - plan.triangles) / 2;
    }
    return {buildBark(species, skeleton, plan), buildLeaves(species, skeleton, plan.kept, options.leaves, leaves, options.seed)};
}

}  // namespace dapple::scenegen
