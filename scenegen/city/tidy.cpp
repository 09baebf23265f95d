#include "scenegen/city/tidy.h"

#include "scenegen/city/delaunay.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

namespace dapple::scenegen::city {
namespace {

constexpr double kSame = 0.02, kOnEdge = 0.01, kStraight = 0.001;  // metres
constexpr double kLeastArea = 1;                                  // square metres
constexpr size_t kLongestRun = 64;  // corners left out in a row, so that long straight rows stay cheap

/// Points of which no two are within kSame of each other.
class Welder {
public:
    uint32_t add(const glm::dvec2& p) {
        const auto x = int64_t(std::floor(p.x / kSame)), y = int64_t(std::floor(p.y / kSame));
        for (int64_t j = y - 1; j <= y + 1; ++j)
            for (int64_t i = x - 1; i <= x + 1; ++i)
                if (const auto cell = cells_.find(key(i, j)); cell != cells_.end())
                    for (const uint32_t k : cell->second)
                        if (glm::distance(points[k], p) <= kSame) return k;
        points.push_back(p);
        cells_[key(x, y)].push_back(uint32_t(points.size() - 1));
        return uint32_t(points.size() - 1);
    }
    std::vector<glm::dvec2> points;

private:
    static uint64_t key(int64_t x, int64_t y) { return uint64_t(x) << 32 ^ (uint64_t(y) & 0xffffffff); }
    std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

double distanceToLine(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 d = b - a;
    const double length = std::sqrt(glm::dot(d, d));
    return length > 0 ? std::abs(d.x * (p.y - a.y) - d.y * (p.x - a.x)) / length : glm::distance(p, a);
}

/// Without the corners that lie within kStraight of the line between those that stay.
Ring straightened(const Ring& ring) {
    const auto isBefore = [](const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; };
    const size_t first = size_t(std::min_element(ring.begin(), ring.end(), isBefore) - ring.begin()), n = ring.size();
    const auto at = [&](size_t i) { return ring[(first + i) % n]; };
    Ring out{at(0)};
    size_t kept = 0;
    for (size_t i = 2; i <= n; ++i) {
        bool isStraight = i - kept <= kLongestRun;
        for (size_t k = kept + 1; k < i && isStraight; ++k)
            isStraight = distanceToLine(at(k), at(kept), at(i)) <= kStraight;
        if (isStraight) continue;
        kept = i - 1;
        out.push_back(at(kept));
    }
    return out;
}

struct Pieces {
    std::vector<Ring> outlines, holes;
    double area = 0;  ///< square metres, before anything small goes
};

/// Nothing if rings cross.
std::optional<Pieces> pieces(const std::vector<Ring>& rings, const std::vector<size_t>& chosen) {
    Welder welder;
    std::vector<std::vector<uint32_t>> walls;
    for (const size_t r : chosen) {
        std::vector<uint32_t>& wall = walls.emplace_back();
        for (const glm::dvec2& p : rings[r]) wall.push_back(welder.add(p));
    }
    Pieces result;
    if (welder.points.size() < 3) return result;
    Delaunay mesh(welder.points);
    for (const std::vector<uint32_t>& wall : walls)
        for (size_t i = 0; i < wall.size(); ++i)
            if (!mesh.addWall(wall[i], wall[(i + 1) % wall.size()], kOnEdge, kOnEdge)) return std::nullopt;
    for (const std::vector<uint32_t>& outline : mesh.outlines()) {
        Ring ring;
        for (const uint32_t v : outline) ring.push_back(welder.points[v]);
        const double twice = twiceArea(ring);
        result.area += 0.5 * twice;
        (twice > 0 ? result.outlines : result.holes).push_back(straightened(ring));
    }
    return result;
}

double areaOf(const Ring& ring) { return 0.5 * std::abs(twiceArea(ring)); }

/// Keeps the holes that cross nothing and take away what they enclose: all at once if possible, else by halves.
void keepHoles(const std::vector<Ring>& rings, std::vector<size_t>& kept, std::vector<size_t> holes, Pieces& best,
               size_t& bad) {
    if (holes.empty()) return;
    std::vector<size_t> all = kept;
    all.insert(all.end(), holes.begin(), holes.end());
    double expected = areaOf(rings[0]), round = 0;
    for (size_t i = 1; i < all.size(); ++i) expected -= areaOf(rings[all[i]]);
    for (const size_t r : all)
        for (size_t i = 0; i < rings[r].size(); ++i)
            round += glm::distance(rings[r][i], rings[r][(i + 1) % rings[r].size()]);
    // Welding and snapping move edges by up to 2 cm.
    if (auto found = pieces(rings, all); found && std::abs(found->area - expected) <= kSame * round) {
        kept = std::move(all), best = *std::move(found);
    } else if (holes.size() == 1) {
        ++bad;
    } else {
        const auto middle = holes.begin() + std::ptrdiff_t(holes.size() / 2);
        keepHoles(rings, kept, {holes.begin(), middle}, best, bad);
        keepHoles(rings, kept, {middle, holes.end()}, best, bad);
    }
}

}  // namespace

Tidied tidied(const std::vector<Ring>& rings) {
    Tidied out;
    std::vector<size_t> kept{0}, holes(rings.size() - 1);
    std::iota(holes.begin(), holes.end(), 1);
    std::optional<Pieces> outline = pieces(rings, kept);
    out.crosses = !outline;
    if (!outline) return out;
    Pieces found = *std::move(outline);
    keepHoles(rings, kept, std::move(holes), found, out.badHoles);
    const auto isSmall = [](const Ring& ring) { return ring.size() < 3 || areaOf(ring) < kLeastArea; };
    out.smallParts = std::erase_if(found.outlines, isSmall);
    out.smallHoles = std::erase_if(found.holes, isSmall);
    for (Ring& ring : found.outlines) out.polygons.push_back({std::move(ring)});
    for (Ring& hole : found.holes) {
        const auto holds = [&](const std::vector<Ring>& polygon) {
            return out.polygons.size() == 1 || contains(polygon[0], hole[0]);
        };
        const auto owner = std::find_if(out.polygons.begin(), out.polygons.end(), holds);
        if (owner != out.polygons.end()) owner->push_back(std::move(hole));
    }
    return out;
}

}  // namespace dapple::scenegen::city
