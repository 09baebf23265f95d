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

/// Those that no other beats in both error and frame time, fastest first: the same that the plot marks. The points must be of
/// one scene, variant and view, else their times do not compare.
std::vector<MeasuredPoint> paretoFront(std::vector<MeasuredPoint> points);

/// A table for people: technique and settings, error, time, ratio to the unshadowed frame, memory.
std::string pointsTable(const std::vector<MeasuredPoint>& points, const Plan& plan);

}  // namespace dapple::bench
