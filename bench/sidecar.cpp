#include "bench/sidecar.h"

#include "base/hash.h"

#include <nlohmann/json.hpp>

#include <array>

namespace dapple::bench {
namespace {

using nlohmann::json;

constexpr const char* kConvention =
    "metres; right-handed, z up; points are relative to the eye; matrices are lists of rows, clip = M (x, y, z, 1); clip z in [0, 1], camera "
    "depth reversed (1 = near); rows of pictures count from the top; texture v grows upwards in light maps";

/// How maps of a whole scene are asked (shaders/lib/map_lookup.glsl, bias.glsl, filter.glsl).
const std::array kLookup{
    "receiver: p = d (forward + x tan_half_fov[0] right + y tan_half_fov[1] up), d of the depth picture, (x, y) the pixel's centre from -1 to 1",
    "a sky pixel has V = 1; a pixel whose normal n has dot(n, light_direction) >= 0 has V = 0; neither asks a map",
    "map: the entry of light_matrices whose eye_depth_m holds d, from included, to excluded; no entry, or used false: V = 1",
    "facing = max(-dot(n, light_direction), 1e-4); texel = the longer of texel_m; r = 0 (filter nearest), 0.5 (pcf2), 1.5 (pcf3); k = bias-scale",
    "slope = (|dot(n, basis_u)| texel_m[0] + |dot(n, basis_v)| texel_m[1]) / facing",
    "bias constant: along = k texel; slope: along = k min((r + 0.5) slope, 8 texel); "
    "normal-offset: along = 0, and p moves by n k texel (r + 0.5) 2 (1 + dot(n, light_direction))",
    "moved = p - light_direction (along + 2 depth_step_m); (u, v, z) = clip_from_relative moved, divided by w; place in texels = (u / 2 + 1/2, v / 2 + 1/2) size",
    "one texel's answer is 1 where min(z, 1) <= the map there, else 0; outside the map it is 1",
    "filter nearest: the texel that holds the place; pcf2: four texels, bilinear about the place; pcf3: per axis the texels b - 2 … b + 1 with the "
    "weights 1 - s, 2 - s, 1 + s and s, each over 4, where b = floor(place + 1/2) and s = place + 1/2 - b",
    "a map with texel_m null is warped: slope there follows from clip_from_relative at the receiver; V is rounded to 16-bit floats"};

json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Rows of a matrix, as one writes it on paper: clip = M · (x, y, z, 1).
json matrixJson(const glm::dmat4& m) {
    json rows = json::array();
    for (int r = 0; r < 4; ++r) rows.push_back({m[0][r], m[1][r], m[2][r], m[3][r]});
    return rows;
}

json matricesJson(const shadow::Technique* technique) {
    json matrices = json::array();
    if (!technique) return matrices;
    for (const shadow::LightMatrix& m : technique->matrices()) {
        json entry{{"name", m.name}, {"clip_from_relative", matrixJson(m.clipFromRelative)}};
        if (m.slice) {
            entry["layer"] = m.slice->layer;
            entry["eye_depth_m"] = {m.slice->from, m.slice->to};
            entry["depth_step_m"] = m.slice->depthStep;
            entry["texel_m"] = m.slice->texel ? json{m.slice->texel->x, m.slice->texel->y} : json();
            entry["basis_u"] = vectorJson(m.slice->u);
            entry["basis_v"] = vectorJson(m.slice->v);
            entry["used"] = m.slice->used;
        }
        matrices.push_back(std::move(entry));
    }
    return matrices;
}

json sunsJson(SharedFrame& shared, const shadow::Renderer& renderer) {
    json suns = json::array();
    for (size_t i = 0; i < shared.frame.suns(); ++i) {
        const frame::OfSun guard(shared.frame, i);
        const scenegen::Sun& sun = shared.frame.sun();
        suns.push_back({{"azimuth_deg", sun.azimuth}, {"elevation_deg", sun.elevation}, {"strength", sun.strength},
                        {"light_direction", vectorJson(shared.frame.light())}, {"light_matrices", matricesJson(renderer.technique(i))}});
    }
    return suns;
}

}  // namespace

std::string sidecar(SharedFrame& shared, const shadow::Renderer& renderer, const PointSpec& spec, const PictureKind& kind) {
    const frame::Camera& camera = shared.frame.camera();
    const scenegen::Scene& scene = shared.loaded->scene;
    json passes = json::array();
    for (const frame::Pass& pass : renderer.passes()) {
        json entry{{"name", pass.name}, {"why", pass.why}};
        if (!pass.leftOut.empty()) entry["left_out"] = pass.leftOut;
        passes.push_back(entry);
    }
    json suns = sunsJson(shared, renderer);
    json first = suns[0], matrices = first["light_matrices"];
    first.erase("light_matrices");
    const json all{{"what", kind.name},
               {"values", kind.values},
               {"scene", spec.scene},
               {"scene_hash", base::hex16(shared.loaded->hash)},
               {"scene_origin_m", vectorJson(scene.origin)},
               {"technique", spec.technique},
               {"settings", spec.settings},
               {"stress", spec.stressCase},
               {"fallback", renderer.fallback()},
               {"width", camera.width},
               {"height", camera.height},
               {"convention", kConvention},
               {"lookup", kLookup},
               {"camera",
                {{"view", spec.view},
                 {"eye_from_origin_m", vectorJson(camera.eye)},
                 {"right", vectorJson(camera.right)},
                 {"up", vectorJson(camera.up)},
                 {"forward", vectorJson(camera.forward)},
                 {"near_m", camera.near},
                 {"far_m", camera.far},
                 {"tan_half_fov", {camera.tanX, camera.tanY}},
                 {"clip_from_relative", matrixJson(camera.clipFromRelative)}}},
               {"sun", first},
               {"light_matrices", matrices},
               {"suns", suns},
               {"passes", passes}};
    return all.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace dapple::bench
