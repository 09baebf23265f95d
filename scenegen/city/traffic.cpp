#include "scenegen/city/traffic.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace dapple::scenegen::city {
namespace {

constexpr uint64_t kTrafficPurpose = 0x74726166666963;
constexpr double kShortest = 30;      // metres of straight way
constexpr double kWidestTurn = 4.8;   // metres, of a car's middle: a small car's turning circle is 10 m
constexpr double kClearance = 0.12;   // metres

/// What cars must not touch: land within kerbs, and the places along them where cars park.
struct Obstacle {
    Region region;
    glm::dvec2 lo{1e300}, hi{-1e300};

    explicit Obstacle(Region r) : region(std::move(r)) {
        for (const glm::dvec2& p : region.corners) lo = glm::min(lo, p), hi = glm::max(hi, p);
    }
    bool isNear(const glm::dvec2& p, double reach) const { return glm::all(glm::lessThan(lo - reach, p)) && glm::all(glm::lessThan(p, hi + reach)); }
};

std::vector<Obstacle> obstaclesOf(const Plan& plan) {
    std::vector<Obstacle> obstacles;
    for (const Block& block : plan.blocks) {
        obstacles.emplace_back(block.kerb);
        for (size_t i = 0; i < block.kerb.size(); ++i) {
            const Line kerb = block.kerb.edge(i);
            const double begin = kParkingMargin - kCarHalfLength - 0.1, end = block.kerb.length(i) - kParkingMargin + kCarHalfLength + 0.8;
            if (end <= begin) continue;
            const auto at = [&](double along, double left) { return kerb.point + along * kerb.direction + left * kerb.left(); };
            obstacles.emplace_back(Region{{at(begin, -kParkedReach), at(end, -kParkedReach), at(end, 0), at(begin, 0)}, {0, 0, 0, 0}});
        }
    }
    return obstacles;
}

bool touches(const Motion::Pose& car, const std::vector<const Obstacle*>& obstacles) {
    const base::det::SinCos yaw = base::det::sinCos(double(car.yaw));
    const glm::dvec2 u(yaw.cos, yaw.sin), v(-yaw.sin, yaw.cos), centre(car.translation);
    for (const double x : {-1.0, -0.5, 0.0, 0.5, 1.0})
        for (const double y : {-1.0, 1.0}) {
            const glm::dvec2 p = centre + x * kCarHalfLength * u + y * kCarHalfWidth * v;
            for (const Obstacle* o : obstacles)
                if (o->isNear(p, kClearance) && o->region.contains(p, -kClearance)) return true;
        }
    return false;
}

/// Of a way along `lane` up to `to` at most: where a turn as wide as the motion's may begin, metres along the lane.
std::optional<double> turnAt(Motion turning, const Line& lane, double to, const std::vector<Obstacle>& obstacles) {
    const double corner = std::sqrt((double(turning.radius) + kCarHalfWidth) * (double(turning.radius) + kCarHalfWidth) + kCarHalfLength * kCarHalfLength);
    const double first = to + kCarHalfLength - corner - turning.turnBeyond();
    turning.speed = 1, turning.start = 1;
    for (double x = first; x > first - 20; x -= 0.5) {
        const glm::dvec2 from = lane.point + (x - 1) * lane.direction, end = lane.point + x * lane.direction;
        turning.from = glm::vec3(glm::vec2(from), 0), turning.to = glm::vec3(glm::vec2(end), 0);
        std::vector<const Obstacle*> near;
        for (const Obstacle& o : obstacles)
            if (o.isNear(end, 3 * kWidestTurn + corner)) near.push_back(&o);
        bool clear = true;
        for (double s = 0; clear && s < turning.turn(); s += 0.3) clear = !touches(turning.at(s), near);
        if (clear) return x;
    }
    return std::nullopt;
}

/// Trims the lane where kerbs, or cars parked along them, stand in its way: only streets' ends have any.
void trim(double& from, double& to, const Line& middle, const Plan& plan) {
    const double half = kCarHalfWidth + kParkedReach, ahead = kCarHalfLength + kParkedReach, centre = 0.5 * (from + to);
    for (const Block& block : plan.blocks) {
        Region inWay = clip(block.kerb, middle.moved(-half), 0);
        if (!inWay.empty()) inWay = clip(inWay, middle.moved(half).reversed(), 0);
        if (inWay.empty()) continue;
        double lo = 1e300, hi = -1e300;
        for (const glm::dvec2& p : inWay.corners) lo = std::min(lo, middle.along(p)), hi = std::max(hi, middle.along(p));
        if (0.5 * (lo + hi) < centre) from = std::max(from, hi + ahead);
        else to = std::min(to, lo - ahead);
    }
}

}  // namespace

int lanesEachWay(const Street& street) { return 0.5 * street.width - kParkedReach - kMiddle - kCarHalfWidth < kLaneWidth ? 1 : 2; }

std::vector<Motion> loopsOf(const Plan& plan) {
    const std::vector<Obstacle> obstacles = obstaclesOf(plan);
    std::vector<Motion> loops;
    for (const Street& s : plan.streets) {
        const double length = glm::distance(s.a, s.b);
        const int count = lanesEachWay(s);
        for (int i = 0; i < count; ++i) {
            const double side = kMiddle + i * kLaneWidth;
            // A car's outer corner keeps to the street, and to the right of the second lane's cars.
            const double limit = i + 1 < count ? side + kLaneWidth - kCarHalfWidth : 0.5 * s.width - 0.3;
            const double radius = std::min(kWidestTurn, std::sqrt(limit * limit - kCarHalfLength * kCarHalfLength) - kCarHalfWidth);
            Motion loop{.speed = float(8 + 6 * std::clamp((s.width - 10.5) / 23.5, 0.0, 1.0)), .across = float(2 * side)};
            loop.radius = std::max(float(radius), 0.5f * loop.across);
            // Both lanes as seen by who drives there: back from b, and on from a.
            std::optional<double> ends[2];
            Line lanes[2];
            for (const bool back : {false, true}) {
                lanes[back] = Line{back ? s.b : s.a, ((back ? s.a : s.b) - (back ? s.b : s.a)) / length}.moved(-side);
                double from = kCarHalfLength, to = length - kCarHalfLength, unused = from, opposite = to;
                trim(from, to, lanes[back], plan);
                trim(unused, opposite, lanes[back].moved(2 * side), plan);
                ends[back] = turnAt(loop, lanes[back], std::min(to, opposite), obstacles);
            }
            if (!ends[0] || !ends[1] || *ends[0] + *ends[1] - length < kShortest) continue;
            loop.from = glm::vec3(glm::vec2(lanes[0].point + (length - *ends[1]) * lanes[0].direction), 0);
            loop.to = glm::vec3(glm::vec2(lanes[0].point + *ends[0] * lanes[0].direction), 0);
            loops.push_back(loop);
        }
    }
    return loops;
}

void addTraffic(Scene& scene, const Plan& plan, std::span<const uint32_t> cars, double perKm, uint64_t seed) {
    if (perKm <= 0) return;
    uint64_t number = 0;
    for (Motion loop : loopsOf(plan)) {
        base::Random random(seed, number++, kTrafficPurpose);
        const double lap = loop.lap();
        const int count = int(std::min(lap * perKm / 1000 + random.next(), lap / kHeadway));
        for (int i = 0; i < count; ++i) {
            const double spacing = lap / count;
            loop.start = float(i * spacing + (spacing - kHeadway) * random.next());
            loop.instance = uint32_t(scene.instances.size());
            const Motion::Pose pose = loop.at(0);
            scene.motions.push_back(loop);
            scene.instances.push_back({.translation = pose.translation, .yaw = pose.yaw, .prototype = cars[size_t(random.next() * float(cars.size()))]});
        }
    }
}

}  // namespace dapple::scenegen::city
