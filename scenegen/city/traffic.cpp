#include "scenegen/city/traffic.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr uint64_t kTrafficPurpose = 0x74726166666963;
constexpr double kShortest = 30;

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

std::vector<Lane> lanesOf(const Plan& plan) {
    std::vector<Lane> lanes;
    for (const Street& s : plan.streets) {
        const double length = glm::distance(s.a, s.b);
        const int count = lanesEachWay(s);
        for (const bool back : {false, true})
            for (int i = 0; i < count; ++i) {
                const glm::dvec2 start = back ? s.b : s.a;
                const Line middle = Line{start, ((back ? s.a : s.b) - start) / length}.moved(-(kMiddle + i * kLaneWidth));
                double from = kCarHalfLength, to = length - kCarHalfLength;
                trim(from, to, middle, plan);
                if (to - from < kShortest) continue;
                lanes.push_back({middle.point + from * middle.direction, middle.point + to * middle.direction, 8 + 6 * std::clamp((s.width - 10.5) / 23.5, 0.0, 1.0)});
            }
    }
    return lanes;
}

void addTraffic(Scene& scene, const Plan& plan, std::span<const uint32_t> cars, double perKm, uint64_t seed) {
    uint64_t number = 0;
    for (const Lane& lane : lanesOf(plan)) {
        base::Random random(seed, number++, kTrafficPurpose);
        const double length = glm::distance(lane.from, lane.to);
        const int count = int(std::min(length * perKm / 1000 + random.next(), length / kHeadway));
        for (int i = 0; i < count; ++i) {
            const double spacing = length / count, start = i * spacing + (spacing - kHeadway) * random.next();
            const auto car = size_t(random.next() * float(cars.size()));
            scene.motions.push_back({uint32_t(scene.instances.size()), glm::vec3(lane.from.x, lane.from.y, 0), glm::vec3(lane.to.x, lane.to.y, 0), float(lane.speed), float(start)});
            scene.instances.push_back({.translation = scene.motions.back().at(0), .yaw = float(angleOf((lane.to - lane.from) / length)), .prototype = cars[car]});
        }
    }
}

}  // namespace dapple::scenegen::city
