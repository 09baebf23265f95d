#include "bench/picture.h"

#include "base/error.h"
#include "base/file.h"
#include "base/file_name.h"
#include "base/hash.h"
#include "bench/light_picture.h"
#include "frame/overlays.h"

#include <fmt/format.h>
#include <glm/gtc/type_ptr.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <fstream>

namespace dapple::bench {
namespace {

using nlohmann::json;

const std::array<PictureKind, 10> kKinds{{{"shaded", "the lit picture"},
                                         {"visibility", "the technique's visibility image V"},
                                         {"reference", "ray-traced truth: lit, shadowed, ambiguous, excluded"},
                                         {"error", "V against the truth: false shadow red, false light blue"},
                                         {"overdraw", "fragments per pixel"},
                                         {"candidates", "pixels inside the casters' shadow volumes: lit green, in shadow red"},
                                         {"depth", "distance along the view"},
                                         {"map", "the shadow map, or all maps side by side"},
                                         {"casters", "the sun's view of each map: casters left out grey, drawn orange, darkening what is in sight blue; receivers yellow"},
                                         {"masks", "the maps, and in yellow the masks of receivers in sight (cull receivers, cull pyramid)"}}};

json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// Rows of a matrix, as one writes it on paper: clip = M · (x, y, z, 1).
json matrixJson(const glm::dmat4& m) {
    json rows = json::array();
    for (int r = 0; r < 4; ++r) rows.push_back({m[0][r], m[1][r], m[2][r], m[3][r]});
    return rows;
}

json sidecar(const SharedFrame& shared, const shadow::Renderer& renderer, const PointSpec& spec, const std::string& what) {
    const frame::Camera& camera = shared.frame.camera();
    const scenegen::Scene& scene = shared.loaded->scene;
    json passes = json::array(), matrices = json::array();
    for (const frame::Pass& pass : renderer.passes()) {
        json entry{{"name", pass.name}, {"why", pass.why}};
        if (!pass.leftOut.empty()) entry["left_out"] = pass.leftOut;
        passes.push_back(entry);
    }
    if (renderer.technique())
        for (const shadow::LightMatrix& m : renderer.technique()->matrices())
            matrices.push_back({{"name", m.name}, {"clip_from_relative", matrixJson(m.clipFromRelative)}});
    return {{"what", what},
            {"scene", spec.scene},
            {"scene_hash", base::hex16(shared.loaded->hash)},
            {"scene_origin_m", vectorJson(scene.origin)},
            {"technique", spec.technique},
            {"settings", spec.settings},
            {"stress", spec.stressCase},
            {"fallback", renderer.fallback()},
            {"width", camera.width},
            {"height", camera.height},
            {"convention", "metres; right-handed, z up; points are relative to the eye; matrices are lists of rows, clip = M (x, y, z, 1); "
                           "clip z in [0, 1], camera depth reversed (1 = near); texture v grows upwards in light maps"},
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
            {"sun", {{"azimuth_deg", scene.sun.azimuth}, {"elevation_deg", scene.sun.elevation}, {"light_direction", vectorJson(shared.frame.light())}}},
            {"light_matrices", matrices},
            {"passes", passes}};
}

std::vector<base::ImageF> mapLayers(const frame::Frame& frame, const gl::Texture& map) {
    std::vector<base::ImageF> layers;
    for (int i = 0; i < std::max(map.layers(), 1); ++i) layers.push_back(frame.readChannel(map, i));
    return layers;
}

base::ImageF channel(std::vector<float> values, int width, int height) { return {width, height, 1, std::move(values)}; }

/// Throws UsageError if the picture or its .json would replace an input, or the .json one that is no picture's.
void requireReplaceable(const std::filesystem::path& picture, const std::filesystem::path& beside) {
    for (const std::filesystem::path& written : {picture, beside}) base::requireNotAnInput(written);
    if (!std::filesystem::exists(beside)) return;
    std::ifstream stream(beside);
    const json known = json::parse(stream, nullptr, false);
    if (!known.is_object() || !known.contains("scene_hash") || !known.contains("light_matrices"))
        throw base::UsageError(fmt::format("{} is not a picture's and would be replaced by the one that goes with {}; name another file with -o",
                                           beside.string(), picture.string()));
}

}  // namespace

std::span<const PictureKind> pictureKinds() { return kKinds; }

void renderPicture(GlWorkbench& workbench, const PointSpec& spec, const std::string& what, const std::filesystem::path& file) {
    std::vector<std::string> known;
    for (const PictureKind& kind : kKinds) known.push_back(kind.name);
    if (std::find(known.begin(), known.end(), what) == known.end()) throw base::UsageError(base::unknownName("picture", what, known));
    const std::string suffix = file.extension().string();
    if (suffix != ".png" && suffix != ".exr") throw base::UsageError(fmt::format("{}: a picture ends in .png or .exr", file.string()));
    const bool numbers = suffix == ".exr";
    const std::filesystem::path beside = std::filesystem::path(file).replace_extension(".json");

    const auto shared = workbench.sharedFrame(spec);
    requireReplaceable(file, beside);
    frame::Frame& frame = shared->frame;
    if (const auto reason = shadow::pruneReason(shadow::technique(spec.technique), spec.settings, shared->loaded->gpu.facts(), workbench.limits()))
        throw base::UsageError(fmt::format("{}: {}", spec.technique, *reason));
    shadow::Renderer renderer(frame, shadow::technique(spec.technique), spec.settings);
    frame::PassObserver silent;
    renderer.render(silent);
    if (!renderer.hasVisibility() && what != "shaded")
        throw base::UsageError(fmt::format("technique {} has only a shaded picture, no {}", spec.technique, what));
    const gl::Texture* map = renderer.technique() ? renderer.technique()->map() : nullptr;
    if (what == "map" && !map) throw base::UsageError(fmt::format("technique {} has no map here (see \"passes\" of another picture's .json)", spec.technique));

    base::Image8 picture;
    base::ImageF values;
    const int w = spec.width, h = spec.height;
    if (what == "shaded") {
        picture = frame.readShaded();
        if (numbers) {
            values = {w, h, 3, {}};
            for (const uint8_t t : picture.texels) values.texels.push_back(t <= 10 ? t / 255.f / 12.92f : std::pow((t / 255.f + 0.055f) / 1.055f, 2.4f));
        }
    } else if (what == "visibility") {
        const std::vector<float> v = renderer.visibility();
        picture = frame::paintVisibility(v, w, h);
        values = channel(v, w, h);
    } else if (what == "overdraw") {
        values = renderer.overdraw();
        picture = frame::paintOverdraw(values);
    } else if (what == "candidates") {
        const auto volumes = renderer.candidates();
        if (!volumes) throw base::UsageError(fmt::format("technique {} finds no candidate pixels with these settings: it draws no shadow volumes", spec.technique));
        values = *volumes;
        picture = frame::paintCandidates(frame.readShaded(), values, renderer.visibility());
    } else if (what == "depth") {
        values = frame.readChannel(frame.depth());
        picture = frame::paintDepth(values, frame.camera());
        for (float& d : values.texels) d = d == 0 ? 0 : float(frame.camera().eyeDepth(double(d)));
    } else if (what == "casters" || what == "masks") {
        if (numbers) throw base::UsageError(fmt::format("{} is a picture in false colours: .png", what));
        picture = what == "casters" ? paintCastersDrawn(*shared, renderer) : paintReceiverMasks(*shared, renderer);
    } else if (what == "map") {
        const std::vector<base::ImageF> layers = mapLayers(frame, *map);
        picture = frame::paintMap(layers);
        values = layers.front();  // further layers under each other
        for (size_t i = 1; i < layers.size(); ++i) values.texels.insert(values.texels.end(), layers[i].texels.begin(), layers[i].texels.end());
        values.height *= int(layers.size());
    } else {
        const base::Image8 shaded = frame.readShaded();
        const std::vector<float> v = renderer.visibility();
        const truth::Reference& reference = shared->reference();
        picture = what == "error" ? frame::paintError(shaded, reference, v) : frame::paintReference(reference);
        std::vector<float> numbersOf(v.size());
        for (size_t i = 0; i < v.size(); ++i) {
            const truth::Label label = reference.label[i];
            const bool decided = label == truth::Label::lit || label == truth::Label::shadowed;
            const float g = label == truth::Label::lit ? 1.f : 0.f;
            // reference: 1 lit, 0 dark, −1 not decided; error: V − G where G is decided, else 0.
            numbersOf[i] = what == "error" ? (decided ? v[i] - g : 0.f) : (decided ? g : -1.f);
        }
        values = channel(std::move(numbersOf), w, h);
    }
    if (numbers) base::writeExr(file, values);
    else base::writePng(file, picture);
    base::writeFile(beside, sidecar(*shared, renderer, spec, what).dump(2) + "\n");
}

}  // namespace dapple::bench
