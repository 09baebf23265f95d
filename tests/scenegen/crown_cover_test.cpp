// What a tree hides keeps from one level of detail to the next: fewer and larger leaves may thin no crown and fill none up.
#include "scenegen/plants/foliage.h"
#include "scenegen/plants/tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace dapple::scenegen;
namespace base = dapple::base;

namespace {

/// A tree as a far camera sees it from `heading` (radians): pixels of `metres` that its leaves or wood hide.
class Silhouette {
public:
    Silhouette(double heading, double metres) : across_(std::cos(heading), std::sin(heading), 0), metres_(metres) {}

    /// `card`: cut by the alpha test at one half; null for whole triangles.
    void add(const Mesh& mesh, const base::Image8* card) {
        for (size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
            glm::dvec2 p[3], uv[3];
            for (int k = 0; k < 3; ++k) {
                const uint32_t v = mesh.indices[t + size_t(k)];
                p[k] = glm::dvec2(glm::dot(glm::dvec3(mesh.positions[v]), across_), mesh.positions[v].z) / metres_ + double(kSize) / 2;
                p[k].y -= double(kSize) / 2 - 8;
                if (card) uv[k] = glm::dvec2(mesh.uvs[v]);
            }
            const double twice = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x);
            if (twice == 0) continue;
            const auto low = [&](int axis) { return std::max(0, int(std::ceil(std::min({p[0][axis], p[1][axis], p[2][axis]}) - 0.5))); };
            const auto high = [&](int axis) { return std::min(kSize - 1, int(std::floor(std::max({p[0][axis], p[1][axis], p[2][axis]}) - 0.5))); };
            for (int y = low(1); y <= high(1); ++y)
                for (int x = low(0); x <= high(0); ++x) {
                    const glm::dvec2 at(x + 0.5, y + 0.5);
                    double w[3];
                    for (int k = 0; k < 3; ++k) {
                        const glm::dvec2 &a = p[(k + 1) % 3], &b = p[(k + 2) % 3];
                        w[k] = ((b.x - a.x) * (at.y - a.y) - (b.y - a.y) * (at.x - a.x)) / twice;
                    }
                    if (std::min({w[0], w[1], w[2]}) < 0) continue;
                    if (card) {
                        const glm::dvec2 texel = (w[0] * uv[0] + w[1] * uv[1] + w[2] * uv[2]) * double(card->width);
                        const auto clamped = [&](double c) { return std::clamp(int(c), 0, card->width - 1); };
                        if (card->at(clamped(texel.x), clamped(texel.y))[3] < 128) continue;
                    }
                    hidden_[size_t(y * kSize + x)] = true;
                }
        }
    }
    double count() const { return double(std::ranges::count(hidden_, true)); }

    static constexpr int kSize = 300;

private:
    glm::dvec3 across_;
    double metres_;
    std::vector<bool> hidden_ = std::vector<bool>(size_t(kSize * kSize), false);
};

class CrownCover : public testing::TestWithParam<std::string> {};

}  // namespace

TEST_P(CrownCover, ofEveryModeIsKeptByEveryLevel) {
    const Species species = loadSpecies(GetParam());
    const base::Image8 card = drawCard(species, 256);
    for (const LeafMode mode : {LeafMode::card, LeafMode::polygon}) {
        double covered[kLods] = {};
        for (uint64_t seed = 1; seed <= 4; ++seed) {
            double metres = 0;  // of a pixel: the finest level fills most of the picture
            for (int lod = 0; lod < kLods; ++lod) {
                const Tree tree = growTree(species, {seed, species.triangles[size_t(lod)], mode, lod});
                if (lod == 0) {
                    base::Box box;
                    for (const Mesh* mesh : {&tree.bark, &tree.leaves})
                        for (const glm::vec3& p : mesh->positions) box.extend(p);
                    metres = double(std::max(box.size().z, 2 * std::max(std::max(-box.lo.x, box.hi.x), std::max(-box.lo.y, box.hi.y)))) / (0.9 * Silhouette::kSize);
                }
                for (const double heading : {0.4, 1.9}) {
                    Silhouette picture(heading, metres);
                    picture.add(tree.bark, nullptr);
                    picture.add(tree.leaves, mode == LeafMode::card ? &card : nullptr);
                    covered[lod] += picture.count();
                }
            }
        }
        for (int lod = 1; lod < kLods; ++lod) {
            EXPECT_GT(covered[lod] / covered[0], 0.8) << "mode " << int(mode) << " level " << lod;
            EXPECT_LT(covered[lod] / covered[0], 1.25) << "mode " << int(mode) << " level " << lod;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Registry, CrownCover, testing::ValuesIn(listSpecies()), [](const auto& test) {
    std::string name = test.param;
    std::erase(name, '-');
    return name;
});
