#include "frame/error_picture.h"

#include "frame/overlays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop

namespace dapple::frame {
namespace {

using Colour = std::array<uint8_t, 3>;
constexpr Colour kFalseShadow{230, 30, 30}, kFalseLight{40, 110, 255}, kAmbiguous{255, 0, 255}, kInk{40, 40, 40};
constexpr int kGap = 8;           ///< pixels between the two pictures, and round the legend
constexpr int kLineOfFont = 12;   ///< pixels a line of stb_easy_font at its own size

struct Entry {
    Colour colour;
    std::string text;
};

enum class Kind { right, falseShadow, falseLight, ambiguous };

Kind kindOf(const truth::Reference& reference, std::span<const float> visibility, size_t i) {
    const bool dark = visibility[i] < 0.5f;
    if (reference.label[i] == truth::Label::lit && dark) return Kind::falseShadow;
    if (reference.label[i] == truth::Label::shadowed && !dark) return Kind::falseLight;
    return reference.label[i] == truth::Label::ambiguous ? Kind::ambiguous : Kind::right;
}

void fillRect(base::Image8& image, int x0, int y0, int x1, int y1, const Colour& colour) {
    for (int y = std::max(y0, 0); y < std::min(y1, image.height); ++y)
        for (int x = std::max(x0, 0); x < std::min(x1, image.width); ++x) std::copy(colour.begin(), colour.end(), image.at(x, y));
}

/// ASCII.
int widthOf(std::string text, int scale) { return scale * stb_easy_font_width(text.data()); }

void drawText(base::Image8& image, int x, int y, std::string text, int scale) {
    struct Vertex {
        float x, y, z;
        unsigned char colour[4];
    };
    std::vector<Vertex> corners(text.size() * 4 * 80);  // glyphs have fewer strokes
    const int quads = stb_easy_font_print(0, 0, text.data(), nullptr, corners.data(), int(corners.size() * sizeof(Vertex)));
    for (size_t q = 0; q < size_t(quads); ++q) {
        const Vertex &a = corners[4 * q], &c = corners[4 * q + 2];
        fillRect(image, x + scale * int(a.x), y + scale * int(a.y), x + scale * int(c.x), y + scale * int(c.y), kInk);
    }
}

/// Legend entries from left to right, on as many lines as they take. Draws only where there is an image; returns the height.
int flow(base::Image8* image, const std::vector<Entry>& entries, int width, int top, int scale) {
    int x = kGap, y = top;
    for (const Entry& entry : entries) {
        const int swatch = kLineOfFont * scale, takes = swatch + kGap + widthOf(entry.text, scale) + 2 * kGap;
        if (x > kGap && x + takes > width) x = kGap, y += kLineOfFont * scale + kGap / 2;
        if (image) {
            fillRect(*image, x, y, x + swatch - 2 * scale, y + swatch - 2 * scale, kInk);
            fillRect(*image, x + 1, y + 1, x + swatch - 2 * scale - 1, y + swatch - 2 * scale - 1, entry.colour);
            drawText(*image, x + swatch + kGap / 2, y + scale, entry.text, scale);
        }
        x += takes;
    }
    return y + kLineOfFont * scale + kGap - top;
}

base::Image8 paintDots(const base::Image8& shaded, const truth::Reference& reference, std::span<const float> visibility) {
    base::Image8 image{shaded.width, shaded.height, 3, std::vector<uint8_t>(shaded.texels.size())};
    for (size_t i = 0; i < shaded.texels.size() / 3; ++i) {
        const uint8_t* s = &shaded.texels[3 * i];
        const double light = (0.3 * s[0] + 0.6 * s[1] + 0.1 * s[2]) / 255;
        std::fill_n(&image.texels[3 * i], 3, uint8_t(255 * (0.72 + 0.24 * light)));
    }
    // Ambiguous ones first, so that no error hides under them.
    for (const auto& [kind, colour] : {std::pair{Kind::ambiguous, kAmbiguous}, {Kind::falseLight, kFalseLight}, {Kind::falseShadow, kFalseShadow}})
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                if (kindOf(reference, visibility, size_t(y) * size_t(image.width) + size_t(x)) == kind) fillRect(image, x, y, x + 2, y + 2, colour);
    return image;
}

}  // namespace

base::Image8 paintErrorSheet(const base::Image8& shaded, const truth::Reference& reference, std::span<const float> visibility) {
    std::array<size_t, 4> counts{};
    size_t valid = 0;
    for (size_t i = 0; i < reference.label.size(); ++i) {
        if (reference.label[i] == truth::Label::excluded) continue;
        const Kind kind = kindOf(reference, visibility, i);
        ++counts[size_t(kind)];
        valid += kind != Kind::ambiguous;
    }
    const auto share = [&](Kind kind, size_t of) { return of == 0 ? 0.0 : 100 * double(counts[size_t(kind)]) / double(of); };
    const std::vector<Entry> entries{
        {kFalseShadow, fmt::format("false shadow {:.2f} %", share(Kind::falseShadow, valid))},
        {kFalseLight, fmt::format("false light {:.2f} %", share(Kind::falseLight, valid))},
        {kAmbiguous, fmt::format("ambiguous, not counted {:.2f} %", share(Kind::ambiguous, valid + counts[size_t(Kind::ambiguous)]))},
        {{255, 255, 255}, "right: ray-traced truth, lit"}, {{0, 0, 0}, "in shadow"}, {{74, 85, 104}, "faces away from the sun, or sky"}};

    const int width = 2 * shaded.width + kGap, scale = width >= 1000 ? 2 : 1;
    const int legend = flow(nullptr, entries, width, 0, scale);
    base::Image8 sheet{width, shaded.height + kGap + legend, 3, {}};
    sheet.texels.assign(size_t(sheet.width) * size_t(sheet.height) * 3, 255);
    int x = 0;
    for (const base::Image8& picture : {paintDots(shaded, reference, visibility), paintReference(reference)}) {
        for (int y = 0; y < picture.height; ++y) std::copy_n(picture.at(0, y), size_t(picture.width) * 3, sheet.at(x, y));
        x += picture.width + kGap;
    }
    flow(&sheet, entries, width, shaded.height + kGap, scale);
    return sheet;
}

}  // namespace dapple::frame
