#include "scenegen/plants/tree.h"

#include "base/error.h"
#include "scenegen/plants/bark.h"

#include <fmt/format.h>

namespace dapple::scenegen {
namespace {

/// Times its size that a leaf may grow at each level of detail: near by it must look like a leaf, far away like a bough.
constexpr double kMaxGrowth[kLods] = {3.5, 6, 12};

}  // namespace

Tree growTree(const Species& species, const TreeOptions& options) {
    Skeleton skeleton = growSkeleton(species, options.seed);
    const BarkPlan plan = planBark(species, skeleton, size_t(species.barkShare * double(options.triangles)), options.lod);
    const std::vector<LeafSite> sites = leafSites(species, skeleton, plan.kept, options.leaves, options.lod > 0);
    size_t leaves = naturalLeaves(sites);
    if (options.triangles > 0) {
        if (leaves == 0 || plan.triangles + 4 > options.triangles)
            throw base::UsageError(fmt::format("species {}: {} triangles are too few for a tree with trunk, twigs and leaves",
                                               species.name, options.triangles));
        leaves = (options.triangles - plan.triangles) / 2;
    }
    return {buildBark(species, skeleton, plan),
            buildLeaves(species, sites, options.leaves, leaves, kMaxGrowth[size_t(options.lod)], options.seed)};
}

}  // namespace dapple::scenegen
