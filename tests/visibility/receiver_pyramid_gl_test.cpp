// Boxes, and meshes made of them, against a pyramid of receivers, and against all lines of sight to pixel centres, one by one in double.
#include "visibility/receiver_pyramid.h"

#include "base/random.h"
#include "gl/context.h"
#include "gpuscene/gpu_scene.h"
#include "scenegen/primitives.h"
#include "visibility/views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>

namespace dapple::visibility {
namespace {

scenegen::Mesh boxAt(const glm::vec3& at, const glm::vec3& size) {
    scenegen::Mesh mesh = scenegen::boxMesh(size);
    for (glm::vec3& p : mesh.positions) p += at;
    return mesh;
}

/// Specks, needles, flat sheets, crates, towers, blocks, gates, and walls about a court, turned and scaled, strewn about the origin.
/// Every mesh is a box.
scenegen::Scene boxes() {
    scenegen::Scene scene;
    scene.materials.resize(1);
    for (const glm::vec3& size : {glm::vec3(0.02f), glm::vec3(9, 0.03f, 0.03f), glm::vec3(0.03f, 0.03f, 7), glm::vec3(5, 4, 0), glm::vec3(0, 3, 6), glm::vec3(1.5f), glm::vec3(2, 3, 15), glm::vec3(6, 5, 12)})
        scene.prototypes.push_back({"box", {scenegen::boxMesh(size)}, true, false});
    scene.prototypes.push_back({"gate", {boxAt({-4, 0, 0}, {0.5f, 0.5f, 8}), boxAt({4, 0, 0}, {0.5f, 0.5f, 8}), boxAt({0, 0, 8}, {9, 0.5f, 0.5f})}, true, false});
    scene.prototypes.push_back({"court", {boxAt({-7, 0, 0}, {1, 15, 5}), boxAt({7, 0, 0}, {1, 15, 7}), boxAt({0, 7, 0}, {13, 1, 5}), boxAt({0, 0, 0}, {0.2f, 0.2f, 16})}, true, false});
    base::Random random(3, 0, 0);
    for (uint32_t i = 0; i < 3000; ++i)
        scene.instances.push_back({{random.next(-40, 40), random.next(-40, 40), random.next(-15, 30)}, random.next(0.3f, 1.2f), i % 3 ? random.next(0, 6.28f) : 0, i % 10});
    scene.views.emplace_back();
    return scene;
}

/// A map, and by pixel the farthest reference depth of the look-ups that read it first, and `beyond` pixels after it; −1: none.
struct Receivers {
    int size, beyond;
    std::vector<float> depth;

    Receivers(int pixels, int after, base::Random& random) : size(pixels), beyond(after), depth(size_t(pixels) * size_t(pixels), -1) {
        const float waves[] = {random.next(1, 9), random.next(1, 9), random.next(0, 6)};
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) {
                const float u = float(x) / float(size), v = float(y) / float(size), height = 0.5f + 0.4f * std::sin(waves[0] * u + waves[2]) * std::cos(waves[1] * v);
                const bool patch = std::sin(40 * u + waves[2]) * std::sin(31 * v) > 0.8f;
                if (patch || random.next() < 0.002f) depth[size_t(y) * size_t(size) + size_t(x)] = std::clamp(height + (random.next() < 0.1f ? random.next(-0.3f, 0.3f) : 0), 0.0f, 1.0f);
            }
    }
    float at(int x, int y) const { return depth[size_t(y) * size_t(size) + size_t(x)]; }
    /// The largest of what `valueAt` is at the pixels whose look-ups read this one.
    template <class ValueAt>
    float read(int x, int y, const ValueAt& valueAt) const {
        float most = -1;
        for (int firstY = std::max(0, y - beyond); firstY <= y; ++firstY)
            for (int firstX = std::max(0, x - beyond); firstX <= x; ++firstX) most = std::max(most, valueAt(firstX, firstY));
        return most;
    }

    /// The largest of each cell's pixels, one on a border in both.
    std::vector<float> cells(int side) const {
        std::vector<float> most(size_t(side) * size_t(side), -1);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x)
                for (const double dy : {-1e-3, 1e-3})
                    for (const double dx : {-1e-3, 1e-3}) {
                        float& value = most[cellOf(y, side, dy) * size_t(side) + cellOf(x, side, dx)];
                        value = std::max(value, at(x, y));
                    }
        return most;
    }
    size_t cellOf(int pixel, int side, double moved = 0) const { return std::min(size_t((pixel + 0.5) * side / size + moved), size_t(side) - 1); }
};

/// An item of the scene, seen by the sun.
struct Seen {
    static constexpr double kLeastW = 0.05;
    glm::dmat4 clip, relative;
    glm::dvec3 position;            ///< metres relative to the eye
    std::vector<base::DBox> known;  ///< of the meshes that lie in front as a whole; prototype space times scale
    base::DBox image;               ///< theirs, after the division by w
    bool unknown = false;           ///< the sun might see a triangle of the others: nothing more is known of it
    double cosYaw, sinYaw;

    Seen(const CullView& view, const gpuscene::Items& items, uint32_t item) : clip(view.clipFromRelative), relative(glm::inverse(clip)) {
        const scenegen::Instance& i = items.instance(item);
        position = glm::dvec3(i.translation) - view.eye;
        cosYaw = std::cos(double(i.yaw));
        sinYaw = std::sin(double(i.yaw));
        for (const scenegen::Mesh& mesh : items.scene().prototypes[i.prototype].meshes) {
            std::vector<glm::dvec3> corners;
            base::DBox box;
            for (const glm::vec3& p : mesh.positions) box.extend(glm::dvec3(p) * double(i.scale));
            for (int c = 0; c < 8; ++c) corners.push_back(point(box.corner(c)));
            if (std::ranges::all_of(corners, [&](const glm::dvec3& p) { return (clip * glm::dvec4(p, 1)).w > kLeastW; })) {
                known.push_back(box);
                for (const glm::dvec3& p : corners) {
                    const glm::dvec4 q = clip * glm::dvec4(p, 1);
                    image.extend(glm::dvec3(q) / q.w);
                }
                continue;
            }
            for (size_t t = 0; t < mesh.indices.size(); t += 3) {
                std::array<glm::dvec3, 3> triangle;
                base::DBox about;
                for (size_t c = 0; c < 3; ++c) about.extend(triangle[c] = point(glm::dvec3(mesh.positions[mesh.indices[t + c]]) * double(i.scale)));
                const bool before = std::ranges::all_of(triangle, [&](const glm::dvec3& p) { return (clip * glm::dvec4(p, 1)).w > kLeastW; });
                unknown = unknown || (!before && view.mayContain(about) && !beyondASide(triangle));
            }
        }
    }
    glm::dvec3 point(const glm::dvec3& p) const { return position + glm::dvec3(cosYaw * p.x - sinYaw * p.y, sinYaw * p.x + cosYaw * p.y, p.z); }
    glm::dvec3 local(const glm::dvec3& v) const { return {cosYaw * v.x + sinYaw * v.y, cosYaw * v.y - sinYaw * v.x, v.z}; }
    bool beyondASide(const std::array<glm::dvec3, 3>& triangle) const {
        for (int side = 0; side < 4; ++side)
            if (std::ranges::all_of(triangle, [&](const glm::dvec3& p) {
                    const glm::dvec4 q = clip * glm::dvec4(p, 1);
                    return (side % 2 ? 1 : -1) * q[side / 2] > q.w;
                }))
                return true;
        return false;
    }
    /// Depth at which the sun's line through a place of the map (ndc) first enters a known mesh, 0 before the map's near plane; 2:
    /// it enters none. They are `grown` on all sides (metres).
    double entry(const glm::dvec2& place, double grown = 0) const {
        glm::dvec3 ends[2];
        for (int k = 0; k < 2; ++k) {
            const glm::dvec4 q = relative * glm::dvec4(place, k, 1);
            ends[k] = local(glm::dvec3(q) / q.w - position);
        }
        double first = 2;
        for (const base::DBox& box : known) first = std::min(first, entry(box, ends[0], ends[1] - ends[0], grown));
        return first;
    }
    static double entry(const base::DBox& box, const glm::dvec3& from, const glm::dvec3& along, double grown) {
        double in = -1e300, out = 1e300;
        for (int k = 0; k < 3; ++k) {
            if (along[k] == 0 && (from[k] < box.lo[k] - grown || from[k] > box.hi[k] + grown)) return 2;
            if (along[k] == 0) continue;
            const double a = (box.lo[k] - grown - from[k]) / along[k], b = (box.hi[k] + grown - from[k]) / along[k];
            in = std::max(in, std::min(a, b));
            out = std::min(out, std::max(a, b));
        }
        return in > out ? 2 : std::max(in, 0.0);  // the views' w does not change along the light: depth is the share of the way
    }
};

struct Outcome {
    size_t kept = 0, needed = 0, lost = 0, loose = 0;
};

/// Needed is an item which the line through some pixel's centre enters no later than the pixel's receivers lie. Loose is one that
/// is kept although, a quarter of a pixel larger, it would not be needed by the cells' values either.
Outcome compare(const gpuscene::Items& items, const CullView& view, const Receivers& receivers, double metresPerPixel) {
    ReceiverPyramid pyramid(receivers.size, 2, receivers.beyond);
    pyramid.clear();
    const int side = pyramid.cells();
    const std::vector<float> cells = receivers.cells(side);
    const auto stamp = GLuint(pyramid.stamp()) << ReceiverPyramid::kDepthBits;
    std::vector<GLuint> keys(cells.size());
    for (size_t i = 0; i < keys.size(); ++i) keys[i] = cells[i] < 0 ? stamp - 1 : stamp | GLuint(std::ceil(cells[i] * ((1 << ReceiverPyramid::kDepthBits) - 1)));  // −1: the last frame's farthest
    for (int level = 0; level < pyramid.markedLevels(); ++level) {
        const int n = side >> level;
        if (level > 0) {
            std::vector<GLuint> coarser(size_t(n) * size_t(n), 0);
            for (size_t i = 0; i < keys.size(); ++i) {
                GLuint& key = coarser[i / (2 * size_t(n)) / 2 * size_t(n) + i % (2 * size_t(n)) / 2];
                key = std::max(key, keys[i]);
            }
            keys = std::move(coarser);
        }
        glTextureSubImage3D(pyramid.texture().name(), level, 0, 0, 1, n, n, 1, GL_RED_INTEGER, GL_UNSIGNED_INT, keys.data());
    }
    pyramid.reduce();
    PyramidCulling culling(items, pyramid, 1);
    culling.draw({.view = view, .leastW = Seen::kLeastW}, [](const gpuscene::DrawList&) {});
    const std::vector<uint32_t> drawn = culling.drawn();
    const std::set<uint32_t> kept(drawn.begin(), drawn.end());
    Outcome outcome;
    outcome.kept = kept.size();
    const int size = receivers.size;
    for (uint32_t item = 0; item < items.size(); ++item) {
        const Seen box(view, items, item);
        if (box.unknown || box.known.empty()) {
            outcome.lost += box.unknown && !kept.contains(item);
            continue;
        }
        int from[2], to[2];
        for (int k = 0; k < 2; ++k) {
            from[k] = std::max(0, int(std::floor((box.image.lo[k] + 1) / 2 * size)) - 1);
            to[k] = std::min(size - 1, int(std::floor((box.image.hi[k] + 1) / 2 * size)) + 1);
        }
        bool needed = false, nearly = false;
        for (int y = from[1]; y <= to[1] && !needed; ++y)
            for (int x = from[0]; x <= to[0] && !needed; ++x) {
                const float most = receivers.read(x, y, [&](int cx, int cy) { return cells[receivers.cellOf(cy, side) * size_t(side) + receivers.cellOf(cx, side)]; });
                if (most < 0) continue;
                const glm::dvec2 place = (glm::dvec2(x, y) + 0.5) * (2.0 / size) - 1.0;
                needed = box.entry(place) <= receivers.read(x, y, [&](int rx, int ry) { return receivers.at(rx, ry); });
                nearly = nearly || box.entry(place, 0.25 * metresPerPixel) <= most + 1e-4;
            }
        outcome.needed += needed;
        outcome.lost += needed && !kept.contains(item);
        const bool large = (to[0] - from[0] + 2) * (to[1] - from[1] + 2) * side / size * side / size > 256;  // may be looked at in coarser cells
        outcome.loose += !needed && !nearly && !large && kept.contains(item);
    }
    return outcome;
}

class ReceiverPyramidTest : public ::testing::Test {
protected:
    ReceiverPyramidTest() : context_(gl::Context::headless()) {}
    ~ReceiverPyramidTest() override { EXPECT_NO_THROW(gl::checkErrors("test")); }
    gl::Context context_;
};

TEST_F(ReceiverPyramidTest, KeepsWhatAPixelNeedsAndLittleElse) {
    const scenegen::Scene scene = boxes();
    const gpuscene::GpuScene gpu(scene);
    const glm::dvec3 suns[] = {{0.3, 0.5, -0.6}, {0, 0, -1}, {0, 1, -0.2}, {1, 0, -1e-3}, {-0.7, 0.2, -0.4}};
    base::Random random(9, 0, 0);
    Outcome sum;
    int beyond = 0;
    for (const int size : {64, 100, 256, 2048})  // 100: of 64 cells; 2048: two levels are marked
        for (const double warp : {0.0, 0.6, 0.97})
            for (const glm::dvec3& sun : suns) {
                const glm::dvec3 l = glm::normalize(sun);
                const double half = random.next(15, 45);
                const CullView view = CullView::sun({random.next(-5, 5), random.next(-5, 5), 1}, sunMatrix(l, half, -12, 25, warp), l);
                const Outcome outcome = compare(gpu.items(), view, Receivers(size, beyond = (beyond + 1) % 4, random), 2 * half / size);
                EXPECT_EQ(outcome.lost, 0u) << size << " pixels, " << beyond << " read after the first, warp " << warp << ", sun " << sun.x << " " << sun.y << " " << sun.z;
                sum.kept += outcome.kept;
                sum.needed += outcome.needed;
                sum.loose += outcome.loose;
            }
    EXPECT_GT(sum.needed, 20'000u);
    EXPECT_LT(sum.loose * 100, sum.kept);
}

// More groups than llvmpipe lets a loop go round.
TEST_F(ReceiverPyramidTest, ManyGroupsAreAllLookedAt) {
    scenegen::Scene scene;
    scene.materials.resize(1);
    scene.views.emplace_back();
    scene.prototypes.emplace_back().meshes.push_back(scenegen::boxMesh(glm::vec3(1.5f)));
    constexpr uint32_t kSide = 1950;
    for (uint32_t i = 0; i < kSide * kSide; ++i) scene.instances.push_back({{float(i % kSide) - kSide / 2.0f, float(i / kSide) - kSide / 2.0f, 0}, 1, 0, 0});
    const gpuscene::GpuScene gpu(scene);
    ReceiverPyramid pyramid(2048, 1, 0);
    pyramid.clear();
    const GLuint key = GLuint(pyramid.stamp() + 1) << ReceiverPyramid::kDepthBits | 1;  // before none of them: all are needed
    for (int level = 0; level < pyramid.markedLevels(); ++level) glClearTexImage(pyramid.texture().name(), level, GL_RED_INTEGER, GL_UNSIGNED_INT, &key);
    pyramid.clear();
    pyramid.reduce();
    PyramidCulling culling(gpu.items(), pyramid, 0);
    culling.draw({.view = CullView::sun({0, 0, 0}, sunMatrix({0, 0, -1}, 1.2 * kSide / 2, 1, 2), {0, 0, -1}), .leastW = 0.05}, [](const gpuscene::DrawList&) {});
    EXPECT_EQ(culling.drawn().size(), kSide * kSide);
}

// Stamps come round; what was marked with one long ago is not there when it comes back.
TEST_F(ReceiverPyramidTest, ForgetsAllForGood) {
    ReceiverPyramid pyramid(2048, 1, 0);
    const auto marked = [&] { return std::ranges::count(pyramid.mask(0).texels, 1.0f); };
    pyramid.clear();
    EXPECT_EQ(marked(), 0);
    const int first = pyramid.stamp();
    const GLuint key = GLuint(first) << ReceiverPyramid::kDepthBits | 77;
    glTextureSubImage3D(pyramid.texture().name(), 0, 5, 9, 0, 1, 1, 1, GL_RED_INTEGER, GL_UNSIGNED_INT, &key);
    EXPECT_EQ(marked(), 1);
    for (pyramid.clear(); pyramid.stamp() != first; pyramid.clear()) ASSERT_LT(pyramid.stamp(), 4096);
    EXPECT_EQ(marked(), 0);
}

}  // namespace
}  // namespace dapple::visibility
