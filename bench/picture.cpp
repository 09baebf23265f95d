#include "bench/picture.h"

#include "base/error.h"
#include "base/file.h"
#include "base/file_name.h"
#include "bench/light_picture.h"
#include "bench/sidecar.h"
#include "frame/error_picture.h"
#include "frame/overlays.h"
#include "truth/metrics.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <fstream>

namespace dapple::bench {
namespace {

constexpr float kAmbiguous = -2, kExcluded = -3;  // of the .exr of reference and error

const std::array<PictureKind, 12> kKinds{{
    {"shaded", "the lit picture", "linear R, G, B of the 8-bit picture, 0 to 1"},
    {"visibility", "the technique's visibility image V", "V: share of the sun's light that arrives, 0 dark to 1 lit"},
    {"reference", "ray-traced truth: lit, shadowed, ambiguous, excluded",
     "G: share of the sun's light that arrives, 0 dark to 1 lit; -2 ambiguous, -3 excluded (sky, or turned away from the sun)"},
    {"error", "V against the truth: false shadow red, false light blue",
     "V - G, from -1 to 1 (a V that is no number counts as wholly wrong); -2 ambiguous, -3 excluded (sky, or turned away from the sun). mean_absolute is "
     "the mean of |V - G| over all other pixels; error is the share of them where V and G lie on different sides of 1/2"},
    {"overdraw", "fragments per pixel of the geometry that the camera sees", "fragments of the pixel"},
    {"volume-overdraw", "fragments per pixel of shadow volumes", "fragments of the pixel"},
    {"candidates", "pixels inside the casters' shadow volumes: lit green, in shadow red", "casters' shadow volumes that hold the pixel's receiver"},
    {"depth", "distance along the view", "metres along camera.forward; 0 sky"},
    {"normals", "geometric normals of what is in sight", "unit vector x, y, z in world axes, on the viewer's side; 0, 0, 0 sky"},
    {"map", "the shadow map, or all maps side by side",
     "depth from the sun, 0 to 1 as light_matrices has it, 1 where nothing was drawn; layer 0 first, further layers under each other, "
     "the first row of each is the one with the greatest v"},
    {"casters", "the sun's view of each map: casters left out grey, drawn orange, darkening what is in sight blue; receivers yellow", ""},
    {"masks", "the maps, and in yellow the masks of receivers in sight (cull receivers, cull pyramid)", ""}}};

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
    const nlohmann::json known = nlohmann::json::parse(stream, nullptr, false);
    if (!known.is_object() || !known.contains("scene_hash") || !known.contains("light_matrices"))
        throw base::UsageError(fmt::format(
            "{} is not a picture's and would be replaced by the one that goes with {}; name another file with -o",
            beside.string(), picture.string()));
}

/// What a figure of the error makes of every pixel, or the truth itself.
base::ImageF judged(const truth::Reference& reference, const std::vector<float>* visibility) {
    std::vector<float> values(reference.label.size());
    for (size_t i = 0; i < values.size(); ++i) {
        const truth::Label label = reference.label[i];
        if (label == truth::Label::ambiguous) values[i] = kAmbiguous;
        else if (label == truth::Label::excluded) values[i] = kExcluded;
        else values[i] = visibility ? truth::difference(reference, i, (*visibility)[i]) : reference.value(i);
    }
    return channel(std::move(values), reference.width, reference.height);
}

base::ImageF normalsOf(const truth::Receivers& seen) {
    base::ImageF image{seen.width, seen.height, 3, {}};
    for (size_t i = 0; i < seen.present.size(); ++i)
        for (int k = 0; k < 3; ++k) image.texels.push_back(seen.present[i] ? seen.normal[i][k] : 0);
    return image;
}

}  // namespace

std::span<const PictureKind> pictureKinds() { return kKinds; }

void renderPicture(GlWorkbench& workbench, const PointSpec& spec, const std::string& what, const std::filesystem::path& file) {
    std::vector<std::string> known;
    for (const PictureKind& kind : kKinds) known.push_back(kind.name);
    const auto kind = std::ranges::find(kKinds, what, &PictureKind::name);
    if (kind == kKinds.end()) throw base::UsageError(base::unknownName("picture", what, known));
    const std::string suffix = file.extension().string();
    if (suffix != ".png" && suffix != ".exr") throw base::UsageError(fmt::format("{}: a picture ends in .png or .exr", file.string()));
    const bool numbers = suffix == ".exr";
    const std::filesystem::path beside = std::filesystem::path(file).replace_extension(".json");
    if (numbers && kind->values.empty()) throw base::UsageError(fmt::format("{} is a picture in false colours: .png", what));

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
        values = renderer.geometryOverdraw();
        picture = frame::paintOverdraw(values);
    } else if (what == "volume-overdraw") {
        const auto volumes = renderer.volumeOverdraw();
        if (!volumes) throw base::UsageError(fmt::format("technique {} draws no shadow volumes with these settings", spec.technique));
        values = *volumes;
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
    } else if (what == "normals") {
        values = normalsOf(frame.readReceivers());
        picture = frame::paintNormals(values);
    } else if (what == "casters" || what == "masks") {
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
        picture = what == "error" ? frame::paintErrorSheet(shaded, reference, v) : frame::paintReference(reference);
        values = judged(reference, what == "error" ? &v : nullptr);
    }
    if (numbers) base::writeExr(file, values);
    else base::writePng(file, picture);
    base::writeFile(beside, sidecar(*shared, renderer, spec, *kind));
}

}  // namespace dapple::bench
