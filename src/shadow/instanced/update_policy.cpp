#include "shadow/instanced/update_policy.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

/// Radians that two poses may differ by and be the same: rounding. Over 100 m it moves a shadow by 0.1 µm.
constexpr double kSame = 1e-9;

double turnBetween(double a, double b) { return std::abs(std::remainder(a - b, 2 * std::numbers::pi)); }

bool same(const MapPose& a, const MapPose& b) { return turnBetween(a.yaw, b.yaw) <= kSame && std::abs(a.elevation - b.elevation) <= kSame; }

/// Whether a shadow of the object has moved by more than a texel: its top, H above the ground, darkens the ground at H cot e
/// from below itself, so that the elevation moves the shadow by H Δe / sin² e and a turn by H cot e Δφ.
bool beyondOneTexel(const UpdatePolicy::Map& map, const MapPose& shown) {
    const double e = map.wanted.elevation, sine = std::sin(e), h = std::max(map.height, 1e-9);
    return std::abs(e - shown.elevation) > map.texel * sine * sine / h || turnBetween(map.wanted.yaw, shown.yaw) > map.texel * std::tan(e) / h;
}

}  // namespace

glm::dvec3 SunAngles::light() const {
    return {std::cos(elevation) * std::cos(heading), std::cos(elevation) * std::sin(heading), -std::sin(elevation)};
}

LightBasis SunAngles::basis() const {
    const glm::dvec2 d(std::cos(heading), std::sin(heading));
    const double c = std::cos(elevation), s = std::sin(elevation);
    return {{d.y, -d.x, 0}, {s * d.x, s * d.y, c}, light()};
}

SunAngles sunAngles(const glm::dvec3& light) {
    const double across = std::hypot(light.x, light.y);
    return {across == 0 ? std::numbers::pi / 2 : std::atan2(light.y, light.x), std::atan2(-light.z, across)};
}

double lagOf(const MapPose& shown, const MapPose& wanted) {
    const glm::dvec3 a = SunAngles{shown.yaw, shown.elevation}.light(), b = SunAngles{wanted.yaw, wanted.elevation}.light();
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

UpdatePolicy::UpdatePolicy(const Settings& settings) : budget_(size_t(std::stoi(settings.at("budget")))) {
    const std::string& update = settings.at("update");
    kind_ = update == "regenerate"  ? Kind::regenerate
            : update == "moving"    ? Kind::moving
            : update == "criterion" ? Kind::criterion
            : update == "round-robin" ? Kind::roundRobin
                                    : Kind::cached;
}

void UpdatePolicy::forget(int map) {
    if (size_t(map) < states_.size()) states_[size_t(map)].known = false;
}

bool UpdatePolicy::isOutdated(const Map& map, const State& state) const {
    const bool shapeCounts = kind_ != Kind::cached;  // cached holds shapes still
    return !state.known || (shapeCounts && map.moves) || !same(state.shown, map.wanted);
}

bool UpdatePolicy::outdated(std::span<const Map> maps) const {
    if (kind_ == Kind::regenerate || states_.size() != maps.size()) return true;
    for (size_t i = 0; i < maps.size(); ++i)
        if (isOutdated(maps[i], states_[i])) return true;
    return false;
}

std::vector<int> UpdatePolicy::renderAll(std::span<const Map> maps) {
    states_.resize(maps.size());
    queue_.clear();
    std::vector<int> all;
    for (size_t i = 0; i < maps.size(); ++i) {
        states_[i] = {maps[i].wanted, true, 0};
        all.push_back(int(i));
    }
    return all;
}

/// A round visits every map that is outdated as it begins, those of the most-used types first, so that none starves.
std::vector<int> UpdatePolicy::queued(std::span<const Map> maps, std::span<const uint32_t> uses) {
    std::vector<int> taken;
    for (int round = 0; round < 2 && taken.size() < budget_; ++round) {
        while (!queue_.empty() && taken.size() < budget_) {
            const int i = queue_.back();
            queue_.pop_back();
            if (isOutdated(maps[size_t(i)], states_[size_t(i)])) taken.push_back(i);
        }
        if (round == 1 || taken.size() == budget_) break;
        for (int i = int(maps.size()) - 1; i >= 0; --i)
            if (isOutdated(maps[size_t(i)], states_[size_t(i)]) && std::ranges::find(taken, i) == taken.end()) queue_.push_back(i);
        const auto usesOf = [&](int i) { return maps[size_t(i)].type < uses.size() ? uses[maps[size_t(i)].type] : 0u; };
        std::ranges::stable_sort(queue_, [&](int a, int b) { return usesOf(a) < usesOf(b); });
    }
    return taken;
}

std::vector<int> UpdatePolicy::due(std::span<const Map> maps, std::span<const uint32_t> uses) {
    states_.resize(maps.size());
    std::vector<int> rendered;
    if (kind_ == Kind::roundRobin) rendered = queued(maps, uses);
    std::vector<bool> chosen(maps.size(), false);
    for (const int i : rendered) chosen[size_t(i)] = true;
    for (size_t i = 0; i < maps.size(); ++i) {
        const Map& map = maps[i];
        State& state = states_[i];
        const bool must = !state.known || kind_ == Kind::regenerate ||
                          (kind_ == Kind::criterion ? map.moves || beyondOneTexel(map, state.shown) : kind_ != Kind::roundRobin && isOutdated(map, state));
        if (must && !chosen[i]) rendered.push_back(int(i));
        if (must || chosen[i]) state = {map.wanted, true, 0};
        else state.age = isOutdated(map, state) ? state.age + 1 : 0;
    }
    std::ranges::sort(rendered);
    return rendered;
}

Staleness UpdatePolicy::staleness(std::span<const Map> maps, const std::vector<bool>& used) const {
    Staleness s;
    size_t count = 0;
    for (size_t i = 0; i < std::min(maps.size(), states_.size()); ++i) {
        if (i >= used.size() || !used[i]) continue;
        ++count;
        const double degrees = glm::degrees(lagOf(states_[i].shown, maps[i].wanted)), frames = double(states_[i].age);
        s.meanFrames += frames;
        s.meanDegrees += degrees;
        s.worstFrames = std::max(s.worstFrames, frames);
        s.worstDegrees = std::max(s.worstDegrees, degrees);
    }
    if (count > 0) s.meanFrames /= double(count), s.meanDegrees /= double(count);
    return s;
}

}  // namespace dapple::shadow
