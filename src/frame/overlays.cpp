#include "frame/overlays.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::frame {
namespace {

using Colour = std::array<uint8_t, 3>;

template <class F>
base::Image8 paint(int width, int height, const F& colourOf) {
    base::Image8 image{width, height, 3, std::vector<uint8_t>(size_t(width) * size_t(height) * 3)};
    for (size_t i = 0; i < size_t(width) * size_t(height); ++i) {
        const Colour c = colourOf(i);
        std::copy(c.begin(), c.end(), &image.texels[i * 3]);
    }
    return image;
}

uint8_t byte(double v) { return uint8_t(std::lround(std::clamp(v, 0.0, 1.0) * 255)); }
Colour grey(double v) { return {byte(v), byte(v), byte(v)}; }

/// Piecewise linear through five colours of increasing lightness, readable without colour vision.
Colour heat(double t) {
    constexpr std::array<std::array<double, 3>, 5> kStops{{{0, 0, 0.02}, {0.34, 0.06, 0.43}, {0.74, 0.21, 0.33}, {0.98, 0.55, 0.04}, {0.99, 1, 0.64}}};
    const double x = std::clamp(t, 0.0, 1.0) * 4;
    const size_t i = std::min(size_t(x), size_t(3));
    Colour c{};
    for (size_t k = 0; k < 3; ++k) c[k] = byte(kStops[i][k] + (kStops[i + 1][k] - kStops[i][k]) * (x - double(i)));
    return c;
}

constexpr Colour kAmbiguous{255, 0, 255}, kExcluded{74, 85, 104};
constexpr std::array<double, 3> kCandidateLit{0.5, 1, 0.45}, kCandidateDark{0.8, 0.05, 0.05};

/// Lightness of a pixel of a picture, 0 … 1.
double lightness(const uint8_t* s) { return (0.3 * s[0] + 0.6 * s[1] + 0.1 * s[2]) / 255; }

}  // namespace

base::Image8 paintVisibility(std::span<const float> visibility, int width, int height) {
    return paint(width, height, [&](size_t i) { return grey(double(visibility[i])); });
}

base::Image8 paintReference(const truth::Reference& reference) {
    return paint(reference.width, reference.height, [&](size_t i) -> Colour {
        switch (reference.label[i]) {
            case truth::Label::lit:
            case truth::Label::shadowed: return grey(reference.value(i));
            case truth::Label::ambiguous: return kAmbiguous;
            default: return kExcluded;
        }
    });
}

base::Image8 paintOverdraw(const base::ImageF& counts) {
    return paint(counts.width, counts.height, [&](size_t i) { return heat(std::log2(1 + double(counts.texels[i])) / std::log2(33.0)); });
}

base::Image8 paintCandidates(const base::Image8& shaded, const base::ImageF& volumes, std::span<const float> visibility) {
    return paint(shaded.width, shaded.height, [&](size_t i) -> Colour {
        const double light = lightness(&shaded.texels[i * 3]);
        if (volumes.texels[i] < 0.5f) return grey(0.12 + 0.38 * std::sqrt(light));
        const auto& c = visibility[i] < 1 ? kCandidateDark : kCandidateLit;
        const double strength = 0.4 + 0.6 * std::sqrt(light);  // the structure of the picture stays visible
        return {byte(c[0] * strength), byte(c[1] * strength), byte(c[2] * strength)};
    });
}

base::Image8 paintNormals(const base::ImageF& normals) {
    return paint(normals.width, normals.height, [&](size_t i) -> Colour {
        const float* n = &normals.texels[3 * i];
        if (n[0] == 0 && n[1] == 0 && n[2] == 0) return {0, 0, 0};
        return {byte(0.5 + 0.5 * n[0]), byte(0.5 + 0.5 * n[1]), byte(0.5 + 0.5 * n[2])};
    });
}

base::Image8 paintDepth(const base::ImageF& depth, const Camera& camera) {
    double lo = camera.far, hi = camera.near;
    for (const float d : depth.texels)
        if (d > 0) {
            lo = std::min(lo, camera.eyeDepth(double(d)));
            hi = std::max(hi, camera.eyeDepth(double(d)));
        }
    const double range = std::max(std::log(hi / lo), 1e-9);
    return paint(depth.width, depth.height, [&](size_t i) {
        const double d = double(depth.texels[i]);
        return d == 0 ? grey(0) : grey(1 - 0.85 * std::log(camera.eyeDepth(d) / lo) / range);
    });
}

namespace {

/// Square images of `width` side by side in a grid, at most 2048 pixels across; `colourOf` gets the image, and a pixel's column and row in it.
template <class F>
base::Image8 paintSheet(size_t count, int width, const F& colourOf) {
    const int columns = int(std::ceil(std::sqrt(double(count))));
    const int rows = (int(count) + columns - 1) / columns;
    const int step = std::max(1, width * columns / 2048), cell = width / step;
    base::Image8 sheet{cell * columns, cell * rows, 3, std::vector<uint8_t>(size_t(cell * columns) * size_t(cell * rows) * 3)};
    for (size_t n = 0; n < count; ++n)
        for (int y = 0; y < cell; ++y)
            for (int x = 0; x < cell; ++x) {
                const Colour c = colourOf(n, x * step, y * step);
                std::copy(c.begin(), c.end(), sheet.at(int(n) % columns * cell + x, int(n) / columns * cell + y));
            }
    return sheet;
}

constexpr Colour kNothing{16, 24, 48};
Colour mapColour(float depth) { return depth >= 1 ? kNothing : grey(1 - 0.8 * double(depth)); }
Colour times(const Colour& c, double strength) { return {byte(c[0] / 255.0 * strength), byte(c[1] / 255.0 * strength), byte(c[2] / 255.0 * strength)}; }

}  // namespace

base::Image8 paintMap(std::span<const base::ImageF> layers) {
    return paintSheet(layers.size(), layers[0].width, [&](size_t n, int x, int y) { return mapColour(layers[n].texels[size_t(y) * size_t(layers[n].width) + size_t(x)]); });
}

base::Image8 paintMasks(std::span<const base::ImageF> maps, std::span<const base::ImageF> masks) {
    return paintSheet(maps.size(), maps[0].width, [&](size_t n, int x, int y) -> Colour {
        const base::ImageF &map = maps[n], &mask = masks[n];
        const Colour c = mapColour(map.texels[size_t(y) * size_t(map.width) + size_t(x)]);
        const bool set = mask.texels[size_t(y * mask.height / map.height) * size_t(mask.width) + size_t(x * mask.width / map.width)] > 0.5f;
        if (!set) return times(c, 0.8);
        return {uint8_t(128 + c[0] / 2), uint8_t(110 + c[1] / 2), uint8_t(c[2] / 3)};
    });
}

base::Image8 paintLightViews(std::span<const LightView> views) {
    return paintSheet(views.size(), views[0].depth.width, [&](size_t n, int x, int y) -> Colour {
        const size_t i = size_t(y) * size_t(views[n].depth.width) + size_t(x);
        const double light = 1 - 0.65 * double(views[n].depth.texels[i]);
        switch (views[n].classes[i]) {
            case LightViewClass::receiver: return {250, 236, 150};
            case LightViewClass::leftOut: return grey(0.55 * light);
            case LightViewClass::drawn: return times({255, 140, 30}, light);
            case LightViewClass::contributing: return times({60, 150, 255}, light);
            default: return kNothing;
        }
    });
}

}  // namespace dapple::frame
