#include "scenegen/city/footprints.h"

#include "base/error.h"
#include "scenegen/city/geojson.h"
#include "scenegen/city/projection.h"
#include "scenegen/city/tidy.h"
#include "scenegen/import/budget.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

namespace dapple::scenegen::city {
namespace {

struct Building {
    std::vector<Ring> rings;
    BuildingTags tags;
};

double areaOf(const std::vector<Ring>& rings) {
    double twice = 0;
    for (const Ring& ring : rings) twice += twiceArea(ring);
    return 0.5 * twice;
}

/// A point within: the middle of the widest gap along a line across the outline that meets no corner.
glm::dvec2 pointWithin(const std::vector<Ring>& rings) {
    double lo = 1e300, hi = -1e300;
    for (const glm::dvec2& p : rings[0]) lo = std::min(lo, p.y), hi = std::max(hi, p.y);
    const double y = lo + 0.4837 * (hi - lo);
    std::vector<double> crossings;
    for (const Ring& ring : rings)
        for (size_t i = 0; i < ring.size(); ++i) {
            const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
            if ((a.y > y) != (b.y > y)) crossings.push_back(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
        }
    std::sort(crossings.begin(), crossings.end());
    glm::dvec2 best(rings[0][0]);
    double widest = -1;
    for (size_t i = 0; i + 1 < crossings.size(); i += 2)
        if (const double width = crossings[i + 1] - crossings[i]; width > widest)
            widest = width, best = {0.5 * (crossings[i] + crossings[i + 1]), y};
    return best;
}

/// Outlines in which parts lie go: the parts are the building.
void replaceByParts(std::vector<Building>& buildings, Notes& notes) {
    constexpr double kCell = 100;  // metres
    const auto cellOf = [](double x) { return int(std::floor(x / kCell)); };
    std::map<std::pair<int, int>, std::vector<size_t>> parts;
    std::vector<glm::dvec2> within(buildings.size());
    for (size_t i = 0; i < buildings.size(); ++i)
        if (buildings[i].tags.isPart) {
            within[i] = pointWithin(buildings[i].rings);
            parts[{cellOf(within[i].x), cellOf(within[i].y)}].push_back(i);
        }
    if (parts.empty()) return;
    std::vector<bool> replaced(buildings.size());
    for (size_t k = 0; k < buildings.size(); ++k) {
        const Building& building = buildings[k];
        if (building.tags.isPart) continue;
        glm::dvec2 lo(1e300), hi(-1e300);
        for (const glm::dvec2& p : building.rings[0]) lo = glm::min(lo, p), hi = glm::max(hi, p);
        double covered = 0;
        for (int x = cellOf(lo.x); x <= cellOf(hi.x); ++x)
            for (auto row = parts.lower_bound({x, cellOf(lo.y)}); row != parts.upper_bound({x, cellOf(hi.y)}); ++row)
                for (const size_t i : row->second) {
                    // In the outline and in no courtyard.
                    bool isIn = false;
                    for (const Ring& ring : building.rings) isIn = isIn != contains(ring, within[i]);
                    if (isIn) covered += areaOf(buildings[i].rings), replaced[k] = true;
                }
        if (replaced[k] && covered < 0.5 * areaOf(building.rings))
            notes.add("outlines are left out for parts that cover less than half of them");
    }
    size_t kept = 0;
    for (size_t k = 0; k < buildings.size(); ++k)
        if (!replaced[k]) std::swap(buildings[kept++], buildings[k]);
    buildings.resize(kept);
}

/// The polygon as buildings that can stand; several where it is cut in pieces by what it encloses.
void addTidied(const Building& raw, std::vector<Building>& buildings, Footprints& out) {
    Tidied tidy = tidied(raw.rings);
    if (tidy.crosses) out.notes.add("outlines that cross themselves are left out");
    if (tidy.smallParts > 0) out.notes.add("outlines of less than a square metre are left out", "", tidy.smallParts);
    if (tidy.smallHoles > 0) out.notes.add("courtyards of less than a square metre are filled", "", tidy.smallHoles);
    if (tidy.badHoles > 0)
        out.notes.add("courtyards that cross another outline or lie outside are filled", "", tidy.badHoles);
    if (tidy.polygons.empty() && !tidy.crosses && tidy.smallParts == 0)
        out.notes.add("outlines without an area are left out");
    if (tidy.polygons.empty()) ++out.refused;
    for (std::vector<Ring>& rings : tidy.polygons) buildings.push_back({std::move(rings), raw.tags});
}

/// Two outlines with the same middle and area, to 10 cm, are one.
bool isNew(const Building& building, std::set<std::tuple<int64_t, int64_t, int64_t, int64_t, bool>>& seen) {
    glm::dvec2 sum(0);
    for (const glm::dvec2& p : building.rings[0]) sum += p / double(building.rings[0].size());
    const auto key = [](double x) { return int64_t(std::floor(x * 10)); };
    const BuildingTags& tags = building.tags;
    return seen.insert({key(sum.x), key(sum.y), key(areaOf(building.rings)), key(tags.base), tags.isPart}).second;
}

}  // namespace

Footprints parseFootprints(std::string_view json, const std::string& name, bool projected) {
    Footprints out;
    Budget budget(name);
    std::vector<Building> raw;
    const auto keep = [&](std::vector<Ring> rings, const nlohmann::json& properties) {
        size_t corners = 0;
        for (const Ring& ring : rings) corners += ring.size();
        budget.triangles(4 * corners);  // two of a wall, and floor and roof
        budget.time();
        BuildingTags tags = readBuildingTags(properties, out.notes);
        if (tags.stands) raw.push_back({std::move(rings), tags});
    };
    const std::string named = readGeoJson(json, name, keep, out.notes);
    if (raw.empty()) throw base::UsageError(name + ": has no building: no polygon in it");
    std::vector<glm::dvec2*> points;
    for (Building& building : raw)
        for (Ring& ring : building.rings)
            for (glm::dvec2& p : ring) points.push_back(&p);
    const Crs crs = crsOf(named, projected, name);
    if (projected && crs != Crs::metres)
        out.notes.add("projected = true is overruled by the crs that the file names", named);
    projectToPlane(points, crs, name);

    std::vector<Building> buildings;
    std::set<std::tuple<int64_t, int64_t, int64_t, int64_t, bool>> seen;
    for (const Building& building : raw) {
        budget.time();
        const size_t first = buildings.size();
        addTidied(building, buildings, out);
        if (buildings.size() == first || isNew(buildings[first], seen)) continue;
        buildings.resize(first);
        ++out.refused;
        out.notes.add("outlines that are given twice are built once");
    }
    replaceByParts(buildings, out.notes);
    if (buildings.empty())
        throw base::UsageError(name + ": has no building: every polygon crosses itself or is smaller than 1 m²");
    for (Building& building : buildings) {
        out.withoutHeight += !building.tags.knowsHeight;
        out.buildings.push_back({std::move(building.rings), building.tags.height, building.tags.base});
    }
    return out;
}

}  // namespace dapple::scenegen::city
