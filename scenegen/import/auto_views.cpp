#include "scenegen/import/auto_views.h"

#include "scenegen/views/pick_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace dapple::scenegen {
namespace {

constexpr double kEye = 1.7;       ///< metres above the ground
constexpr int kMaxCells = 1024;    ///< per side of the height field
constexpr int kHeadings = 16;
constexpr size_t kGroundViews = 4;
constexpr size_t kMostCandidates = 384;  ///< quick pictures taken
constexpr float kNone = std::numeric_limits<float>::max();

/// Calls f(a, b, c, closed) with every triangle, metres from Scene::origin, and whether its mesh is closed and so has an outside.
template <class F>
void forEachTriangle(const Scene& scene, F f) {
    for (const Instance& instance : scene.instances) {
        const float c = std::cos(instance.yaw) * instance.scale, s = std::sin(instance.yaw) * instance.scale;
        const auto place = [&](const glm::vec3& p) {
            return instance.translation + glm::vec3(c * p.x - s * p.y, s * p.x + c * p.y, instance.scale * p.z);
        };
        for (const Mesh& mesh : scene.prototypes[instance.prototype].meshes)
            for (size_t i = 0; i < mesh.indices.size(); i += 3)
                f(place(mesh.positions[mesh.indices[i]]), place(mesh.positions[mesh.indices[i + 1]]), place(mesh.positions[mesh.indices[i + 2]]),
                  scene.prototypes[instance.prototype].closed);
    }
}

/// Lowest upward-facing height and highest height of anything, per square cell of the ground plane.
class HeightField {
public:
    explicit HeightField(const Scene& scene) : box_(scene.facts().box) {
        const float side = std::max(box_.size().x, box_.size().y);
        cell_ = std::max(1.0f, side / float(kMaxCells - 1));
        nx_ = int(box_.size().x / cell_) + 1;
        ny_ = int(box_.size().y / cell_) + 1;
        ground_.assign(size_t(nx_) * size_t(ny_), kNone);
        top_.assign(ground_.size(), -kNone);
        forEachTriangle(scene, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, bool closed) { add(a, b, c, closed); });
    }

    int nx() const { return nx_; }
    int ny() const { return ny_; }
    float cell() const { return cell_; }
    const base::Box& box() const { return box_; }
    bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < nx_ && y < ny_; }
    float ground(int x, int y) const { return ground_[index(x, y)]; }
    /// Height of what stands on the ground; 0 where there is none.
    float obstacle(int x, int y) const { return ground(x, y) == kNone ? 0 : std::max(0.0f, top_[index(x, y)] - ground(x, y)); }
    glm::vec2 centre(int x, int y) const { return glm::vec2(box_.lo) + cell_ * glm::vec2(float(x) + 0.5f, float(y) + 0.5f); }

private:
    size_t index(int x, int y) const { return size_t(y) * size_t(nx_) + size_t(x); }

    void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, bool closed) {
        const glm::vec3 n = glm::cross(b - a, c - a);
        // Either side up, for foreign files are careless; but a slab's underside is no ground.
        const bool flat = (closed ? n.z : std::abs(n.z)) > 0.7f * glm::length(n);
        // Samples no farther apart than a cell, corners included: walls and poles leave no gap.
        const float longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
        const int steps = 1 + int(std::min(longest / cell_, float(4 * kMaxCells - 1)));
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; j <= steps - i; ++j) {
                const float u = float(i) / float(steps), v = float(j) / float(steps);
                const glm::vec3 p = a + u * (b - a) + v * (c - a);
                const int x = std::clamp(int((p.x - box_.lo.x) / cell_), 0, nx_ - 1);
                const int y = std::clamp(int((p.y - box_.lo.y) / cell_), 0, ny_ - 1);
                top_[index(x, y)] = std::max(top_[index(x, y)], p.z);
                if (flat) ground_[index(x, y)] = std::min(ground_[index(x, y)], p.z);
            }
    }

    base::Box box_;
    float cell_ = 1;
    int nx_ = 1, ny_ = 1;
    std::vector<float> ground_, top_;
};

struct Spot {
    int x, y;
    double heading, score;  ///< heading: radians, counter-clockwise from +x
};

/// Open sky and even ground in a 5×5 neighbourhood.
bool isFree(const HeightField& field, int x, int y) {
    for (int dy = -2; dy <= 2; ++dy)
        for (int dx = -2; dx <= 2; ++dx) {
            if (!field.inside(x + dx, y + dy) || field.ground(x + dx, y + dy) == kNone) return false;
            const float step = field.ground(x + dx, y + dy) - field.ground(x, y);
            if (field.obstacle(x + dx, y + dy) > 0.5f || std::abs(step) > 0.5f * field.cell() * 3) return false;
        }
    return true;
}

/// How much stands in sight along `heading`: a fan of rays over the height field, things weighed by the
/// angle they fill. Nothing may stand within 8 m; what the eye cannot see over hides what is behind it.
double sight(const HeightField& field, int x, int y, double heading) {
    constexpr int kRays = 7;
    const double reach = std::min(250.0, 0.7 * double(std::max(field.box().size().x, field.box().size().y)));
    const double clear = std::min(8.0, 0.2 * reach);
    const double eye = double(field.ground(x, y)) + kEye;
    double score = 0;
    for (int r = 0; r < kRays; ++r) {
        const double angle = heading + glm::radians(8.0 * (r - kRays / 2));
        double horizon = -0.5;  // slope: what lies lower on the screen is the foreground
        for (double d = double(field.cell()); d < reach; d += double(field.cell())) {
            const int cx = x + int(std::lround(std::cos(angle) * d / double(field.cell())));
            const int cy = y + int(std::lround(std::sin(angle) * d / double(field.cell())));
            if (!field.inside(cx, cy) || field.ground(cx, cy) == kNone) break;
            const double obstacle = double(field.obstacle(cx, cy));
            const double slope = (double(field.ground(cx, cy)) + obstacle - eye) / d;
            if (d < clear && obstacle > 0.5) return 0;
            if (slope <= horizon) continue;
            // Full marks up to 0.4 (half of a 45° half-field): a wall that fills the picture earns no more.
            if (obstacle > 1) score += std::min(slope, 0.4) - std::min(horizon, 0.4) + 0.01;
            horizon = slope;
        }
    }
    return score;
}

std::vector<Spot> rankedSpots(const HeightField& field) {
    std::vector<Spot> spots;
    const int stride = std::max(2, std::max(field.nx(), field.ny()) / 64);
    for (int y = 2; y < field.ny() - 2; y += stride)
        for (int x = 2; x < field.nx() - 2; x += stride) {
            if (!isFree(field, x, y)) continue;
            std::array<Spot, kHeadings> all;
            for (int h = 0; h < kHeadings; ++h) {
                const double heading = 2 * glm::pi<double>() * h / kHeadings;
                all[size_t(h)] = {x, y, heading, sight(field, x, y, heading)};
            }
            std::ranges::stable_sort(all, [](const Spot& a, const Spot& b) { return a.score > b.score; });
            for (int h = 0; h < 3 && all[size_t(h)].score > 0; ++h) spots.push_back(all[size_t(h)]);
        }
    std::ranges::stable_sort(spots, [](const Spot& a, const Spot& b) { return a.score > b.score; });
    return spots;
}

View lookAt(std::string name, const glm::dvec3& eye, const glm::dvec3& target, const base::Box& box) {
    View view;
    view.name = std::move(name);
    view.eye = eye;
    view.forward = glm::normalize(target - eye);
    view.far = chooseFar(box, eye, view.near);
    return view;
}

/// From the best spots of each part of the ground, along the three best headings of each, so that the pictures decide.
std::vector<View> candidates(const HeightField& field, const std::vector<Spot>& spots, size_t most) {
    constexpr int kParts = 8;  // a side
    std::map<std::pair<int, int>, size_t> perPart;
    std::vector<View> views;
    for (const Spot& spot : spots) {
        size_t& taken = perPart[{spot.x * kParts / field.nx(), spot.y * kParts / field.ny()}];
        if (views.size() >= most || taken++ >= std::max<size_t>(2, most / (kParts * kParts))) continue;
        const glm::dvec3 eye(glm::dvec2(field.centre(spot.x, spot.y)), double(field.ground(spot.x, spot.y)) + kEye);
        const glm::dvec3 ahead(std::cos(spot.heading), std::sin(spot.heading), 0.03);
        views.push_back(lookAt("", eye, eye + ahead, field.box()));
    }
    return views;
}

}  // namespace

double chooseFar(const base::Box& box, const glm::dvec3& eye, double near) {
    double far = 10 * near;
    for (int i = 0; i < 8 && !box.empty(); ++i) far = std::max(far, glm::distance(eye, glm::dvec3(box.corner(i))));
    return std::ceil(1.01 * far);
}

std::vector<View> chooseViews(const Scene& scene) {
    const HeightField field(scene);
    const base::Box& box = field.box();
    std::vector<View> views = pickViews(scene, candidates(field, rankedSpots(field), kMostCandidates), kGroundViews);
    for (size_t i = 0; i < views.size(); ++i) views[i].name = fmt::format("auto{}", i);
    // Too small or too crowded to stand in: around it, at the foot of the box.
    const glm::dvec3 centre(box.centre());
    const double radius = std::max(0.5, glm::length(glm::dvec3(box.halfSize())));
    for (size_t k = 0; views.size() < 3; ++k) {
        const double angle = glm::radians(-60.0 + 120.0 * double(k));
        const glm::dvec3 eye(centre.x + 2 * radius * std::cos(angle), centre.y + 2 * radius * std::sin(angle), double(box.lo.z) + kEye);
        views.push_back(lookAt(fmt::format("auto{}", views.size()), eye, centre, box));
    }
    views.push_back(lookAt("above", centre + radius * glm::dvec3(0, -1.3, 1.3), centre, box));
    return views;
}

}  // namespace dapple::scenegen
