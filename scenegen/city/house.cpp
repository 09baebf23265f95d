#include "scenegen/city/house.h"

#include "base/random.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr double kFoot = 0.1;           // walls begin below the pavement
constexpr double kFacade = 0.25;        // thickness of a facade module before the wall
constexpr double kSlope = 0.75;         // of the roof: 37°
constexpr double kRoof = 0.22;          // thickness of the roof
constexpr double kHead = 0.03;          // facades reach into the roof
constexpr uint64_t kHousePurpose = 0x686f757365;

struct StyleOfHouse {
    double bay, groundFloor, storey, frieze;
    Opening window;
    Fittings fittings;
};
constexpr StyleOfHouse kStyles[kHouseStyles] = {
    {2.8, 4.3, 3.6, 1.0, {0.85, 0.9, 0.55, 0.20}, {true, true, true}},
    {2.5, 4.0, 3.4, 0.9, {0.70, 0.85, 0.50, 0.18}, {true, true, false}},
    {3.1, 4.6, 3.9, 1.1, {1.00, 0.8, 0.60, 0.22}, {true, true, true}},
    {3.4, 3.7, 3.1, 0.6, {0.75, 0.9, 0.55, 0.16}, {true, true, false}},
};

/// `wing` with each edge moved inwards by shift(label).
template <class Shift>
Region reshaped(const Region& wing, Shift shift) {
    glm::dvec2 lo(1e300), hi(-1e300);
    for (const glm::dvec2& p : wing.corners) lo = glm::min(lo, p), hi = glm::max(hi, p);
    Region out = rectangle(lo - 2.0, hi + 2.0, kMitre);
    for (size_t i = 0; i < wing.size() && !out.empty(); ++i) out = clip(out, wing.edge(i).moved(shift(wing.labels[i])), wing.labels[i]);
    return out;
}

double sideShift(int label) { return label == kParty ? kJoint : -0.003; }

class HouseBuilder {
public:
    HouseBuilder(Parts& parts, const House& house, std::vector<Placed>* modules) : parts_(parts), house_(house), modules_(modules) {}

    void addWing(const Wing& wing, uint64_t number) {
        random_ = base::Random(house_.seed, number, kHousePurpose);
        const double eaves = house_.eaves(), inset = modules_ ? kFacade : 0;
        Prism prism{.floor = kFoot, .roof = eaves + 0.05, .eaves = &wing.street, .slope = kSlope, .fold = 0.5 * kWingDepth};
        addPrism(parts_.wall, reshaped(wing.outline, [&](int l) { return l >= 0 || l == kCourt ? inset : sideShift(l); }), prism);
        prism.floor = eaves, prism.floorSlope = kSlope, prism.roof = eaves + kRoof;
        addPrism(parts_.roof, reshaped(wing.outline, [](int l) { return l >= 0 ? -0.5 : l == kCourt ? -0.4 : sideShift(l); }), prism);
        if (!modules_) return;
        for (size_t i = 0; i < wing.outline.size(); ++i) {
            const int label = wing.outline.labels[i];
            if (label >= 0 || label == kCourt) addFacade(wing, wing.outline.edge(i), label);
        }
        addChimneys(wing);
    }

private:
    /// The band of the wing from `lo` to `hi` metres inwards of one facade's line.
    static Region band(const Wing& wing, const Line& line, int label, double lo, double hi) {
        const Region r = reshaped(wing.outline, [&](int l) { return l == label ? lo : l >= 0 || l == kCourt ? -1 : sideShift(l); });
        return clip(r, line.moved(hi).reversed(), kMitre);
    }

    /// Stretch of the line along which the whole depth of a band is free.
    static std::pair<double, double> freeStretch(const Region& band, const Line& line) {
        double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
        for (const glm::dvec2& p : band.corners) {
            const int deep = line.distance(p) > 0.5 * kFacade;
            lo[deep] = std::min(lo[deep], line.along(p)), hi[deep] = std::max(hi[deep], line.along(p));
        }
        return {std::max(lo[0], lo[1]), std::min(hi[0], hi[1])};
    }

    void addFacade(const Wing& wing, const Line& line, int label) {
        const double eaves = house_.eaves(), top = eaves + kHead;
        const Region wall = band(wing, line, label, 0, kFacade + 0.05);
        if (wall.empty()) return;
        const auto [lo, hi] = freeStretch(wall, line);
        const int bays = std::max(0, int(std::floor((hi - lo - 0.7) / house_.bay())));
        if (bays == 0) {
            addPrism(parts_.wall, wall, kFoot, top);
        } else {
            const double start = 0.5 * (lo + hi - bays * house_.bay()), end = start + bays * house_.bay();
            const glm::dvec2 u = line.direction, left = line.left();
            addPrism(parts_.wall, clip(wall, {line.point + u * start, left}, kMitre), kFoot, top);
            addPrism(parts_.wall, clip(wall, {line.point + u * end, -left}, kMitre), kFoot, top);
            placeBays(wing, line, label, start, bays);
        }
        if (label == kCourt) return;
        addPrism(parts_.trim, band(wing, line, label, -0.38, 0.05), eaves - 0.7, eaves - 0.25);
        addPrism(parts_.trim, band(wing, line, label, -0.13, 0.04), house_.groundFloor() - 0.12, house_.groundFloor() + 0.14);
        if (house_.style == 2) addPrism(parts_.trim, band(wing, line, label, -0.1, 0.045), house_.groundFloor() + 3.78, house_.groundFloor() + 3.98);
    }

    void placeBays(const Wing& wing, const Line& line, int label, double start, int bays) {
        const bool court = label == kCourt;
        const int door = bays / 2;
        const bool shops = !court && random_.next() < 0.45f, balconies = !court && random_.next() < 0.5f, attic = random_.next() < 0.7f;
        for (int i = 0; i < bays; ++i) {
            const glm::dvec2 at = line.point + line.direction * (start + (i + 0.5) * house_.bay());
            const BayKind kind = court ? BayKind::court : i == door ? BayKind::door : shops ? BayKind::shop : BayKind::street;
            modules_->push_back({Placed::bay, kind, {at, 0}, line.direction});
            const StyleOfHouse& style = kStyles[house_.style];
            if (balconies && i % 3 == door % 3)
                for (int floor = 2; floor < house_.floors; floor += 2)
                    modules_->push_back({Placed::balcony, kind, {at, house_.groundFloor() + (floor - 1) * style.storey + 0.2}, line.direction});
            const double inwards = 1.3;
            const glm::dvec2 deepest = at + line.left() * (inwards + 2.7), half = line.direction * 1.0;
            // Where the roof runs on behind the whole dormer, not where two wings meet.
            if (attic && i % 2 == door % 2 && wing.outline.contains(deepest - half) && wing.outline.contains(deepest + half)) {
                modules_->push_back({Placed::dormer, kind, {at + line.left() * inwards, house_.eaves() + kRoof + kSlope * inwards}, line.direction});
            }
        }
    }

    void addChimneys(const Wing& wing) {
        const Line ridge = wing.street.moved(0.5 * kWingDepth - 1.1);
        double lo = 1e300, hi = -1e300;
        for (const glm::dvec2& p : wing.outline.corners) lo = std::min(lo, ridge.along(p)), hi = std::max(hi, ridge.along(p));
        const double height = house_.eaves() + kSlope * 0.5 * kWingDepth;
        for (double x = lo + 1.5 + 2 * random_.next(); x < hi - 1.5; x += 6 + 5 * random_.next()) {
            const glm::dvec2 c = ridge.point + ridge.direction * x;
            if (!wing.outline.contains(c, 1.0)) continue;
            const glm::dvec2 u = ridge.direction * 0.8, v = ridge.left() * 0.35;
            addPrism(parts_.wall, {{c - u - v, c + u - v, c + u + v, c - u + v}, {0, 0, 0, 0}}, height - 2.5, height + 1.1);
            for (const double side : {-0.5, 0.0, 0.5})
                addCone(parts_.roof, {c + ridge.direction * side, height + 1.05}, 0.14, {c + ridge.direction * side, height + 1.55}, 0.11, 6);
        }
    }

    Parts& parts_;
    const House& house_;
    std::vector<Placed>* modules_;
    base::Random random_{0, 0, 0};
};

}  // namespace

double House::eaves() const { return groundFloor() + kStyles[style].storey * (floors - 1) + kStyles[style].frieze; }
double House::groundFloor() const { return kStyles[style].groundFloor; }
double House::bay() const { return kStyles[style].bay; }

std::vector<Wing> wingsOf(const Region& parcel, const Region& lot) {
    std::vector<Wing> wings;
    for (size_t i = 0; i < lot.size(); ++i) {
        if (std::find(parcel.labels.begin(), parcel.labels.end(), int(i)) == parcel.labels.end()) continue;
        const Line street = lot.edge(i);
        Region wing = clip(parcel, street.moved(kWingDepth).reversed(), kCourt);
        for (size_t j = 0; j < lot.size() && !wing.empty(); ++j) {
            if (j == i) continue;
            // distance_j ≥ distance_i: left of the bisector.
            const Line other = lot.edge(j);
            const glm::dvec2 gradient = other.left() - street.left();
            const double length = std::sqrt(glm::dot(gradient, gradient));
            if (length < 1e-6) continue;
            const glm::dvec2 n = gradient / length;
            const double offset = (other.distance(glm::dvec2(0)) - street.distance(glm::dvec2(0))) / length;
            wing = clip(wing, {-offset * n, {n.y, -n.x}}, kMitre);
        }
        if (wing.empty() || wing.area() < 1) continue;
        wings.push_back({std::move(wing), street, int(i)});
    }
    return wings;
}

void addHouse(Parts& parts, const Region& parcel, const Region& lot, const House& house, std::vector<Placed>* modules) {
    HouseBuilder builder(parts, house, modules);
    uint64_t number = 0;
    for (const Wing& wing : wingsOf(parcel, lot)) builder.addWing(wing, number++);
}

Parts bayModule(const House& house, BayKind kind, Detail detail) {
    const StyleOfHouse& s = kStyles[house.style];
    std::vector<Row> rows;
    Opening ground = s.window;
    Fittings groundFittings{true, true, false};
    if (kind == BayKind::shop) ground = {0.25, 0.55, 0.75, 0.24}, groundFittings = {true, false, false};
    if (kind == BayKind::door) ground = {0.55 * (s.bay - 1.5), 0.06, 1.0, 0.24}, groundFittings = {false, false, false};
    if (kind == BayKind::street) ground.sill += 0.5;
    rows.push_back({kFoot, s.groundFloor, ground, groundFittings});
    for (int floor = 1; floor < house.floors; ++floor) {
        Fittings fittings = kind == BayKind::court ? Fittings{true, true, false} : s.fittings;
        if (floor + 1 == house.floors) fittings.hood = false;
        rows.push_back({rows.back().ceiling, rows.back().ceiling + s.storey, s.window, fittings});
    }
    rows.push_back({rows.back().ceiling, house.eaves() + kHead, {}, {}});
    std::vector<Row> plain = rows;
    for (Row& row : plain) row.opening = {};
    for (Row& row : rows) row.fittings.flush = detail == Detail::far;
    // A millimetre of overlap to either side: rounding leaves no crack between two modules.
    const double h = 0.5 * s.bay + 0.001;
    const std::array<glm::dvec2, 4> outline{{{-h, 0}, {h, 0}, {h, kFacade + 0.05}, {-h, kFacade + 0.05}}};
    const std::array<int, 4> columns{1, 1, 1, 1};
    Parts parts;
    for (size_t i = 0; i < 4; ++i) addWall(parts, outline[i], outline[(i + 1) % 4], 1, i == 0 ? rows : plain);
    addLids(parts.wall, outline, columns, rows.front().floor, rows.back().ceiling);
    if (kind == BayKind::door && detail == Detail::near) {
        // Two leaves of a door before the lower part of the pane, whose upper part is the fanlight.
        const double half = h - ground.side, top = s.groundFloor - ground.head - 0.6;
        for (const double side : {-1.0, 1.0}) {
            const double x0 = side < 0 ? -half - 0.01 : 0.012, x1 = side < 0 ? -0.012 : half + 0.01;
            addBox(parts.roof, {x0, 0.12, kFoot + 0.05}, {x1, 0.215, top});
        }
        addBox(parts.trim, {-half - 0.3, -0.35, top + 0.95}, {half + 0.3, 0.05, top + 1.15});
    }
    return parts;
}

Parts balconyModule(Detail detail) {
    Parts parts;
    addBox(parts.trim, {-1.25, -1.05, 0}, {1.25, 0.1, 0.16});
    if (detail == Detail::far) return parts;
    for (const double x : {-0.85, 0.85}) addFrustum(parts.trim, {x - 0.1, -0.25, x + 0.1, 0.1}, -0.5, {x - 0.1, -0.9, x + 0.1, 0.1}, 0.02);
    for (int i = 0; i <= 12; ++i) {
        const double x = -1.19 + 2.38 * i / 12;
        addBox(parts.roof, {x - 0.015, -1.0, 0.1}, {x + 0.015, -0.97, 1.1});
    }
    for (const double x : {-1.19, 1.19})
        for (int i = 1; i <= 4; ++i) addBox(parts.roof, {x - 0.015, -1.0 + 0.22 * i, 0.1}, {x + 0.015, -0.97 + 0.22 * i, 1.1});
    addBox(parts.roof, {-1.22, -1.02, 1.08}, {1.22, -0.95, 1.14});
    for (const double x : {-1.19, 1.19}) addBox(parts.roof, {x - 0.034, -0.94, 1.085}, {x + 0.034, 0.05, 1.135});
    return parts;
}

Parts dormerModule() {
    Parts parts;
    addBox(parts.wall, {-0.75, 0, -0.8}, {0.75, 2.6, 1.35});
    addBox(parts.glass, {-0.45, -0.03, 0.1}, {0.45, 0.3, 1.1});
    addBox(parts.trim, {-0.03, -0.06, 0.05}, {0.03, 0.2, 1.12});
    addBox(parts.trim, {-0.6, -0.05, 0.0}, {0.6, 0.2, 0.08});
    addFrustum(parts.roof, {-0.95, -0.25, 0.95, 2.7}, 1.32, {-0.12, 0.0, 0.12, 2.7}, 1.9);
    return parts;
}

}  // namespace dapple::scenegen::city
