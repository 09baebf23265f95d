#pragma once

#include "bench/gl_workbench.h"

namespace dapple::bench {

/// The frame last rendered as the sun sees it through the window of each map: which casters stand in it, which were drawn, which of
/// those the reference's rays find to darken a pixel in sight (Mattausch et al. 2011, fig. 1.1). Throws UsageError: the technique draws no map of the scene.
base::Image8 paintCastersDrawn(SharedFrame& shared, shadow::Renderer& renderer);

/// The maps with the masks of receivers in sight (fig. 1.3). Throws UsageError: nothing asks for receivers.
base::Image8 paintReceiverMasks(const SharedFrame& shared, const shadow::Renderer& renderer);

}  // namespace dapple::bench
