#include "scenegen/plants/tree.h"

#include "base/error.h"
#include "scenegen/plants/bark.h"

#include <fmt/format.h>

#include <numeric>

namespace dapple::scenegen {
namespace {

/// Of the species' own share of bark: far away only trunks are seen through the leaves.
constexpr double kBarkShare[kLods] = {1, 0.8, 0.5};

}  // namespace

Tree growTree(const Species& species, const TreeOptions& options) {
    Skeleton skeleton = options.wind ? growSkeleton(species, options.seed) : growLimbs(species, options.seed);
    if (options.wind) sway(skeleton, *options.wind, options.seed);
    const BarkPlan plan = planBark(species, skeleton, size_t(kBarkShare[options.lod] * species.barkShare * double(options.triangles)), options.lod);
    if (options.lod > 0) {
        // Leaves float where a twig would be.
        std::vector<uint32_t> all(skeleton.stems.size());
        std::iota(all.begin(), all.end(), 0u);
        growTwigs(species, options.seed, skeleton, all);
    } else {
        growTwigs(species, options.seed, skeleton, plan.kept);
    }
    const std::vector<LeafSite> sites = leafSites(species, skeleton, plan.kept, options.leaves, options.lod > 0);
    size_t leaves = naturalLeaves(sites);
    if (options.triangles > 0) {
        if (leaves == 0 || plan.triangles + 4 > options.triangles)
            throw base::UsageError(fmt::format("species {}: {} triangles are too few for a tree with trunk, twigs and leaves",
                                               species.name, options.triangles));
        // Solid leaves are those that the budget gives as polygons.
        leaves = (options.triangles - plan.triangles) / leafTriangles(leafShape(species, options.lod), options.leaves == LeafMode::card ? LeafMode::card : LeafMode::polygon);
    }
    return {buildBark(species, skeleton, plan),
            buildLeaves(species, sites, options.leaves, leaves, options.lod, options.seed)};
}

}  // namespace dapple::scenegen
