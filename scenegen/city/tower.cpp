#include "scenegen/city/tower.h"

#include "base/random.h"
#include "scenegen/city/plan.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr uint64_t kTowerPurpose = 0x746f776572;

struct StyleOfTower {
    double groundFloor, storey;
    Opening window;
    Fittings fittings;
};
constexpr StyleOfTower kStyles[kTowerStyles] = {
    {4.4, 3.3, {1.05, 0.9, 0.55, 0.22}, {true, true, false}},
    {5.4, 3.7, {0.80, 0.8, 0.45, 0.38}, {true, false, false}},
    {5.0, 3.6, {0.22, 1.0, 0.45, 0.30}, {false, false, false}},
    {6.0, 3.9, {0.09, 0.5, 0.20, 0.12}, {true, false, false}},
};

/// Sides 0 … 3 are front, right, rear, left, as the edges of its outline.
class TowerBuilder {
public:
    TowerBuilder(const TowerKind& kind, uint64_t seed, Detail detail)
        : kind_(kind), style_(kStyles[kind.style]), detail_(detail),
          random_(seed, uint64_t(kind.width) << 32 | uint64_t(kind.depth) << 16 | uint64_t(kind.rise) << 8 | uint64_t(kind.style), kTowerPurpose) {}

    Parts build() {
        const int least = std::min(kind_.width, kind_.depth);
        const double share = random_.next();
        const int floors = least < 6 ? 4 + int(3 * share) : kind_.rise == 2 && least >= 8 ? 30 + int(18 * share) : kind_.rise == 1 ? 14 + int(12 * share) : 7 + int(5 * share);
        glm::ivec2 lo(0), hi(kind_.width, kind_.depth);
        if (least < 6 && !kind_.rear) hi.y -= kind_.depth > 6 ? 3 : 1;  // a rear yard
        const bool open[4] = {true, kind_.right, kind_.rear || hi.y < kind_.depth, kind_.left};
        if (floors < 9) {
            addTier(lo, hi, -0.3, floors, open, {.street = true, .last = true});
            return std::move(parts_);
        }
        const int base = kind_.style == 3 ? 2 : 4 + int(5 * random_.next());
        addTier(lo, hi, -0.3, base, open, {.street = true, .last = false});
        constexpr bool free[4] = {true, true, true, true};
        int left = floors - base;
        while (left > 0) {
            // The first step clears the lot line all round; later ones narrow the tower now and then.
            const bool far = std::min(hi.x - lo.x, hi.y - lo.y) >= 10 && random_.next() < 0.4f;
            lo += 1, hi -= far ? 2 : 1;
            const glm::ivec2 size = hi - lo;
            const bool last = std::min(size.x, size.y) < 6 || kind_.style == 3;
            const int rise = last ? left : std::max(4, int(left * (0.4 + 0.3 * random_.next())));
            addTier(lo, hi, top_ - 0.25, std::min(rise, left), free, {.street = false, .last = rise >= left});
            left -= rise;
        }
        return std::move(parts_);
    }

private:
    glm::dvec2 at(const glm::ivec2& bays) const { return kBay * (glm::dvec2(bays) - 0.5 * glm::dvec2(kind_.width, kind_.depth)); }

    struct Place {
        bool street, last;  ///< the lowest tier, the highest
    };

    void addTier(const glm::ivec2& lo, const glm::ivec2& hi, double floor, int floors, const bool (&open)[4], Place place) {
        const bool street = place.street;
        const glm::ivec2 size = hi - lo;
        const glm::dvec2 a = at(lo), b = at(hi);
        std::vector<Row> rows;
        double z = floor;
        for (int i = 0; i < floors; ++i) {
            const bool shop = street && i == 0;
            const double up = i == 0 ? (street ? style_.groundFloor - floor : top_ - floor + style_.storey) : style_.storey;
            Row row{z, z + up, style_.window, style_.fittings};
            if (i == 0) row.opening.sill += up - (street ? style_.groundFloor : style_.storey);
            if (shop) row.opening = {0.3, 0.3 + 0.6, 1.0, 0.35}, row.fittings = {true, false, false};
            row.fittings.flush = detail_ == Detail::far;
            rows.push_back(row);
            z += up;
        }
        const double roof = z + 0.25;
        rows.push_back({z, roof, {}, {}});
        std::vector<Row> blank = rows;
        for (Row& row : blank) row.opening = {};
        const std::array<glm::dvec2, 4> outline{{a, {b.x, a.y}, b, {a.x, b.y}}};
        std::array<int, 4> columns{};
        if (detail_ == Detail::massing) blank = {{floor, roof, {}, {}}};
        for (size_t i = 0; i < 4; ++i) {
            const bool windows = detail_ != Detail::massing && open[i];
            columns[i] = windows ? (i % 2 ? size.y : size.x) : 1;
            addWall(parts_, outline[i], outline[(i + 1) % 4], columns[i], windows ? rows : blank);
        }
        addLids(parts_.wall, outline, columns, floor, roof);
        top_ = roof;
        if (detail_ == Detail::massing) return;
        addRing(parts_.wall, a + 0.02, b - 0.02, 0.28, roof - 0.1, roof + 0.95);
        addRing(parts_.trim, a - 0.04 + (street ? 0.07 : 0.0), b + 0.04 - (street ? 0.07 : 0.0), 0.4, roof + 0.93, roof + 1.05);
        if (detail_ == Detail::near) {
            for (int i = 0; i < 4; ++i)
                if (open[i]) addLedges(outline[size_t(i)], outline[size_t(i + 1) % 4], street, roof);
            if (street) addShopFront(a, b);
        }
        addRoofBoxes(a + 0.5, b - 0.5, roof, place.last);
    }

    /// Bands that stand out of a wall: the cornice, and one over the shops. 5 cm short of the wall's ends, for neighbours.
    void addLedges(const glm::dvec2& from, const glm::dvec2& to, bool street, double roof) {
        if (kind_.style == 3) return;
        const glm::dvec2 u = (to - from) / std::sqrt(glm::dot(to - from, to - from)), out{u.y, -u.x};
        const auto ledge = [&](double reach, double z0, double z1) {
            const glm::dvec2 p = from + 0.05 * u - 0.06 * out, q = to - 0.05 * u - 0.06 * out, r = out * (reach + 0.06);
            const glm::dvec3 low[] = {{p + r, z0}, {q + r, z0}, {q, z0}, {p, z0}}, high[] = {{p + r, z1}, {q + r, z1}, {q, z1}, {p, z1}};
            addLoft(parts_.trim, low, high);
        };
        ledge(kind_.style == 0 ? 0.5 : 0.25, roof - 0.15, roof + 0.3);
        if (street) ledge(0.15, style_.groundFloor - 0.3, style_.groundFloor + 0.15);
    }

    /// The door and its canopy, in the middle of the front.
    void addShopFront(const glm::dvec2& a, const glm::dvec2& b) {
        const double x = 0.5 * (a.x + b.x), y = a.y;
        addBox(parts_.roof, {x - 1.6, y - 1.5, 3.15}, {x + 1.6, y + 0.2, 3.4});
        addBox(parts_.trim, {x - 1.3, y - 0.16, -0.2}, {x + 1.3, y + 0.3, 2.75});
        addBox(parts_.glass, {x - 1.1, y - 0.2, 0.2}, {x - 0.04, y - 0.1, 2.6});
        addBox(parts_.glass, {x + 0.04, y - 0.2, 0.2}, {x + 1.1, y - 0.1, 2.6});
    }

    void addRoofBoxes(const glm::dvec2& a, const glm::dvec2& b, double roof, bool last) {
        const glm::dvec2 size = b - a, centre = 0.5 * (a + b);
        const int boxes = 2 + int(4 * random_.next());
        for (int i = 0; i < boxes; ++i) {
            const double x = random_.next(), y = random_.next(), w = random_.next(), h = random_.next();
            // Along the rim, where the next tier leaves room; each at a height of its own, so that no two tops coincide.
            const glm::dvec2 half(0.5 + 0.5 * w, 0.6 + 0.4 * h);
            const bool atFront = i % 2 == 0;
            const glm::dvec2 c{a.x + half.x + x * (size.x - 2 * half.x), atFront ? a.y + 1.4 : b.y - 1.4 - 0.2 * y};
            addBox(parts_.trim, {c - half, roof - 0.05 - 0.003 * i}, {c + half, roof + 0.7 + 0.9 * h + 0.01 * i});
        }
        if (!last) return;
        const glm::dvec2 half = glm::min(0.2 * size, glm::dvec2(3.2, 2.6));
        addBox(parts_.wall, {centre - half, roof - 0.08}, {centre + half, roof + 3.1});
        if (kind_.style < 2 && random_.next() < 0.6f) addTank({centre, roof + 3.1});
    }

    /// A water tank on its legs.
    void addTank(const glm::dvec3& foot) {
        Mesh& m = parts_.roof;
        const auto box = [&](const glm::dvec3& lo, const glm::dvec3& hi) { addBox(m, foot + lo, foot + hi); };
        for (const double x : {-1.1, 1.1})
            for (const double y : {-1.1, 1.1}) box({x - 0.1, y - 0.1, -0.4}, {x + 0.1, y + 0.1, 2.6});
        box({-1.4, -1.4, 2.5}, {1.4, 1.4, 2.7});
        addCone(m, foot + glm::dvec3(0, 0, 2.65), 1.55, foot + glm::dvec3(0, 0, 5.9), 1.5, 16);
        addCone(m, foot + glm::dvec3(0, 0, 5.87), 1.7, foot + glm::dvec3(0, 0, 7.1), 0.08, 16);
    }

    const TowerKind& kind_;
    const StyleOfTower& style_;
    Detail detail_;
    base::Random random_;
    double top_ = 0;
    Parts parts_;
};

}  // namespace

Parts towerParts(const TowerKind& kind, uint64_t seed, Detail detail) { return TowerBuilder(kind, seed, detail).build(); }

}  // namespace dapple::scenegen::city
