#include "scenegen/city/plan.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr uint64_t kCutPurpose = 0x637574, kFieldPurpose = 0x6669656c64, kUsePurpose = 0x757365, kParcelPurpose = 0x70617263;

glm::dvec2 onCircle(double turn) {
    const base::det::SinCos a = base::det::sinCos(2 * base::det::kPi * turn);
    return {a.cos, a.sin};
}

Region shrunk(const Region& region, const std::vector<double>& by) {
    Region out = region;
    for (size_t i = 0; i < region.size() && !out.empty(); ++i) out = clip(out, region.edge(i).moved(by[i]), region.labels[i]);
    return out;
}

/// Sine of the sharpest corner.
double sharpest(const Region& r) {
    double least = 1;
    for (size_t i = 0; i < r.size(); ++i) {
        const glm::dvec2 d = r.edge(i).direction, e = r.edge((i + 1) % r.size()).direction;
        // Obtuse corners, nearly straight ones included, do no harm.
        if (glm::dot(d, e) < 0) least = std::min(least, d.x * e.y - d.y * e.x);
    }
    return least;
}

/// Cells between centre lines of streets: labels are streets.
class ViennaPlanner {
public:
    ViennaPlanner(double area, uint64_t seed) : seed_(seed), radius_(std::sqrt(area / 3.0614674589)) {
        base::Random random(seed, 0, kFieldPurpose);
        for (Frame& f : frames_) {
            const double turn = random.next(), far = random.next(), angle = random.next();
            f = {onCircle(turn) * radius_ * std::sqrt(far), onCircle(angle), 0.5 * radius_};
        }
    }

    Plan plan() {
        Region city;  // regular 16-gon: its area is 16/2 · sin(22.5°) · r² = 3.0615 r²
        for (int i = 0; i < 16; ++i) city.corners.push_back(radius_ * onCircle((i + 0.5) / 16));
        for (size_t i = 0; i < 16; ++i) city.labels.push_back(street(city.corners[i], city.next(i), 18));
        uint64_t id = 16;  // at most nine: no district's cells have another's names
        for (const Region& cell : districts(city)) halve(cell, id++, {});
        for (glm::dvec2& p : city.corners) p *= 1 + 12 / radius_;
        plan_.ground = city;
        return std::move(plan_);
    }

private:
    struct Frame {
        glm::dvec2 centre, fourfold;  ///< (cos 4θ, sin 4θ)
        double reach;
    };

    int street(const glm::dvec2& a, const glm::dvec2& b, double width) {
        plan_.streets.push_back({a, b, width});
        return int(plan_.streets.size() - 1);
    }

    /// The old town within a ring of eight boulevards, and the sectors between the radial ones.
    std::vector<Region> districts(const Region& city) {
        if (radius_ < 420) return {city};
        std::vector<glm::dvec2> corners;
        base::Random random(seed_, 1, kFieldPurpose);
        for (int i = 0; i < 8; ++i) {
            const double turn = (i + 0.3 * (random.next() - 0.5)) / 8;
            corners.push_back(radius_ * 0.46 * onCircle(turn));
        }
        std::vector<Region> cells(1);
        std::array<int, 8> radials{};
        for (size_t i = 0; i < 8; ++i) {
            cells[0].corners.push_back(corners[i]);
            cells[0].labels.push_back(street(corners[i], corners[(i + 1) % 8], 34));
            radials[i] = street(corners[i], corners[i] / (0.46 * radius_) * radius_ * 0.985, i % 2 ? 16 : 24);
        }
        const Region ring = cells[0];
        for (size_t i = 0; i < 8; ++i) {
            const size_t j = (i + 1) % 8;
            Region sector = clip(city, ring.edge(i).reversed(), ring.labels[i]);
            sector = clip(sector, {corners[i], glm::normalize(corners[i])}, radials[i]);
            sector = clip(sector, {corners[j], -glm::normalize(corners[j])}, radials[j]);
            cells.push_back(sector);
        }
        return cells;
    }

    /// Direction of the cross field: the blend of 4θ of the frames, and half its angle taken twice.
    glm::dvec2 field(const glm::dvec2& p) const {
        const glm::dvec2 r = p / std::max(1.0, std::sqrt(glm::dot(p, p)));
        const glm::dvec2 twice{r.x * r.x - r.y * r.y, 2 * r.x * r.y};
        glm::dvec2 sum = glm::dvec2(twice.x * twice.x - twice.y * twice.y, 2 * twice.x * twice.y) * (glm::dot(p, p) / (radius_ * radius_));
        for (const Frame& f : frames_) {
            const double q = glm::dot(p - f.centre, p - f.centre) / (f.reach * f.reach);
            sum += f.fourfold * (1 / (1 + 4 * q * q));
        }
        for (int half = 0; half < 2; ++half) {
            sum /= std::max(1e-9, std::sqrt(glm::dot(sum, sum)));
            const double c = std::sqrt(std::max(0.0, 0.5 * (1 + sum.x))), s = std::sqrt(std::max(0.0, 0.5 * (1 - sum.x)));
            sum = {c, sum.y < 0 ? -s : s};
        }
        return sum;
    }

    /// `id` names the cell by its path of cuts, so that a cut here never shifts the random numbers of another.
    /// `around`: streets that bounded a cell which this one was cut from.
    void halve(const Region& cell, uint64_t id, std::vector<int> around) {
        for (const int label : cell.labels)
            if (std::find(around.begin(), around.end(), label) == around.end()) around.push_back(label);
        base::Random random(seed_, id, kCutPurpose);
        const double area = cell.area(), block = 8500 * (0.8 + 0.9 * random.next());
        const double shift = 0.2 * (random.next() - 0.5);
        if (area < 1.45 * block) return addBlock(cell, id, around);
        const glm::dvec2 u = field(cell.centroid());
        const Extent box = orientedBox(cell);
        const glm::dvec2 across{-box.direction.y, box.direction.x};
        double bestScore = 0;
        Region best[2];
        Line bestLine;
        for (const auto& [direction, liking] : {std::pair(u, 1.2), std::pair(glm::dvec2(-u.y, u.x), 1.2), std::pair(across, 1.0)}) {
            const Line line = Line{cell.centroid(), direction}.moved(shift * std::sqrt(area));
            const Region left = clip(cell, line, 0), right = clip(cell, line.reversed(), 0);
            if (left.empty() || right.empty()) continue;
            const double score = liking * std::min(orientedBox(left).width() * sharpest(left), orientedBox(right).width() * sharpest(right));
            if (score <= bestScore) continue;
            bestScore = score, best[0] = left, best[1] = right, bestLine = line;
        }
        if (bestScore < 38) return addBlock(cell, id, around);
        const double width = area > 110'000 ? 18 : area > 40'000 ? 14 : 10.5;
        double lo = 1e300, hi = -1e300;
        for (const glm::dvec2& p : best[0].corners)
            if (std::abs(bestLine.distance(p)) < 1e-6) lo = std::min(lo, bestLine.along(p)), hi = std::max(hi, bestLine.along(p));
        const int label = street(bestLine.point + bestLine.direction * lo, bestLine.point + bestLine.direction * hi, width);
        for (int side = 0; side < 2; ++side) {
            const Line line = side ? bestLine.reversed() : bestLine;
            halve(clip(cell, line, label), 2 * id + uint64_t(side), around);
        }
    }

    void addBlock(const Region& cell, uint64_t id, const std::vector<int>& around) {
        Block block;
        std::vector<double> pavement;
        block.kerb = cell;
        // Not of the cell's own streets alone: near a sharp corner the roadway of a wide street may reach across the tip of the cell next door.
        for (const int label : around) {
            const Street& s = plan_.streets[size_t(label)];
            Line line{s.a, (s.b - s.a) / glm::distance(s.a, s.b)};
            if (line.distance(cell.centroid()) < 0) line = line.reversed();
            block.kerb = clip(block.kerb, line.moved(0.5 * s.width), label);
        }
        if (block.kerb.empty()) return;
        for (const int label : block.kerb.labels) pavement.push_back(plan_.streets[size_t(label)].width > 20 ? 6 : plan_.streets[size_t(label)].width > 12 ? 4 : 2.8);
        block.lot = shrunk(block.kerb, pavement);
        if (block.lot.empty()) return;
        for (size_t i = 0; i < block.lot.size(); ++i) block.lot.labels[i] = int(i);
        block.park = block.lot.area() < 900 || orientedBox(block.lot).width() < 24 || base::Random(seed_, id, kUsePurpose).next() < 0.06f;
        plan_.blocks.push_back(std::move(block));
    }

    uint64_t seed_;
    double radius_;
    std::array<Frame, 5> frames_;
    Plan plan_;
};

Plan manhattan(double area, uint64_t seed) {
    constexpr double kPavement = 4, kAvenue = 30, kStreet = 18;
    const glm::dvec2 lot(72 * kBay, 20 * kBay), block = lot + 2 * kPavement, pitch = block + glm::dvec2(kAvenue, kStreet);
    // As square as whole blocks allow.
    const double side = std::sqrt(area);
    const int nx = std::max(1, int(std::floor(side / pitch.x + 0.5))), ny = std::max(1, int(std::floor(area / (nx * pitch.x) / pitch.y + 0.5)));
    const glm::dvec2 size = pitch * glm::dvec2(nx, ny), lo = -0.5 * size;
    Plan plan;
    for (int i = 0; i <= nx; ++i) plan.streets.push_back({lo + glm::dvec2(i * pitch.x, 0), lo + glm::dvec2(i * pitch.x, size.y), kAvenue});
    for (int j = 0; j <= ny; ++j) plan.streets.push_back({lo + glm::dvec2(0, j * pitch.y), lo + glm::dvec2(size.x, j * pitch.y), kStreet});
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
            Block b;
            const glm::dvec2 at = lo + pitch * glm::dvec2(i, j) + 0.5 * glm::dvec2(kAvenue, kStreet);
            b.kerb = rectangle(at, at + block, 0);
            b.kerb.labels = {nx + 1 + j, i + 1, nx + 2 + j, i};
            b.lot = rectangle(at + kPavement, at + kPavement + lot, 0);
            b.lot.labels = {0, 1, 2, 3};
            b.park = nx * ny > 20 && base::Random(seed, uint64_t(j * nx + i), kUsePurpose).next() < 0.03f;
            plan.blocks.push_back(std::move(b));
        }
    plan.ground = rectangle(lo - 0.5 * kAvenue, lo + size + 0.5 * kAvenue, 0);
    return plan;
}

struct Subdivider {
    const ParcelOptions& options;
    uint64_t seed;
    std::vector<Region>& parcels;

    bool fits(const Region& r) const {
        return !r.empty() && orientedBox(r).width() >= options.widthMin - 1e-6 && r.frontage() >= options.widthMin - 1e-6;
    }

    void halve(const Region& parcel, uint64_t id) {
        base::Random random(seed, id, kParcelPurpose);
        const double bound = random.next(float(options.areaMin), float(options.areaMax));
        const double shift = options.irregularity * (random.next() - 0.5);
        const Extent box = orientedBox(parcel);
        const glm::dvec2 left{-box.direction.y, box.direction.x};
        if (parcel.area() > bound)
            // Across the long side; where that would cut a parcel off from the street, along it (street access rotation).
            for (const bool along : {false, true}) {
                const double lo = along ? box.acrossLo : box.alongLo, size = along ? box.width() : box.length();
                double at = size * (0.5 + 0.5 * shift);
                if (options.snap > 0) at = options.snap * std::floor(at / options.snap + 0.5);
                const Line cut = along ? Line{left * (lo + at), box.direction} : Line{box.direction * (lo + at), left};
                const Region a = clip(parcel, cut, -1), b = clip(parcel, cut.reversed(), -1);
                if (!fits(a) || !fits(b)) continue;
                halve(a, 2 * id);
                halve(b, 2 * id + 1);
                return;
            }
        parcels.push_back(parcel);
    }
};

}  // namespace

Plan layOut(Style style, double area, uint64_t seed) {
    return style == Style::vienna ? ViennaPlanner(area, seed).plan() : manhattan(area, seed);
}

std::vector<Region> subdivide(const Region& lot, const ParcelOptions& options, uint64_t seed) {
    std::vector<Region> parcels;
    Subdivider{options, seed, parcels}.halve(lot, 1);
    return parcels;
}

}  // namespace dapple::scenegen::city
