#include "scenegen/plants/species.h"

#include "base/detmath.h"
#include "base/error.h"
#include "base/file.h"
#include "scenegen/plants/lanes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

namespace dapple::scenegen {
namespace {

glm::vec3 readAlbedo(base::ConfigTable& table, const char* key) {
    const std::vector<double> v = table.numbers(key, 3);
    for (const double c : v)
        if (c < 0 || c > 1) table.fail(key, "an albedo lies between 0 and 1");
    return {float(v[0]), float(v[1]), float(v[2])};
}

LevelParameters readLevel(base::ConfigTable& t) {
    LevelParameters p;
    p.length = t.number("length", p.length, 0.01, 10);
    p.lengthV = t.number("lengthV", 0, 0, 10);
    if (p.lengthV >= p.length) t.fail("lengthV", "must be below length: a stem would have no length");
    p.taper = t.number("taper", p.taper, 0, 3);
    p.curveRes = int(t.integer("curveRes", p.curveRes, 1, 40));
    p.curve = t.number("curve", 0, -360, 360);
    p.curveBack = t.number("curveBack", 0, -360, 360);
    p.curveV = t.number("curveV", 0, -90, 360);
    p.segSplits = t.number("segSplits", 0, 0, 3);
    p.splitAngle = t.number("splitAngle", 0, 0, 90);
    p.splitAngleV = t.number("splitAngleV", 0, 0, 90);
    p.downAngle = t.number("downAngle", 0, 0, 180);
    p.downAngleV = t.number("downAngleV", 0, -90, 90);
    p.rotate = t.number("rotate", p.rotate, -360, 360);
    p.rotateV = t.number("rotateV", 0, 0, 360);
    p.branches = t.number("branches", 0, 0, 1000);
    p.whorl = int(t.integer("whorl", 1, 1, 20));
    p.sides = int(t.integer("sides", p.sides, 4, 32));
    if (p.sides % 2 != 0) t.fail("sides", "must be even: a branch's caps are made of quads");
    p.refine = int(t.integer("refine", 0, 0, 4));
    t.finish();
    return p;
}

LeafShape readShape(base::ConfigTable& t) {
    const std::string name = t.text("shape", kLeafShapes[0]);
    const auto found = std::find(kLeafShapes.begin(), kLeafShapes.end(), name);
    if (found == kLeafShapes.end()) t.fail("shape", fmt::format("'{}' is none of {}", name, fmt::join(kLeafShapes, ", ")));
    return LeafShape(found - kLeafShapes.begin());
}

LeafParameters readLeaves(base::ConfigTable& t) {
    LeafParameters p;
    p.count = t.number("count", p.count, -10'000, 10'000);
    p.shape = readShape(t);
    p.scale = t.number("scale", p.scale, 0.001, 10);
    p.scaleX = t.number("scaleX", p.scaleX, 0.01, 10);
    p.downAngle = t.number("downAngle", p.downAngle, 0, 180);
    p.downAngleV = t.number("downAngleV", p.downAngleV, 0, 90);
    p.rotate = t.number("rotate", p.rotate, -360, 360);
    p.rotateV = t.number("rotateV", p.rotateV, 0, 360);
    p.flat = t.number("flat", p.flat, 0, 1);
    p.bend = t.number("bend", 0, 0, 1);
    p.tipScale = t.number("tipScale", p.tipScale, 0.01, 10);
    p.cardScale = t.number("cardScale", p.cardScale, 0.001, 20);
    p.cardScaleX = t.number("cardScaleX", p.cardScaleX, 0.01, 10);
    p.cardLeaves = t.number("cardLeaves", p.cardLeaves, 1, 1000);
    if (t.has("cardFar")) {
        const std::vector<double> far = t.numbers("cardFar", kLods - 1);
        for (size_t k = 0; k < far.size(); ++k) {
            if (far[k] < 0.1 || far[k] > 10) t.fail("cardFar", fmt::format("{} is not between 0.1 and 10", far[k]));
            p.cardFar[k] = far[k];
        }
    }
    p.cardDownAngle = t.number("cardDownAngle", p.cardDownAngle, 0, 180);
    p.needles = t.boolean("needles", false);
    p.albedo = readAlbedo(t, "albedo");
    t.finish();
    return p;
}

PruneParameters readPrune(base::ConfigTable& t) {
    PruneParameters p;
    p.ratio = t.number("ratio", p.ratio, 0, 1);
    p.width = t.number("width", p.width, 0.01, 2);
    p.widthPeak = t.number("widthPeak", p.widthPeak, 0, 0.99);
    p.powerLow = t.number("powerLow", p.powerLow, 0, 10);
    p.powerHigh = t.number("powerHigh", p.powerHigh, 0, 10);
    t.finish();
    return p;
}

ColonisationParameters readColonisation(base::ConfigTable& t) {
    ColonisationParameters p;
    p.attractors = int(t.integer("attractors", p.attractors, 1, 100'000));
    p.influence = t.number("influence", p.influence, 0.05, 100);
    p.kill = t.number("kill", p.kill, 0.01, p.influence);
    p.step = t.number("step", p.step, 0.01, 10);
    if (p.step > p.kill) t.fail("step", "must not exceed kill: nodes would jump over attractors for ever");
    p.tropism = t.number("tropism", p.tropism, -10, 10);
    p.pipe = t.number("pipe", p.pipe, 1, 5);
    t.finish();
    return p;
}

std::array<size_t, kLods> readBudgets(base::ConfigTable& t) {
    std::array<size_t, kLods> budgets;
    const std::vector<double> v = t.numbers("triangles", kLods);
    for (size_t i = 0; i < v.size(); ++i) {
        if (v[i] < 60 || v[i] > 1e7 || (i > 0 && v[i] >= v[i - 1])) t.fail("triangles", "must fall from level to level, to no less than 60");
        budgets[i] = size_t(v[i]);
    }
    return budgets;
}

std::filesystem::path speciesFolder() { return base::homeFolder() / "scenegen/plants/species"; }

}  // namespace

Species readSpecies(base::ConfigTable& t) {
    Species s;
    s.name = t.text("name");
    s.triangles = readBudgets(t);
    s.shape = int(t.integer("shape", 0, 0, 8));
    s.baseSize = t.number("baseSize", s.baseSize, 0, 0.95);
    s.scale = t.number("scale", s.scale, 0.1, 150);
    s.scaleV = t.number("scaleV", 0, 0, 100);
    if (s.scaleV >= s.scale) t.fail("scaleV", "must be below scale: a tree would have no height");
    s.zScale = t.number("zScale", 1, 0.1, 10);
    s.zScaleV = t.number("zScaleV", 0, 0, 10);
    if (s.zScaleV >= s.zScale) t.fail("zScaleV", "must be below zScale: a tree would have no height");
    s.ratio = t.number("ratio", s.ratio, 0.0005, 0.5);
    s.ratioPower = t.number("ratioPower", s.ratioPower, 0.1, 5);
    s.radiusScale = t.number("radiusScale", 1, 0.05, 20);
    s.radiusScaleV = t.number("radiusScaleV", 0, 0, 20);
    if (s.radiusScaleV >= s.radiusScale) t.fail("radiusScaleV", "must be below radiusScale: a trunk would have no radius");
    s.flare = t.number("flare", 0, 0, 10);
    s.lobes = int(t.integer("lobes", 0, 0, 20));
    s.lobeDepth = t.number("lobeDepth", 0, 0, 0.9);
    s.baseSplits = int(t.integer("baseSplits", 0, 0, 5));
    s.attractionUp = t.number("attractionUp", 0, -10, 10);
    s.barkShare = t.number("barkShare", s.barkShare, 0.01, 0.95);
    s.barkAlbedo = readAlbedo(t, "barkAlbedo");
    for (base::ConfigTable& level : t.tables("level")) s.levels.push_back(readLevel(level));
    if (s.levels.size() < 2 || s.levels.size() > 4) t.fail("level", "a species has 2 to 4 [[level]] tables");
    if (std::optional<base::ConfigTable> prune = t.table("prune")) s.prune = readPrune(*prune);
    if (std::optional<base::ConfigTable> colonisation = t.table("colonisation")) s.colonisation = readColonisation(*colonisation);
    if (s.colonisation && s.levels.size() != 3) t.fail("level", "a colonised species has 3: trunk, limbs, twigs");
    std::optional<base::ConfigTable> leaves = t.table("leaves");
    if (!leaves) t.fail("leaves", "is required");
    s.leaves = readLeaves(*leaves);
    t.finish();
    return s;
}

std::vector<std::string> listSpecies() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(speciesFolder()))
        if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

Species loadSpecies(const std::string& name) {
    const std::vector<std::string> known = listSpecies();
    if (!std::binary_search(known.begin(), known.end(), name)) throw base::UsageError(base::unknownName("species", name, known));
    base::ConfigTable table = base::ConfigTable::parseFile(speciesFolder() / (name + ".toml"));
    return readSpecies(table);
}

double shapeRatio(int shape, double r) {
    switch (shape) {
        case 0: return 0.2 + 0.8 * r;
        case 1: return 0.2 + 0.8 * base::det::sin(base::det::kPi * r);
        case 2: return 0.2 + 0.8 * base::det::sin(0.5 * base::det::kPi * r);
        case 3: return 1;
        case 4: return 0.5 + 0.5 * r;
        case 5: return r <= 0.7 ? r / 0.7 : (1 - r) / 0.3;
        case 6: return 1 - 0.8 * r;
        default: return r <= 0.7 ? 0.5 + 0.5 * r / 0.7 : 0.5 + 0.5 * (1 - r) / 0.3;
    }
}

namespace {

/// Of the envelope at a height: the base and the exponent of its power.
std::pair<double, double> envelopePower(const PruneParameters& p, double r) {
    const double top = 1 - p.widthPeak;  // share of the crown above its widest place
    return r < top ? std::pair(r / top, p.powerHigh) : std::pair((1 - r) / (1 - top), p.powerLow);
}

}  // namespace

double envelopeRatio(const PruneParameters& p, double r) {
    if (r < 0 || r > 1) return 0;
    const auto [base, power] = envelopePower(p, r);
    return base::det::pow(base, power);  // 0 for a base of 0, so that a power of 0 still closes the envelope
}

void envelopeRatios(const PruneParameters& p, std::span<double> ratios) {
    std::vector<double> bases[2];  // of either exponent
    const auto of = [&](double power) -> std::vector<double>& { return bases[power == p.powerLow]; };
    for (const double r : ratios)
        if (r >= 0 && r <= 1) {
            const auto [base, power] = envelopePower(p, r);
            of(power).push_back(base);
        }
    powers(bases[1], p.powerLow);
    powers(bases[0], p.powerHigh);
    const double* next[2] = {bases[0].data(), bases[1].data()};
    for (double& r : ratios) r = r >= 0 && r <= 1 ? *next[envelopePower(p, r).second == p.powerLow]++ : 0;
}

}  // namespace dapple::scenegen
