#include "scenegen/city/furniture.h"

#include "base/detmath.h"
#include "base/random.h"
#include "scenegen/city/assembly.h"
#include "scenegen/city/house.h"
#include "scenegen/city/solid.h"
#include "scenegen/city/traffic.h"
#include "scenegen/lod/view_distance.h"
#include "scenegen/plants/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr uint64_t kTreePurpose = 0x737472656574, kCarPurpose = 0x636172;
constexpr glm::vec3 kCarColours[] = {{0.02f, 0.02f, 0.022f}, {0.55f, 0.55f, 0.54f}, {0.30f, 0.31f, 0.33f}, {0.10f, 0.11f, 0.12f},
                                     {0.28f, 0.03f, 0.025f}, {0.03f, 0.07f, 0.19f}, {0.62f, 0.44f, 0.04f}};

/// 4.4 m long, heading along +x, wheels on z = 0.
std::vector<Mesh> carMeshes(uint32_t paint, uint32_t glass, uint32_t rubber, uint32_t lamp) {
    Mesh body, panes, wheels, lights;
    addFrustum(body, {-2.1, -0.8, 2.12, 0.8}, 0.22, {-2.2, -0.88, 2.2, 0.88}, 0.55);
    addFrustum(body, {-2.2, -0.875, 2.19, 0.875}, 0.53, {-2.1, -0.8, 2.02, 0.8}, 0.92);
    addFrustum(panes, {-1.75, -0.77, 1.0, 0.77}, 0.9, {-1.25, -0.6, 0.25, 0.6}, 1.4);
    addFrustum(body, {-1.28, -0.63, 0.28, 0.63}, 1.38, {-1.1, -0.5, 0.1, 0.5}, 1.46);
    // Posts between the panes, from the sills to the roof.
    for (const double side : {-1.0, 1.0})
        for (const double x : {-0.45, 0.42}) {
            const double y0 = 0.775 * side, y1 = 0.61 * side, w = 0.05;
            const double a = std::min(y0, y0 - 0.06 * side), b = std::max(y0, y0 - 0.06 * side);
            const double c = std::min(y1, y1 - 0.06 * side), d = std::max(y1, y1 - 0.06 * side);
            addFrustum(body, {x - w, a, x + w, b}, 0.88, {0.55 * x - w, c, 0.55 * x + w, d}, 1.41);
        }
    for (const double x : {-1.35, 1.35})
        for (const double side : {-1.0, 1.0}) addCone(wheels, {x, 0.66 * side, 0.32}, 0.32, {x, 0.91 * side, 0.32}, 0.3, 12);
    for (const double side : {-1.0, 1.0}) {
        addBox(lights, {2.1, 0.62 * side - 0.16, 0.58}, {2.195, 0.62 * side + 0.16, 0.72});
        addBox(wheels, {-2.215, 0.62 * side - 0.14, 0.6}, {-2.1, 0.62 * side + 0.14, 0.74});
    }
    return {of(body, paint), of(panes, glass), of(wheels, rubber), of(lights, lamp)};
}

Mesh lampPost() {
    Mesh m;
    addCone(m, {0, 0, -0.1}, 0.14, {0, 0, 0.9}, 0.09, 8);
    addCone(m, {0, 0, 0.88}, 0.065, {0, 0, 6.2}, 0.045, 8);
    addCone(m, {0, 0.02, 6.1}, 0.04, {0, -1.5, 6.45}, 0.035, 6);
    addFrustum(m, {-0.13, -1.9, 0.13, -1.2}, 6.42, {-0.08, -1.8, 0.08, -1.3}, 6.56);
    return m;
}

class Furnisher {
public:
    Furnisher(Scene& scene, const Plan& plan, const FurnitureOptions& options) : scene_(scene), plan_(plan), options_(options) {
        const uint32_t glass = addMaterial(scene, "car windows", {0.02f, 0.022f, 0.025f}, 0.6f, 80);
        const uint32_t rubber = addMaterial(scene, "rubber", {0.025f, 0.025f, 0.025f});
        const uint32_t lamp = addMaterial(scene, "lamp glass", {0.75f, 0.75f, 0.7f}, 0.4f, 40);
        const uint32_t iron = addMaterial(scene, "iron", {0.06f, 0.07f, 0.065f}, 0.2f, 24);
        const uint32_t sign = addMaterial(scene, "sign", {0.05f, 0.11f, 0.30f}, 0.2f, 24);
        const uint32_t paint = addMaterial(scene, "road paint", {0.55f, 0.55f, 0.52f});
        for (size_t i = 0; i < std::size(kCarColours); ++i)
            cars_[i] = addPrototype(scene, fmt::format("car {}", i), carMeshes(addMaterial(scene, fmt::format("car paint {}", i), kCarColours[i], 0.5f, 60), glass, rubber, lamp));
        Mesh shade, pole, board;
        addBox(shade, {-0.1, -1.8, 6.38}, {0.1, -1.3, 6.44});
        lamp_ = addPrototype(scene, "lamp", {of(lampPost(), iron), of(shade, lamp)});
        addCone(pole, {0, 0, -0.1}, 0.035, {0, 0, 2.75}, 0.035, 8);
        addCone(board, {0, -0.06, 2.45}, 0.32, {0, -0.03, 2.45}, 0.32, 14);
        sign_ = addPrototype(scene, "sign", {of(pole, iron), of(board, sign)});
        const auto mark = [&](const char* name, double length, double width) {
            Mesh box;
            addBox(box, {-0.5 * length, -0.5 * width, -0.02}, {0.5 * length, 0.5 * width, 0.012});
            return addPrototype(scene, name, {of(box, paint)}, false);
        };
        dash_ = mark("lane mark", 3, 0.15);
        bar_ = mark("crossing bar", 3, 0.5);
        edge_ = mark("parking line", kEdge, 0.12);
        stop_ = mark("stop line", 0.4, kStop);
    }

    void furnish(std::vector<TreePlace> trees) {
        for (size_t b = 0; b < plan_.blocks.size(); ++b) {
            const Block& block = plan_.blocks[b];
            for (size_t i = 0; i < block.kerb.size(); ++i) {
                const Street& street = plan_.streets[size_t(block.kerb.labels[i])];
                const Line kerb = block.kerb.edge(i);
                const double length = block.kerb.length(i);
                base::Random random(options_.seed, b * 64 + i, kCarPurpose);
                parkCars(kerb, length, random);
                // The lamp's arm reaches out over the roadway.
                for (double x = 6; x < length - 5; x += 27) addLamp({at(kerb, x, 0.45), kPavement}, kerb);
                if (length > 12) addInstance(scene_, sign_, {at(kerb, length - 3.4, 0.5), kPavement}, glm::dvec2(kerb.left()) * -1.0);
                if (street.width > 12)
                    for (double x = 10.5; x < length - 8; x += 9) {
                        const double along = x + 0.8 * random.next(), grows = random.next();
                        if (grows < (street.width > 20 ? 0.9 : 0.55)) trees.push_back({{at(kerb, along, 1.05), kPavement}, street.width > 20 ? 4.4 : 3.3});
                    }
            }
        }
        markLanes();
        addTraffic(scene_, plan_, cars_, options_.traffic, options_.seed);
        addTrees(trees);
    }

private:
    static glm::dvec2 at(const Line& line, double along, double left) { return line.point + line.direction * along + line.left() * left; }

    /// A sodium lamp's light falls from just under the glass, within a wide cone: 0.4 on the pavement below it, a sixth of
    /// what the noon sun gives.
    void addLamp(const glm::dvec3& foot, const Line& kerb) {
        addInstance(scene_, lamp_, foot, kerb.direction);
        if (!options_.night) return;
        constexpr double kHeight = 6.36, kReach = 1.55;
        constexpr glm::dvec3 kColour(1.25, 0.96, 0.62);  // luminance 1
        const float degree = float(base::det::kDegree);
        scene_.lights.push_back({.position = glm::vec3(foot + glm::dvec3(-kReach * kerb.left(), kHeight)), .intensity = glm::vec3(0.4 * kHeight * kHeight * kColour),
                                 .range = 25, .innerAngle = 50 * degree, .outerAngle = 78 * degree});
    }

    /// Traffic keeps to the right: cars head against the kerb's direction, which has its block to the left.
    void parkCars(const Line& kerb, double length, base::Random& random) {
        for (double x = kParkingMargin; x < length - kParkingMargin; x += 5.7) {
            const double taken = random.next(), colour = random.next(), along = random.next(), turn = random.next() - 0.5;
            if (taken >= options_.cars) continue;
            glm::dvec2 heading = -kerb.direction + kerb.left() * (0.05 * turn);
            heading /= std::sqrt(glm::dot(heading, heading));
            addInstance(scene_, cars_[size_t(colour * double(std::size(kCarColours)))], {at(kerb, x + 0.7 * along, -1.25), 0}, heading);
        }
    }

    /// Between the lanes of wide streets, along what cars park on, and bars for walkers with a stop line before each crossing.
    void markLanes() {
        for (const Street& street : plan_.streets) {
            if (street.width < 13) continue;
            std::vector<double> between{0};
            if (lanesEachWay(street) == 2) between = {-(kMiddle + 0.5 * kLaneWidth), 0, kMiddle + 0.5 * kLaneWidth};
            const double length = glm::distance(street.a, street.b);
            const Line line{street.a, (street.b - street.a) / length};
            for (double x = 4; x < length - 4; x += 9) {
                const glm::dvec2 p = line.point + line.direction * x;
                if (onCrossing(p, street, 7)) continue;
                for (const double left : between) addInstance(scene_, dash_, {p + line.left() * left, 0}, line.direction);
            }
        }
        for (const Block& block : plan_.blocks)
            for (size_t i = 0; i < block.kerb.size(); ++i) {
                // A crossing over the street along edge i at either end of the edge, half-way over: the block opposite
                // has the other half.
                const Line kerb = block.kerb.edge(i);
                const double width = plan_.streets[size_t(block.kerb.labels[i])].width, length = block.kerb.length(i);
                if (length < 30 || width < 13) continue;
                for (const double end : {3.5, length - 3.5})
                    for (double out = 0.6; out < 0.5 * width - 0.3; out += 1.0) addInstance(scene_, bar_, {at(kerb, end, -out), 0}, kerb.direction);
                const double parked = kParkedReach + 0.15;
                for (double x = 8 + 0.5 * kEdge; x + 0.5 * kEdge < length - 6; x += kEdge) addInstance(scene_, edge_, {at(kerb, x, -parked), 0}, kerb.direction);
                // Whoever drives on this side comes to the edge's beginning.
                for (double out = parked + 0.5 * kStop; out + 0.5 * kStop < 0.5 * width; out += kStop) addInstance(scene_, stop_, {at(kerb, 6.2, -out), 0}, kerb.direction);
            }
    }

    bool onCrossing(const glm::dvec2& p, const Street& own, double margin) const {
        for (const Street& s : plan_.streets) {
            if (&s == &own) continue;
            const glm::dvec2 d = s.b - s.a;
            const double t = std::clamp(glm::dot(p - s.a, d) / glm::dot(d, d), 0.0, 1.0);
            const double reach = 0.5 * s.width + margin;
            const glm::dvec2 away = p - (s.a + t * d);
            if (glm::dot(away, away) < reach * reach) return true;
        }
        return false;
    }

    void addTrees(const std::vector<TreePlace>& places) {
        if (places.empty() || options_.treeTriangles == 0) return;
        constexpr size_t kIndividuals = 3;
        const Species species = loadSpecies("oak");
        const uint32_t bark = addMaterial(scene_, "street tree bark", species.barkAlbedo);
        scene_.materials.push_back({.name = "street tree leaves", .albedo = species.leaves.albedo, .specular = 0.12f, .shininess = 24});
        const auto leaves = uint32_t(scene_.materials.size() - 1);
        const auto grow = [&](size_t i, size_t triangles, int lod) {
            Tree tree = growTree(species, {base::mix64(options_.seed + i), triangles, LeafMode::polygon, lod});
            return addPrototype(scene_, fmt::format("street tree {}", i), {of(std::move(tree.bark), bark), of(std::move(tree.leaves), leaves)});
        };
        std::array<std::array<uint32_t, 2>, kIndividuals> prototypes;  // near and far
        std::array<double, kIndividuals> radius;
        for (size_t i = 0; i < kIndividuals; ++i) {
            prototypes[i].fill(grow(i, options_.treeTriangles, 0));
            const base::Box box = scene_.prototypes.back().box();
            radius[i] = double(std::max({-box.lo.x, -box.lo.y, box.hi.x, box.hi.y}));
            if (options_.nearDetail > 0 && options_.treeTriangles > species.triangles[2]) prototypes[i][1] = grow(i, species.triangles[2], 2);
        }
        for (size_t i = 0; i < places.size(); ++i) {
            base::Random random(options_.seed, i, kTreePurpose);
            const double which = random.next(), turn = random.next(), size = random.next();
            const auto k = size_t(which * double(kIndividuals));
            const bool far = options_.nearDetail > 0 && viewDistance(scene_, places[i].foot) > options_.nearDetail;
            const double scale = places[i].crownRadius / radius[k] * (0.8 + 0.2 * size);
            scene_.instances.push_back({glm::vec3(places[i].foot), float(scale), float(2 * base::det::kPi * turn), prototypes[k][far]});
        }
    }

    Scene& scene_;
    const Plan& plan_;
    const FurnitureOptions& options_;
    std::array<uint32_t, std::size(kCarColours)> cars_{};
    static constexpr double kEdge = 10, kStop = 2.9;  // metres of line in one piece
    uint32_t lamp_ = 0, sign_ = 0, dash_ = 0, bar_ = 0, edge_ = 0, stop_ = 0;
};

}  // namespace

void addFurniture(Scene& scene, const Plan& plan, std::vector<TreePlace> trees, const FurnitureOptions& options) {
    Furnisher(scene, plan, options).furnish(std::move(trees));
}

}  // namespace dapple::scenegen::city
