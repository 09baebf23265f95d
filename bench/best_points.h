#pragma once

#include "bench/plan.h"

#include <filesystem>
#include <string>
#include <vector>

namespace dapple::bench {

/// What a run found out about one shadowed point.
struct MeasuredPoint {
    std::string pointId;
    double error = 0;                       ///< share of the valid pixels
    double frameMs = 0;
    std::optional<double> overUnshadowed;   ///< ratio of frame times
    std::optional<double> textureBytes;
};

/// The points of metrics.csv that have both an error and a frame time; the baselines, which draw no shadow,
/// are left out. Throws Error (exit 4) for a damaged file.
std::vector<MeasuredPoint> measuredPoints(const std::filesystem::path& metricsCsv);

/// At most `count` points, fastest first: the Pareto front of error against time (no other point is both
/// faster and better), spread evenly over it with both ends if it is longer, and filled from the front of what remains
/// if it is shorter.
std::vector<MeasuredPoint> bestPoints(std::vector<MeasuredPoint> points, size_t count);

/// A table for people: technique and settings, error, time, ratio to the unshadowed frame, memory.
std::string bestPointsTable(const std::vector<MeasuredPoint>& points, const Plan& plan);

}  // namespace dapple::bench
