#include "bench/best_points.h"

#include "base/file.h"
#include "bench/csv.h"
#include "bench/table.h"
#include "measure/counters.h"

#include <fmt/format.h>

#include <algorithm>

namespace dapple::bench {
std::vector<MeasuredPoint> measuredPoints(const std::filesystem::path& metricsCsv) {
    const CsvTable table(base::readFile(metricsCsv), metricsCsv.string());
    struct Found {
        std::optional<double> error, frameMs, ratio, bytes;
    };
    std::vector<std::string> order;
    std::map<std::string, Found> found;
    for (size_t row = 0; row < table.rows(); ++row) {
        const std::string& value = table.at(row, "median");
        if (!table.at(row, "pass").empty() || value.empty() || table.at(row, "status") != "ok") continue;
        if (shadow::technique(table.at(row, "technique")).family == "baseline") continue;
        const std::string& id = table.at(row, "point_id");
        if (!found.contains(id)) order.push_back(id);
        Found& point = found[id];
        const std::string& metric = table.at(row, "metric");
        if (metric == "error") point.error = std::stod(value);
        if (metric == measure::metric::kFrameTime) point.frameMs = std::stod(value);
        if (metric == "to_unshadowed") point.ratio = std::stod(value);
        if (metric == "texture_bytes") point.bytes = std::stod(value);
    }
    std::vector<MeasuredPoint> points;
    for (const std::string& id : order)
        if (const Found& p = found[id]; p.error && p.frameMs) points.push_back({id, *p.error, *p.frameMs, p.ratio, p.bytes});
    return points;
}

std::vector<MeasuredPoint> paretoFront(std::vector<MeasuredPoint> points) {
    std::stable_sort(points.begin(), points.end(), [](const MeasuredPoint& a, const MeasuredPoint& b) {
        return std::pair(a.frameMs, a.error) < std::pair(b.frameMs, b.error);
    });
    std::vector<MeasuredPoint> front;
    for (MeasuredPoint& p : points)
        if (front.empty() || p.error < front.back().error) front.push_back(std::move(p));
    return front;
}

std::string pointsTable(const std::vector<MeasuredPoint>& points, const Plan& plan) {
    std::vector<std::vector<std::string>> rows{{"technique", "settings", "error", "frame", "over unshadowed", "textures"}};
    for (const MeasuredPoint& p : points) {
        const auto planned = std::find_if(plan.points.begin(), plan.points.end(), [&](const PlannedPoint& q) { return q.id == p.pointId; });
        if (planned == plan.points.end()) continue;
        rows.push_back({planned->spec.technique, plan.differing(planned->spec), fmt::format("{:.3f} %", 100 * p.error),
                        fmt::format("{:.2f} ms", p.frameMs), p.overUnshadowed ? fmt::format("{:.2f}", *p.overUnshadowed) : "",
                        p.textureBytes ? fmt::format("{:.1f} MiB", *p.textureBytes / 0x1p20) : ""});
    }
    return alignColumns(rows);
}

}  // namespace dapple::bench
