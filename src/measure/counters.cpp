#include "measure/counters.h"

#include "base/error.h"

#include <array>
#include <vector>

namespace dapple::measure {

namespace {

using enum Better;

constexpr std::array kMetrics{
    // time
    MetricInfo{metric::kFrameTime, "ms", lower, false, "whole frame, without fences between its passes"},
    MetricInfo{"frame_time_mean", "ms", lower, false, "mean over the timed frames of a [motion]; the machine's own spikes are among them"},
    MetricInfo{"frame_time_p95", "ms", lower, false, "... 95th percentile"},
    MetricInfo{"frame_time_p99", "ms", lower, false, "... 99th percentile"},
    MetricInfo{"frame_time_worst", "ms", lower, false, "... the slowest"},
    MetricInfo{metric::kPassTime, "ms", lower, false, "one pass, timed in frames of its own"},
    MetricInfo{metric::kFirstFrame, "ms", lower, false, "wall time of the first frame: compilation, uploads, first use"},
    // GL queries around each pass of an untimed frame
    MetricInfo{metric::kSamplesPassed, "samples", lower, true, "samples that passed the depth and stencil tests"},
    MetricInfo{metric::kFragmentInvocations, "invocations", lower, true,
               "fragment shader invocations; helper lanes and hidden fragments may count, as the driver likes"},
    MetricInfo{metric::kVertexInvocations, "invocations", lower, true, "vertex shader invocations"},
    MetricInfo{metric::kPrimitivesSubmitted, "primitives", lower, true, "primitives that the GPU was given, before culling"},
    MetricInfo{"overshade", "", lower, true, "fragment invocations / samples passed"},
    // the CPU's ledger
    MetricInfo{"draw_calls", "calls", lower, true, "draw commands; a multi-draw counts once"},
    MetricInfo{"triangles_submitted", "triangles", lower, true, "triangles that the GPU was given, times instances; what a culling on the GPU chose is read back"},
    MetricInfo{"casters_drawn", "instances", lower, true, "casters drawn into the maps of the scene, all maps together"},
    MetricInfo{"caster_triangles_drawn", "triangles", lower, true, "... their triangles"},
    MetricInfo{"casters_contributing", "instances", none, true, "casters that the reference's rays meet between a receiver in sight and the sun"},
    MetricInfo{"caster_triangles_contributing", "triangles", none, true, "... their triangles"},
    MetricInfo{"casters_efficiency", "", lower, true, "casters_drawn / casters_contributing"},
    // occlusion queries of a pass that culls with them; how many depends on when their results arrive
    MetricInfo{"occlusion_queries", "queries", lower, false, "occlusion queries asked"},
    MetricInfo{"occlusion_multiqueries", "queries", none, false, "... about more than one node of the hierarchy"},
    MetricInfo{"occlusion_boxes", "boxes", lower, false, "boxes drawn for them"},
    MetricInfo{"occlusion_bursts", "changes", lower, false, "changes from drawing to asking"},
    MetricInfo{"occlusion_stalls", "waits", lower, false, "waits for a result with nothing else to do"},
    MetricInfo{"occlusion_stall_time", "ms", lower, false, "... their wall time"},
    MetricInfo{"occlusion_nodes_visited", "nodes", lower, false, "nodes of the hierarchy that the traversal looked at"},
    MetricInfo{"texels_allocated", "texels", lower, true, "texels of the technique's maps"},
    MetricInfo{"texels_in_use", "texels", lower, true, "texels of maps, without the gaps between them"},
    MetricInfo{"texels_referenced", "texels", lower, true, "texels of instanced maps that the look-ups inside shadow volumes read, each once"},
    MetricInfo{"texels_written", "texels", lower, true, "texels of the maps that the frame cleared or rendered"},
    MetricInfo{"map_fragments", "fragments", lower, true, "fragments of casters in the maps, past the alpha test, hidden or not"},
    MetricInfo{"map_texels_filled", "texels", none, true, "texels of the maps that hold a caster, nearer than the far plane"},
    MetricInfo{"map_overdraw", "fragments/texel", lower, true, "map_fragments / map_texels_filled"},
    MetricInfo{"planned_map_bytes", "B", lower, true, "most bytes that instanced maps may take, known before they are allocated; at most axis memory"},
    MetricInfo{"texture_bytes", "B", lower, true, "format x extent x layers x mips x samples of the technique's maps"},
    MetricInfo{"driver_bytes", "B", lower, false, "GPU memory that the technique took by the driver's own figure"},
    // overdraw of the geometry that the camera sees
    MetricInfo{"geometry_overdraw_mean", "fragments/pixel", lower, true, "fragments of the geometry that the camera sees, per pixel"},
    MetricInfo{"geometry_overdraw_max", "fragments/pixel", lower, true, "... most of one pixel"},
    MetricInfo{"geometry_overdraw_0", "pixels", none, true, "... pixels with no fragment"},
    MetricInfo{"geometry_overdraw_1", "pixels", none, true, "... pixels with 1 fragment"},
    MetricInfo{"geometry_overdraw_2", "pixels", none, true, "... pixels with 2 fragments"},
    MetricInfo{"geometry_overdraw_3-4", "pixels", none, true, "... pixels with 3 or 4 fragments"},
    MetricInfo{"geometry_overdraw_5-8", "pixels", none, true, "... pixels with 5 to 8 fragments"},
    MetricInfo{"geometry_overdraw_9-16", "pixels", none, true, "... pixels with 9 to 16 fragments"},
    MetricInfo{"geometry_overdraw_>16", "pixels", none, true, "... pixels with more than 16 fragments"},
    // overdraw of shadow volumes
    MetricInfo{"volume_overdraw_mean", "fragments/pixel", lower, true, "fragments of shadow volumes, per pixel"},
    MetricInfo{"volume_overdraw_max", "fragments/pixel", lower, true, "... most of one pixel"},
    MetricInfo{"volume_overdraw_0", "pixels", none, true, "... pixels with no fragment"},
    MetricInfo{"volume_overdraw_1", "pixels", none, true, "... pixels with 1 fragment"},
    MetricInfo{"volume_overdraw_2", "pixels", none, true, "... pixels with 2 fragments"},
    MetricInfo{"volume_overdraw_3-4", "pixels", none, true, "... pixels with 3 or 4 fragments"},
    MetricInfo{"volume_overdraw_5-8", "pixels", none, true, "... pixels with 5 to 8 fragments"},
    MetricInfo{"volume_overdraw_9-16", "pixels", none, true, "... pixels with 9 to 16 fragments"},
    MetricInfo{"volume_overdraw_>16", "pixels", none, true, "... pixels with more than 16 fragments"},
    MetricInfo{"candidates", "pixels", lower, true, "pixels that face the sun in at least one caster's shadow volume"},
    MetricInfo{"candidates_mean", "look-ups/pixel", lower, true, "casters' shadow volumes that hold a pixel's receiver, 0 where it faces away from the sun: the maps that it must ask"},
    // image error against the ray-traced reference, shares of the valid pixels
    MetricInfo{"error", "", lower, true, "false_shadow + false_light"},
    MetricInfo{"false_shadow", "", lower, true, "dark where the reference is lit"},
    MetricInfo{"false_shadow_boundary", "", lower, true, "... within 2 px of the reference's shadow boundary"},
    MetricInfo{"false_shadow_interior", "", lower, true, "... farther: acne"},
    MetricInfo{"false_light", "", lower, true, "lit where the reference is dark"},
    MetricInfo{"false_light_boundary", "", lower, true, "... within 2 px of the reference's shadow boundary"},
    MetricInfo{"false_light_interior", "", lower, true, "... farther: leak"},
    MetricInfo{"mean_absolute", "", lower, true, "mean |visibility - reference|"},
    MetricInfo{"edge_mean", "px", lower, true, "mean distance between the shadow boundaries of image and reference"},
    MetricInfo{"edge_p95", "px", lower, true, "95th percentile of that distance"},
    MetricInfo{"edge_max", "px", lower, true, "greatest such distance"},
    MetricInfo{"flips", "", lower, true, "mean |visibility - that of the frame before|, over pixels valid in both; where the camera moves, of the same surface"},
    MetricInfo{"reference_flips", "", none, true, "the same of the reference: what the motion of sun or camera changes"},
    MetricInfo{"excess_flips", "", lower, true, "flips - reference_flips: popping; below 0 where shadows lag behind"},
    MetricInfo{"map_age_mean", "frames", lower, true, "since a map in use last showed what it is used for, mean over the maps in use"},
    MetricInfo{"map_age_worst", "frames", lower, true, "... of the oldest"},
    MetricInfo{"map_lag_mean", "deg", lower, true, "angle between the light of a map in use and the present one, mean over the maps in use"},
    MetricInfo{"map_lag_worst", "deg", lower, true, "... of the map that is farthest behind"},
    MetricInfo{"half_pixel_sensitivity", "", none, true, "error of the reference itself, traced half a pixel to the right and half a pixel upwards; their mean"},
    MetricInfo{"valid", "", none, true, "valid pixels / pixels"},
    MetricInfo{"ambiguous", "", none, true, "ambiguous pixels / (valid + ambiguous)"},
    MetricInfo{"shadowed", "", none, true, "pixels dark in the reference / valid"},
};

}  // namespace

std::string_view betterName(Better better) {
    return better == lower ? "lower" : better == higher ? "higher" : "none";
}

std::span<const MetricInfo> metrics() { return kMetrics; }

const MetricInfo& metricInfo(std::string_view name) {
    std::vector<std::string> known;
    for (const MetricInfo& info : kMetrics) {
        if (info.name == name) return info;
        known.emplace_back(info.name);
    }
    throw base::UsageError(base::unknownName("metric", name, known));
}

}  // namespace dapple::measure
