#include "shadow/instanced/far_field.h"

#include "shadow/families.h"
#include "shadow/map/caster_cull.h"

#include <algorithm>
#include <numeric>

namespace dapple::shadow {
namespace {

/// Area of a convex polygon's part within [0, width] × [0, height] (Sutherland & Hodgman 1974).
double areaOnScreen(std::vector<glm::dvec2> polygon, double width, double height) {
    std::vector<glm::dvec2> clipped;
    for (int side = 0; side < 4; ++side) {
        const int axis = side / 2;
        const double sign = side % 2 == 0 ? 1 : -1, limit = side % 2 == 0 ? 0 : axis == 0 ? width : height;
        const auto inside = [&](const glm::dvec2& p) { return sign * (p[axis] - limit); };
        clipped.clear();
        for (size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
            const double da = inside(a), db = inside(b);
            if (da >= 0) clipped.push_back(a);
            if ((da >= 0) != (db >= 0)) clipped.push_back(a + (b - a) * (da / (da - db)));
        }
        polygon.swap(clipped);
    }
    double twice = 0;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        twice += a.x * b.y - a.y * b.x;
    }
    return std::abs(twice) / 2;
}

}  // namespace

double volumePixels(const frame::Camera& camera, const std::array<glm::dvec3, 8>& corners, const glm::dvec3& light, double swept) {
    std::array<glm::dvec3, 16> points;  // right, up, forward
    for (size_t i = 0; i < 16; ++i) {
        const glm::dvec3 p = corners[i % 8] + (i < 8 ? 0 : swept) * light;
        points[i] = {glm::dot(p, camera.right), glm::dot(p, camera.up), glm::dot(p, camera.forward)};
    }
    std::vector<glm::dvec2> screen;
    const auto project = [&](const glm::dvec3& p) {
        screen.emplace_back((p.x / (p.z * camera.tanX) + 1) * 0.5 * camera.width, (p.y / (p.z * camera.tanY) + 1) * 0.5 * camera.height);
    };
    // The part beyond the near plane is the hull of the points there and of where the segments to the others cross it.
    for (const glm::dvec3& p : points) {
        if (p.z < camera.near) continue;
        project(p);
        for (const glm::dvec3& q : points)
            if (q.z < camera.near) project(p + (q - p) * ((p.z - camera.near) / (p.z - q.z)));
    }
    return areaOnScreen(convexHull(std::move(screen)), camera.width, camera.height);
}

size_t nearestAsVolumes(std::span<const FarCost> costs, double perTriangle, double fixed) {
    double cost = std::accumulate(costs.begin(), costs.end(), fixed, [&](double sum, const FarCost& c) { return sum + perTriangle * c.triangles; });
    size_t best = 0;
    double least = costs.empty() ? 0 : cost;
    for (size_t k = 1; k <= costs.size(); ++k) {
        cost += costs[k - 1].fragments - perTriangle * costs[k - 1].triangles;
        const double total = k == costs.size() ? cost - fixed : cost;
        if (total <= least) best = k, least = total;
    }
    return best;
}

std::vector<bool> cheaperAsVolumes(std::span<const FarCost> costs, double perTriangle, double fixed) {
    double saved = -fixed;
    std::vector<bool> volumes;
    for (const FarCost& c : costs) {
        volumes.push_back(c.fragments <= perTriangle * c.triangles);
        if (!volumes.back()) saved += c.fragments - perTriangle * c.triangles;
    }
    return saved > 0 ? volumes : std::vector<bool>(costs.size(), true);
}

FarField::FarField(frame::Frame& frame, const CasterMaps& maps, const Settings& settings)
    : frame_(frame), maps_(maps), kind_(settings.at("far-field") == "none" ? Kind::none : settings.at("far-field") == "auto" ? Kind::nearest : settings.at("far-field") == "each" ? Kind::each : Kind::distance),
      distance_(kind_ == Kind::distance ? std::stod(settings.at("far-field")) : 0),
      perTriangle_(std::stod(settings.at("far-cost")) / 100) {
    Settings cascaded = shadow::technique("cascaded").defaults;
    for (const char* same : {"camera", "leaf", "batch", "assumed-visible", "bias", "bias-scale", "filter"}) cascaded[same] = settings.at(same);
    technique_ = makeMap(frame, cascaded, [this](uint32_t instance) { return drawn_[instance]; });
}

FarCost FarField::costOf(uint32_t i, const Extrusion& extrusion) const {
    const scenegen::Instance& instance = maps_.items().instance(i);
    const base::Box& box = maps_.types()[size_t(maps_.typeOf(i))].box;
    const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw)), scale = double(instance.scale);
    const glm::dvec3 place = glm::dvec3(instance.translation) - frame_.camera().eye;
    std::array<glm::dvec3, 8> corners;
    for (int k = 0; k < 8; ++k) {
        const glm::dvec3 p(box.corner(k));
        corners[size_t(k)] = place + scale * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
    }
    const double top = place.z + scale * double(box.hi.z);
    const double swept = std::min(extrusion.most, (top - extrusion.floor) / std::max(-frame_.light().z, 1e-6));
    return {volumePixels(frame_.camera(), corners, frame_.light(), swept), double(maps_.items().part(i).triangles)};
}

void FarField::takeFar(std::vector<uint32_t>& casters, const Extrusion& extrusion) {
    const gpuscene::Items& items = maps_.items();
    drawn_.assign(frame_.scene().scene().instances.size(), false);
    any_ = false;
    const auto take = [&](uint32_t i) { drawn_[items[i].instance] = any_ = true; };
    for (uint32_t i = 0; i < items.size(); ++i)
        if (maps_.plan().cascaded[i]) take(i);
    if (kind_ == Kind::none) return;
    std::vector<std::pair<double, uint32_t>> byDistance;
    for (const uint32_t i : casters) byDistance.emplace_back(glm::length(frame_.relative(items.boxes()[i]).centre()), i);
    std::ranges::sort(byDistance);
    std::vector<FarCost> costs;
    if (kind_ != Kind::distance)
        for (const auto& [distance, i] : byDistance) costs.push_back(costOf(i, extrusion));
    const double lookUps = double(frame_.camera().width) * frame_.camera().height;
    std::vector<bool> volumes(casters.size(), false);
    if (kind_ == Kind::each) volumes = cheaperAsVolumes(costs, perTriangle_, lookUps);
    else if (kind_ == Kind::nearest) std::fill_n(volumes.begin(), nearestAsVolumes(costs, perTriangle_, lookUps), true);
    else for (size_t k = 0; k < volumes.size(); ++k) volumes[k] = byDistance[k].first < distance_;
    std::vector<bool> keeps(items.size(), false);
    for (size_t k = 0; k < volumes.size(); ++k)
        if (volumes[k]) keeps[byDistance[k].second] = true;
        else take(byDistance[k].second);
    std::erase_if(casters, [&](uint32_t i) { return !keeps[i]; });
}

}  // namespace dapple::shadow
