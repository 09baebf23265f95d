#include "scenegen/city/arcade.h"

#include "base/detmath.h"
#include "scenegen/city/assembly.h"
#include "scenegen/city/curved.h"
#include "scenegen/city/solid.h"

#include <array>
#include <vector>

namespace dapple::scenegen::city {
namespace {

constexpr double kHalf = 0.5 * kArcadeBay;
constexpr double kSpringing = 2.95, kUpperSpringing = 7.55;
constexpr ArchPanel kLowerArch{kArcadeBay, 1.62, kSpringing, 5.09, 0.5}, kUpperArch{kHalf - 0.002, 0.74, kUpperSpringing, 9.04, 0.36};
constexpr int kTileColumns = 13, kTileRows = 10;

/// Point k of n on a quarter circle from (1, 0) to (0, 1).
glm::dvec2 quarter(int k, int n) {
    const base::det::SinCos t = base::det::sinCos(0.5 * base::det::kPi * k / n);
    return {t.cos, t.sin};
}

/// A rounded moulding that stands out of `radius`, from height z to z + 2 · size.
void addTorus(std::vector<glm::dvec2>& profile, double radius, double z, double size) {
    constexpr int n = 3;
    for (int k = n; k >= 0; --k) profile.emplace_back(radius + size * quarter(k, n).x, z + size * (1 - quarter(k, n).y));
    for (int k = 1; k <= n; ++k) profile.emplace_back(radius + size * quarter(k, n).x, z + size * (1 + quarter(k, n).y));
}

/// Attic base, a shaft that swells a little, a bell-shaped capital and its plate.
Mesh column(double foot, double top, double radius, int sides) {
    Mesh m;
    const double plinth = 0.5 * radius, plate = 0.45 * radius, r = radius;
    addBox(m, {-1.42 * r, -1.42 * r, foot - 0.05}, {1.42 * r, 1.42 * r, foot + plinth});
    std::vector<glm::dvec2> profile;
    double z = foot + plinth - 0.005;
    addTorus(profile, 1.16 * r, z, 0.2 * r);
    profile.emplace_back(1.1 * r, z + 0.46 * r), profile.emplace_back(1.08 * r, z + 0.6 * r);
    addTorus(profile, 1.06 * r, z + 0.62 * r, 0.11 * r);
    z += 0.9 * r;
    const double shaft = top - plate - 1.35 * r - z;
    for (int k = 0; k <= 4; ++k) {
        const double t = k / 4.0;
        profile.emplace_back(r * (1 + 0.06 * t - 0.18 * t * t), z + t * shaft);
    }
    z += shaft;
    addTorus(profile, 0.9 * r, z + 0.03 * r, 0.07 * r);
    for (int k = 0; k <= 4; ++k) profile.emplace_back(r * (0.9 + 0.5 * (1 - quarter(k, 4).x)), z + r * (0.2 + 1.0 * quarter(k, 4).y));
    profile.emplace_back(1.4 * r, z + 1.36 * r);
    addLathe(m, glm::dvec3(0), profile, sides);
    addFrustum(m, {-1.35 * r, -1.35 * r, 1.35 * r, 1.35 * r}, top - plate - 0.02, {-1.55 * r, -1.55 * r, 1.55 * r, 1.55 * r}, top - 0.4 * plate);
    addBox(m, {-1.5 * r, -1.5 * r, top - 0.42 * plate}, {1.5 * r, 1.5 * r, top + 0.02});
    return m;
}

/// The panel with rings about its arch on both sides, and a keystone.
Mesh arch(const ArchPanel& p, int segments, double ring) {
    Mesh m;
    addArchPanel(m, p, segments);
    const double out = 0.5 * p.thickness;
    addArchRing(m, p.springing + 0.003, p.radius - 0.02, p.radius + ring, -out - 0.05, out + 0.05, segments);
    addArchRing(m, p.springing + 0.006, p.radius + 0.75 * ring, p.radius + 1.15 * ring, -out - 0.09, out + 0.09, segments);
    const double crown = p.springing + p.radius;
    for (const double side : {-1.0, 1.0}) {
        const double y0 = side * (out - 0.05), y1 = side * (out + 0.14), a = std::min(y0, y1), b = std::max(y0, y1);
        addFrustum(m, {-0.35 * ring, a, 0.35 * ring, b}, crown - 0.05, {-0.55 * ring, a, 0.55 * ring, b}, crown + 1.35 * ring);
    }
    return m;
}

/// One barrel tile: a half disc that tapers from `low` (its lower, wider end) to `high`.
void addTile(Mesh& mesh, const glm::dvec3& low, const glm::dvec3& high) {
    constexpr int n = 4;
    std::array<glm::dvec3, n + 1> a, b;
    for (int k = 0; k <= n; ++k) {
        const base::det::SinCos t = base::det::sinCos(base::det::kPi * (1 - double(k) / n));
        a[size_t(k)] = low + glm::dvec3(0.125 * t.cos, 0, 0.105 * t.sin);
        b[size_t(k)] = high + glm::dvec3(0.1 * t.cos, 0, 0.085 * t.sin);
    }
    addLoft(mesh, a, b);
}

double deck(double y) { return kEaves + kPitch * (y + kOverhang); }

/// Row j of the column of tiles at x.
void addTile(Mesh& mesh, double x, int row) {
    const double step = (kRidge + kOverhang) / kTileRows, y0 = -kOverhang - 0.08 + row * step, y1 = y0 + step + 0.05;
    addTile(mesh, {x, y0, deck(y0) + 0.012 - 0.001 * (row % 2)}, {x, y1, deck(y1) - 0.03});
}

}  // namespace

Mesh lowerColumn() { return column(kArcadeFloor, kSpringing, 0.27, 20); }
Mesh upperColumn() { return column(kGalleryFloor + 0.3, kUpperSpringing, 0.125, 12); }
Mesh lowerArch() {
    Mesh m = arch(kLowerArch, 28, 0.26);
    // Roundels over the columns, half of each bay's pair beyond its end: whole ones at one end alone.
    addCone(m, {-kHalf, -0.2, 4.2}, 0.3, {-kHalf, -0.32, 4.2}, 0.27, 24);
    addCone(m, {-kHalf, -0.3, 4.2}, 0.2, {-kHalf, -0.37, 4.2}, 0.08, 24);
    return m;
}

Mesh transverseArch() {
    Mesh m;
    ArchPanel p = kLowerArch;
    p.thickness = 0.38, p.top = kGalleryFloor - 0.2;
    addArchPanel(m, p, 28);
    return m;
}

Mesh upperArches() {
    const Mesh one = arch(kUpperArch, 20, 0.14);
    Mesh m;
    for (const double x : {-0.5 * kHalf, 0.5 * kHalf}) {
        Mesh moved = one;
        for (glm::vec3& p : moved.positions) p.x += float(x);
        append(m, moved);
    }
    // Brackets under the eaves.
    for (int i = 0; i < 5; ++i) {
        const double x = -kHalf + 0.4 + 0.8 * i;
        addFrustum(m, {x - 0.07, -0.35, x + 0.07, 0.1}, 8.62, {x - 0.07, -0.72, x + 0.07, 0.1}, 8.86);
    }
    return m;
}

Mesh balustrade() {
    Mesh m;
    addBox(m, {-kHalf, -0.17, kGalleryFloor - 0.05}, {kHalf, 0.17, kGalleryFloor + 0.3});
    for (const double x : {-0.5 * kHalf, 0.5 * kHalf}) {
        const double a = x - 0.5 * kHalf + 0.2, b = x + 0.5 * kHalf - 0.2;
        addFrustum(m, {a - 0.1, -0.13, b + 0.1, 0.13}, kGalleryFloor + 0.93, {a - 0.1, -0.16, b + 0.1, 0.16}, kGalleryFloor + 1.0);
        addBox(m, {a - 0.09, -0.15, kGalleryFloor + 0.99}, {b + 0.09, 0.15, kGalleryFloor + 1.05});
        for (int i = 0; i < 5; ++i) {
            const double r = 0.06, z = kGalleryFloor + 0.29;
            const glm::dvec2 profile[] = {{1.0 * r, z}, {0.95 * r, z + 0.05}, {0.6 * r, z + 0.08}, {1.15 * r, z + 0.21}, {1.05 * r, z + 0.32}, {0.55 * r, z + 0.5}, {0.6 * r, z + 0.56}, {1.0 * r, z + 0.66}};
            addLathe(m, {a + (b - a) * (i + 0.5) / 5, 0, 0}, profile, 10);
        }
    }
    return m;
}

Mesh roofTiles() {
    Mesh m;
    for (int i = 0; i < kTileColumns; ++i)
        for (int row = 0; row < kTileRows; ++row) addTile(m, kArcadeBay * ((i + 0.5) / kTileColumns - 0.5), row);
    return m;
}

Mesh cornerTiles(bool mirrored) {
    Mesh m;
    const double pitch = kArcadeBay / kTileColumns, step = (kRidge + kOverhang) / kTileRows;
    for (double x = 0.5 * pitch; x < kRidge; x += pitch)
        for (int row = 0; row < kTileRows; ++row)
            if (-kOverhang + (row + 0.5) * step > x + 0.05) addTile(m, mirrored ? -x : x, row);
    return m;
}

Mesh pot() {
    Mesh m;
    const glm::dvec2 profile[] = {{0.2, 0}, {0.22, 0.05}, {0.19, 0.09}, {0.27, 0.2}, {0.33, 0.36}, {0.35, 0.46}, {0.4, 0.47}, {0.41, 0.51}, {0.4, 0.55}};
    addLathe(m, glm::dvec3(0), profile, 20);
    return m;
}

Mesh planter() {
    Mesh m;
    addFrustum(m, {-0.8, -0.8, 0.8, 0.8}, -0.05, {-0.77, -0.77, 0.77, 0.77}, 0.12);
    addRing(m, glm::dvec2(-0.72), glm::dvec2(0.72), 0.16, 0.08, 0.47);
    addRing(m, glm::dvec2(-0.76), glm::dvec2(0.76), 0.24, 0.46, 0.56);
    return m;
}

Mesh earthOf(double halfSide, double height) {
    Mesh m;
    addBox(m, {-halfSide, -halfSide, height - 0.08}, {halfSide, halfSide, height});
    return m;
}

Fountain fountain() {
    Fountain f;
    Mesh& m = f.stone;
    const glm::dvec2 step[] = {{2.15, -0.05}, {2.15, 0.12}, {2.12, 0.15}}, floor[] = {{1.72, 0.1}, {1.72, 0.2}};
    addLathe(m, glm::dvec3(0), step, 48);
    addLathe(m, glm::dvec3(0), floor, 48);
    // The basin's rim, of stones with curved sides.
    constexpr int n = 48;
    const auto onCircle = [](int k, double r, double z) {
        const base::det::SinCos t = base::det::sinCos(2 * base::det::kPi * k / n);
        return glm::dvec3(r * t.cos, r * t.sin, z);
    };
    struct Corner {
        double radius, height;
    };
    constexpr Corner rim[] = {{1.5, 0.17}, {1.72, 0.17}, {1.66, 0.4}, {1.8, 0.55}, {1.78, 0.62}, {1.46, 0.62}};
    for (int k = 0; k < n; ++k)
        for (size_t i = 0; i < std::size(rim); ++i) {
            const Corner a = rim[i], b = rim[(i + 1) % std::size(rim)];
            addFace(m, {onCircle(k, a.radius, a.height), onCircle(k + 1 == n ? 0 : k + 1, a.radius, a.height), onCircle(k + 1 == n ? 0 : k + 1, b.radius, b.height), onCircle(k, b.radius, b.height)});
        }
    const glm::dvec2 stem[] = {{0.42, 0.15}, {0.42, 0.3}, {0.3, 0.36}, {0.2, 0.5}, {0.24, 0.75}, {0.2, 1.0}, {0.16, 1.12}, {0.24, 1.18}, {0.6, 1.3}, {0.88, 1.46}, {0.92, 1.52}, {0.9, 1.56}};
    addLathe(m, glm::dvec3(0), stem, 32);
    const glm::dvec2 upper[] = {{0.15, 1.5}, {0.12, 1.62}, {0.14, 1.75}, {0.1, 1.9}, {0.2, 1.97}, {0.4, 2.08}, {0.43, 2.14}, {0.42, 2.16}};
    addLathe(m, glm::dvec3(0), upper, 24);
    const glm::dvec2 bud[] = {{0.08, 2.1}, {0.06, 2.22}, {0.1, 2.3}, {0.1, 2.36}, {0.06, 2.44}, {0.01, 2.5}};
    addLathe(m, glm::dvec3(0), bud, 16);
    const glm::dvec2 pool[] = {{1.6, 0.19}, {1.6, 0.5}}, bowl[] = {{0.8, 1.5}, {0.8, 1.575}};
    addLathe(f.water, glm::dvec3(0), pool, 48);
    addLathe(f.water, glm::dvec3(0), bowl, 32);
    return f;
}

Mesh banner() {
    Mesh m;
    addSheet(m, 20, 16, 0.014, [](double u, double v) {
        const double x = 1.5 * (u - 0.5), down = 1 - v;
        const base::det::SinCos t = base::det::sinCos(2 * base::det::kPi * (2.5 * u + 0.15 * down));
        return glm::dvec3(x * (1 - 0.06 * down), -0.72 - 0.05 * down * t.sin - 0.04 * down * down, 4.98 - 2.0 * down - 0.25 * down * (1 - 4 * (u - 0.5) * (u - 0.5)));
    });
    return m;
}

Mesh curtain() {
    Mesh m;
    addSheet(m, 44, 14, 0.014, [](double u, double v) {
        // Gathered where a band holds it, wide again at the foot.
        const double down = 1 - v, held = 1 / (1 + 30 * (down - 0.62) * (down - 0.62));
        const double width = 1.25 - 0.65 * held;
        const base::det::SinCos t = base::det::sinCos(2 * base::det::kPi * (4 * u + 0.2 * down));
        return glm::dvec3(-1.52 + width * u, -0.02 + 0.08 * width * t.sin, 2.86 - 2.6 * down);
    });
    return m;
}

Mesh curtainRod() {
    Mesh m;
    addCone(m, {-kHalf + 0.1, 0, 2.88}, 0.022, {kHalf - 0.1, 0, 2.88}, 0.022, 8);
    return m;
}

}  // namespace dapple::scenegen::city
