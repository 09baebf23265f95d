#include "shadow/registry.h"

#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>

namespace dapple::shadow {
namespace {

const std::vector<Axis> kAxes{
    {"fit", "light-space parametrisation: what the map's window is fitted to",
     {{"scene", "bounds of the whole scene"},
      {"frustum", "bounds of the view frustum ∩ scene (focusing)"},
      {"lispsm", "frustum ∩ scene, warped (Wimmer, Scherzer, Purgathofer 2004)"}}},
    {"focus", "what a map's window is fitted to of the view",
     {{"frustum", "the view frustum ∩ scene"},
      {"visible", "the view frustum ∩ boxes of what the view has drawn (Mattausch et al. 2011, section 1.4): finer, and changes with what comes into sight"}}},
    {"split", "how the view's depth range is divided among maps",
     {{"none", "one map"}, {"practical", "λ · logarithmic + (1 − λ) · uniform (Zhang et al. 2006)"}}},
    {"cascades", "number of maps of a split", {}, 1, 8},
    {"lambda", "weight λ of the logarithmic split", {{"0", "uniform"}, {"0.5", ""}, {"0.75", ""}, {"0.95", ""}, {"1", "logarithmic"}}},
    {"size", "texels along a side of each map", {}, 1, 32768},
    {"camera", "what the view itself draws",
     {{"frustum", "instances whose boxes meet the view frustum"},
      {"none", "everything"},
      {"chc", "what occlusion queries find visible (Bittner, Wimmer, Piringer, Purgathofer 2004)"},
      {"chcpp", "the same, with batches, multiqueries and tight bounds (Mattausch, Bittner, Wimmer 2008)"},
      {"hiz", "what was visible in the last frame, then what its depth does not hide: hierarchical z in two phases, on the GPU"}}},
    {"cluster", "triangles that are drawn or left out as one, at most: a larger instance is culled in clusters; 0: in one piece", {}, 0, 1000000000},
    {"leaf", "triangles in a leaf of the hierarchy that occlusion queries go through, at most, unless one instance or cluster has more", {}, 1, 1000000000},
    {"batch", "invisible nodes that gather before chcpp asks about them", {}, 1, 1000},
    {"assumed-visible", "frames, on average, that chcpp takes a visible leaf for visible without asking", {}, 0, 1000},
    {"cull", "casters left out of a map, or of the volumes",
     {{"none", "none"},
      {"frustum", "those whose shadow cannot reach the part of the view that the map serves"},
      {"mask", "of volumes: as receivers, and those whose shadow cannot reach a receiver in sight, found on the GPU"},
      {"chc", "those that other casters hide from the sun, found by occlusion queries in the sun's view (2004)"},
      {"chcpp", "the same with CHC++: the reference of the receiver masks' paper"},
      {"hiz", "the same by hierarchical z in two phases, on the GPU"},
      {"receivers", "as chcpp, but queries count only where the map's mask of visible receivers is set (Mattausch et al. 2011); of volumes: those of frustum, "
                    "and at each pixel all, unless its surface faces the sun"},
      {"pyramid", "those that cover no texel that a receiver in sight looks up, or lie behind all such receivers, found on the GPU"}}},
    {"mask", "what a mask of visible receivers holds, for cull receivers",
     {{"scatter", "each texel that a visible pixel's look-up reads: exact"},
      {"box", "the boxes of the instances in sight, enlarged by what look-ups reach: exact, and large"},
      {"geometry", "their triangles: can miss a receiver between two texel centres"},
      {"fragment", "those fragments that the camera sees, by the reverse shadow test, nearest first (the paper's listing 1.1): misses "
                   "receivers between texel centres, and neighbours that a filter reads behind a hidden surface"},
      {"fragment-or", "the same without depth test: any such fragment sets its texel"}}},
    {"mask-test", "how an occlusion query reads the mask",
     {{"sampled", "its fragments look it up and are discarded (the paper's listing 1.2)"},
      {"stencil", "a stencil bit stops them"}}},
    {"bias", "what moves the receiver off its own surface",
     {{"constant", "along the light"},
      {"slope", "along the light, the least that suffices for the receiver's plane and the filter's kernel"},
      {"normal-offset", "along the geometric normal"}}},
    {"bias-scale", "factor on the bias: texels for constant and normal-offset, times the sufficient bias for slope",
     {{"0", ""}, {"0.5", ""}, {"1", ""}, {"2", ""}, {"4", ""}, {"8", ""}}},
    {"filter", "how texels are compared",
     {{"nearest", "one texel"}, {"pcf2", "2×2, bilinear weights"}, {"pcf3", "3×3, bilinear weights"}}},
    {"rotations", "maps per caster type at most: one for each yaw of its instances, else in equal steps about the vertical", {}, 1, 72},
    {"memory", "MiB that instanced maps may take: above, casters out of reach have none, then maps are smaller, then casters go to the far field's maps", {}, 1, 1048576},
    {"own", "instances, those that look largest, with a map of their own rotation, where no shared one has it", {}, 0, 2048},
    {"mode", "how the two maps nearest to an instance's rotation are combined",
     {{"nearest", "the nearer one alone"},
      {"blend", "their binary results, blended"},
      {"depth", "their depths, interpolated before the comparison (Buntin & Stamminger)"},
      {"exact", "a map of its own for every instance, at its own rotation: what the others are held against"}}},
    {"sample-frame", "where a receiver enters a rotated map",
     {{"A", "unrotated: the shadow's direction is exact, the caster's detail is the map's"},
      {"B", "rotated into the map's object frame: the detail is exact, the sun's azimuth is the map's"},
      {"E", "rotated about the point of its ray to the sun that is nearest to the caster"},
      {"EB", "B within the caster's box, E elsewhere"}}},
    {"apply", "how pixels and casters find each other",
     {{"zfail", "back faces of the bounding shadow volumes behind the scene, each pixel tested against its volume"},
      {"zpass", "front faces before the scene; back faces where a volume holds the eye"},
      {"skip", "zfail without the test: outside its volume a map says lit, unless it is of another rotation"},
      {"tiled", "a compute pass bins the volumes to tiles of 16 × 16 pixels, and each pixel asks its tile's casters"},
      {"all", "one pass asks every caster at every pixel: the baseline before bounding volumes"}}},
    {"accumulate", "how several shadows on one pixel add up",
     {{"min", "the darkest"}, {"multiply", "their product (blending that dims)"}, {"stencil", "the first one; a stencil bit stops the rest"}}},
    {"count", "what the shadow volumes about a pixel are counted in",
     {{"stencil", "8 bits that wrap: 256 volumes over one another read as none"},
      {"sum", "32-bit floats, by additive blending: exact to 2^24 volumes"}}},
    {"update", "when maps are rendered",
     {{"cached", "when what they depend on has changed: the sun's elevation, a rotation against its azimuth"},
      {"regenerate", "every frame"},
      {"moving", "as cached, and every frame those of casters whose shape moves"},
      {"criterion", "as moving, but a sun that moves makes a map due only when its object's shadow has moved by a texel"},
      {"round-robin", "those that are behind in turn, budget of them a frame, most-used types first"}}},
    {"budget", "maps that round-robin renders in a frame, beside those that show nothing of use yet", {}, 1, 2048},
    {"resolution", "texels along a side of an instanced map",
     {{"fixed", "size, for every map"},
      {"estimate", "the power of two between 16 and size that the map is asked for, measured on the receivers in sight"}}},
    {"far-field", "which casters are drawn into cascaded maps instead of having volumes; a number: those whose centre is so many metres or more from the eye",
     {{"none", "none"},
      {"auto", "those beyond the distance at which the predicted cost of both together is least"},
      {"each", "near or far, those whose own volume is predicted to cost more than their triangles"}}, 0, 1000000},
    {"far-cost", "for far-field auto and each: what a triangle in the far casters' maps costs, in hundredths of what a pixel that a volume covers costs", {}, 0, 1000000},
    {"exact-casters", "closed opaque casters of at most so many triangles cast stencil shadow volumes, the others instanced maps", {}, 0, 1000000},
};

/// Beside what the technique itself has.
Settings withCamera(Settings settings) {
    settings.merge(Settings{{"camera", "frustum"}, {"cluster", "0"}, {"leaf", "2000"}, {"batch", "50"}, {"assumed-visible", "5"}});
    return settings;
}

Settings mapPreset(const char* fit, const char* split, const char* cascades, const char* size) {
    return withCamera({{"fit", fit}, {"focus", "frustum"}, {"split", split}, {"cascades", cascades}, {"lambda", "0.75"}, {"size", size},
            {"cull", "frustum"}, {"mask", "scatter"}, {"mask-test", "sampled"}, {"bias", "slope"}, {"bias-scale", "1"}, {"filter", "nearest"}});
}

Settings instancedPreset(const char* own) {
    return withCamera({{"size", "512"}, {"memory", "512"}, {"resolution", "fixed"}, {"exact-casters", "0"}, {"far-field", "none"}, {"far-cost", "3200"}, {"rotations", "12"}, {"own", own}, {"mode", "depth"}, {"sample-frame", "EB"}, {"apply", "zpass"}, {"accumulate", "min"},
            {"cull", "receivers"}, {"update", "cached"}, {"budget", "4"}, {"bias", "slope"}, {"bias-scale", "1"}, {"filter", "nearest"}});
}

const std::vector<TechniqueInfo> kTechniques{
    {"bare", "baseline", "every instance drawn in one forward pass, nothing culled, no shadow: the yardstick", {}},
    {"unshadowed", "baseline", "the suite's frame without any shadow pass: what every shadow's cost is added to", withCamera({})},
    {"uniform", "map", "one map over the whole scene (Williams 1978)", mapPreset("scene", "none", "1", "2048"), 3},
    {"focused", "map", "one map over view frustum ∩ scene (Brabec, Annen, Seidel 2002)", mapPreset("frustum", "none", "1", "2048"), 3},
    {"lispsm", "map", "light-space perspective shadow map (Wimmer, Scherzer, Purgathofer 2004)",
     mapPreset("lispsm", "none", "1", "2048"), 3},
    {"cascaded", "map", "parallel-split shadow maps (Zhang et al. 2006)", mapPreset("frustum", "practical", "4", "1024"), 3},
    {"instanced", "instanced", "rotated maps per caster type, applied in bounding shadow volumes (Buntin & Stamminger 2007)", instancedPreset("0"), 6},
    {"instanced-near", "instanced", "the same, and maps of their own for the twelve instances that look largest", instancedPreset("12"), 6},
    {"stencil-volumes", "volume", "shadow volumes of the casters' silhouettes, counted behind the scene (Crow 1977; Everitt & Kilgard 2002)",
     withCamera({{"count", "stencil"}, {"cull", "frustum"}})},
};

template <class Items>
std::vector<std::string> names(const Items& items) {
    std::vector<std::string> result;
    for (const auto& item : items) result.push_back(item.name);
    return result;
}

template <class Items>
const auto& find(const Items& items, const char* kind, const std::string& name) {
    for (const auto& item : items)
        if (item.name == name) return item;
    throw base::UsageError(base::unknownName(kind, name, names(items)));
}

}  // namespace

std::string Axis::canonical(const std::string& value) const {
    const auto fail = [&](const std::string& why) { throw base::UsageError(fmt::format("axis {}: {}", name, why)); };
    if (!values.empty()) {
        for (const Value& known : values)
            if (known.name == value) return value;
        // "0.50" and "1.0" are the numbers 0.5 and 1.
        double number = 0;
        const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
        if (error == std::errc{} && end == value.data() + value.size()) {
            const std::string text = fmt::format("{}", number);
            for (const Value& known : values)
                if (known.name == text) return text;
        }
        if (!takesNumbers()) fail(base::unknownName("value", value, names(values)));
    }
    long number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc{} || end != value.data() + value.size()) fail(fmt::format("'{}' is {} a whole number", value, values.empty() ? "not" : fmt::format("neither {} nor", fmt::join(names(values), ", "))));
    if (number < lo || number > hi) fail(fmt::format("{} is outside {} … {}", number, lo, hi));
    return std::to_string(number);
}

std::span<const TechniqueInfo> techniques() { return kTechniques; }
std::span<const Axis> axes() { return kAxes; }
const TechniqueInfo& technique(const std::string& name) { return find(kTechniques, "technique", name); }
const Axis& axis(const std::string& name) { return find(kAxes, "axis", name); }

Settings resolve(const TechniqueInfo& info, const Settings& overrides) {
    Settings settings = info.defaults;
    for (const auto& [name, value] : overrides) {
        const Axis& known = axis(name);
        if (!settings.contains(name)) {
            std::vector<std::string> own;
            for (const auto& [key, unused] : info.defaults) own.push_back(key);
            throw base::UsageError(fmt::format("technique {} has no axis '{}' (it has: {})", info.name, name,
                                               own.empty() ? "none" : fmt::format("{}", fmt::join(own, ", "))));
        }
        settings[name] = known.canonical(value);
    }
    return settings;
}

std::optional<std::string> pruneReason(const TechniqueInfo& info, const Settings& settings, const scenegen::Facts& facts,
                                       const Limits& limits) {
    const auto is = [&](const char* axisName, const char* value) {
        const auto it = settings.find(axisName);
        return it != settings.end() && it->second == value;
    };
    const auto number = [&](const char* axisName) { return std::stol(settings.at(axisName)); };
    const auto differs = [&](const char* axisName) { return !is(axisName, info.defaults.at(axisName).c_str()); };
    if (info.defaults.contains("camera")) {
        const auto asks = [&](const char* axisName) { return is(axisName, "chc") || is(axisName, "chcpp") || (info.family == "map" && is(axisName, "receivers")); };
        if (differs("leaf") && !asks("camera") && !asks("cull")) return "leaf is of the hierarchy that occlusion queries go through";
        if (differs("cluster") && is("camera", "none") && !(settings.contains("cull") && !is("cull", "none"))) return "clusters are for what is culled";
        const bool coherent = is("camera", "chcpp") || is("cull", "chcpp") || (info.family == "map" && is("cull", "receivers"));
        if ((differs("batch") || differs("assumed-visible")) && !coherent) return "batch and assumed-visible are CHC++'s";
    }
    if (info.family == "baseline") return std::nullopt;
    if (info.family == "volume") {
        if (facts.casters && !facts.closed) return "silhouettes need closed casters; this scene has open ones, as foliage of single leaves is";
        if (facts.alphaTested) return "silhouettes follow triangles, not what an alpha test leaves of them";
        if (!is("cull", "none") && !is("cull", "frustum")) return "silhouettes are culled by frustum";
        return std::nullopt;
    }
    if (number("size") > limits.maxTextureSize)
        return fmt::format("size {} is beyond this GL's limit of {} texels", number("size"), limits.maxTextureSize);
    if (info.family == "map") {
        if (is("cull", "mask")) return "cull mask is for the volumes of instanced maps; a map has receivers and pyramid";
        if (is("cull", "receivers") && is("camera", "hiz")) return "a mask is drawn from the instances in sight, which hierarchical z does not tell the CPU";
        if (!is("cull", "receivers") && (differs("mask") || differs("mask-test"))) return "a mask is for cull receivers";
        if (is("focus", "visible") && is("fit", "scene")) return "fit scene has the window of everything";
        if (is("focus", "visible") && is("camera", "hiz")) return "what hierarchical z finds in sight, the CPU does not know";
        if (is("split", "none") && number("cascades") > 1) return "split none has one map, so cascades must be 1";
        if (is("split", "practical") && number("cascades") == 1) return "a split into 1 is split none";
        if (is("split", "practical") && is("fit", "scene")) return "fit scene gives every cascade the same window";
        if (is("split", "none") && !is("lambda", info.defaults.at("lambda").c_str())) return "split none has no λ";
    }
    if (info.family == "instanced") {
        if (is("mode", "depth") && !is("filter", "nearest"))
            return "interpolated depths have no common texel grid, so mode depth goes with filter nearest";
        if (is("rotations", "1") && !is("mode", "nearest") && !is("mode", "exact")) return "one rotation has no second map to combine: mode nearest";
        if (is("mode", "exact") && !is("rotations", info.defaults.at("rotations").c_str())) return "mode exact has each instance's own rotation";
        if (is("mode", "exact") && !is("sample-frame", info.defaults.at("sample-frame").c_str())) return "mode exact rotates no sample";
        if (is("mode", "exact") && !is("own", info.defaults.at("own").c_str())) return "mode exact gives every instance its own map";
        const bool volumes = !is("apply", "tiled") && !is("apply", "all");
        if (!volumes && !is("accumulate", "min")) return "without volumes nothing is blended: accumulate min";
        if (!volumes && !is("cull", "receivers")) return "without volumes no pixel is asked whose surface faces away from the sun: cull receivers";
        if (is("apply", "skip") && facts.rotated && !is("mode", "exact"))
            return "outside a caster's volume a map of another rotation may darken pixels, so apply skip goes with mode exact or casters that nobody turned";
        if (is("cull", "mask") && !is("accumulate", "min")) return "masked volumes are drawn in no fixed order: accumulate min";
        if (number("exact-casters") > 0 && !volumes) return "exact casters darken an image that volumes go on darkening: apply zpass, zfail or skip";
        if (number("exact-casters") > 0 && is("accumulate", "stencil")) return "exact casters are counted in the stencil: accumulate min or multiply";
        if (!is("far-field", "none") && !volumes) return "volumes go on darkening what the far casters' maps have: apply zpass, zfail or skip";
        if (!is("far-field", "none") && is("accumulate", "stencil")) return "a stencil bit does not know what is dark in the far casters' maps: accumulate min or multiply";
        if (!is("far-field", "none") && facts.translucent) return "the far casters' maps take translucent casters for opaque: far-field none";
        if (!is("far-field", "auto") && !is("far-field", "each") && differs("far-cost")) return "only far-field auto and each predict costs";
        if (is("resolution", "estimate") && (number("size") < 16 || !std::has_single_bit(unsigned(number("size")))))
            return "estimated sides are powers of two from 16 to size: size must be one";
        if (facts.translucent && is("accumulate", "min")) return "the darkest of several shadows is not what translucent casters let through: accumulate multiply";
        if (facts.translucent && is("accumulate", "stencil")) return "a stencil bit stops at the first shadow, but translucent casters' add up: accumulate multiply";
        if (!is("update", "round-robin") && !is("budget", info.defaults.at("budget").c_str())) return "only update round-robin has a budget";
        if (is("update", "moving") && !facts.moving) return "nothing moves in this scene: update cached";
        if (is("cull", "none")) return "cull none draws volumes that cannot darken a pixel: cull receivers";
        if (!is("cull", "frustum") && !is("cull", "receivers") && !is("cull", "mask")) return "that is for one map's window; the volumes of instanced maps have cull receivers and mask";
    }
    return std::nullopt;
}

}  // namespace dapple::shadow
