#pragma once

#include "bench/gl_workbench.h"

namespace dapple::bench {

/// A point made ready to be rendered, timed, counted and compared. The timer must outlive it. Throws base::Error where its technique
/// cannot be made.
std::unique_ptr<OpenPoint> makeGlPoint(std::shared_ptr<SharedFrame> shared, measure::Timer& timer, const PointSpec& spec);

}  // namespace dapple::bench
