#include "shadow/instanced/map_plan.h"

#include "base/error.h"
#include "shadow/instanced/map_atlas.h"
#include "shadow/instanced/resolution.h"
#include "shadow/instanced/volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

namespace dapple::shadow {
namespace {

constexpr size_t kTexelBytes = 4;  ///< D32F
constexpr double kMiB = 1 << 20;

size_t bytesOf(std::span<const int> sides, const MapBounds& bounds) { return pagesFor(sides, bounds.maxSide, bounds.maxPages).texels() * kTexelBytes; }

bool fits(std::span<const int> sides, const MapBounds& bounds) {
    const auto pages = pagesWithin(sides, bounds.maxSide, bounds.maxPages);
    return pages && pages->texels() * kTexelBytes <= bounds.bytes;
}

class Planner {
public:
    Planner(const gpuscene::Items& items, const std::vector<bool>& exact, const Settings& settings, const MapBounds& bounds, double sunTurn,
            const std::function<CasterView()>& view)
        : items_(items), settings_(settings), bounds_(bounds), sunTurn_(sunTurn), view_(view), estimated_(is("resolution", "estimate")), size_(number("size")), least_(std::min(estimated_ ? SizeChooser::kLeast : kLeastSide, int(std::bit_floor(unsigned(size_))))),
          kept_(items.size()), moves_(items.scene().instances.size(), false) {
        for (const scenegen::Motion& motion : items.scene().motions) moves_[motion.instance] = true;
        for (uint32_t i = 0; i < items.size(); ++i)
            kept_[i] = items.part(i).castsShadow && items.part(i).triangles > 0 && !exact[items.part(i).prototype];
        plan_.cascaded.resize(items.size(), false);
    }

    MapPlan plan() {
        sendTooLarge();
        layOut();
        plan_.wantedBytes = wantedBytes();
        if (!fits(plan_.sides, bounds_)) {
            omitOutOfReach();
            if (const std::vector<int> sides = sidesWithin(plan_.sides, plan_.extents, bounds_); !sides.empty()) shrink(sides);
            else sendWhatDoesNotFit();
        }
        plan_.bytes = bytesOf(plan_.sides, bounds_);
        plan_.note = fmt::format("{}", fmt::join(notes_, "; "));
        return std::move(plan_);
    }

private:
    bool is(const char* axis, const char* value) const { return settings_.at(axis) == value; }
    int number(const char* axis) const { return std::stoi(settings_.at(axis)); }
    double yawOf(uint32_t item) const { return double(items_.instance(item).yaw); }
    double extentOf(uint32_t item) const { return double(items_.instance(item).scale) * glm::length(glm::dvec3(items_.part(item).box.size())); }
    const CasterView& view() {
        if (seen_.looks.empty()) seen_ = view_();
        return seen_;
    }
    /// The far field draws any caster but these.
    bool hasFarField() const {
        return !is("apply", "tiled") && !is("apply", "all") && !is("accumulate", "stencil") &&
               std::ranges::none_of(items_.scene().prototypes, [](const scenegen::Prototype& p) { return p.castsShadow && p.transmittance > 0; });
    }
    size_t kept() const { return size_t(std::ranges::count(kept_, true)); }

    void sendTooLarge() {
        if (!hasFarField()) return;
        base::Box all;
        for (const base::Box& box : items_.boxes()) all.extend(box);
        const double scene = glm::length(glm::dvec3(all.size()));
        size_t sent = 0;
        for (uint32_t i = 0; i < items_.size(); ++i) {
            if (!kept_[i] || !tooLarge(extentOf(i), size_, scene)) continue;
            kept_[i] = false;
            plan_.cascaded[i] = true;
            ++sent;
        }
        if (sent > 0) notes_.push_back(fmt::format("instanced → cascaded for {} of {} casters: a map of {}² over one is coarser than one of {}² over the scene", sent, sent + kept(), size_, kSceneMap));
    }

    /// Types, maps and sides of the casters that are kept.
    void layOut() {
        plan_.types.clear();
        plan_.sharedTypeOf.assign(items_.size(), -1);
        plan_.extents.clear();
        std::vector<int> ofPart(items_.parts().size(), -1);
        std::vector<std::vector<uint32_t>> members;
        std::vector<uint32_t> casting;
        for (uint32_t i = 0; i < items_.size(); ++i) {
            if (!kept_[i]) continue;
            casting.push_back(i);
            int& known = ofPart[items_[i].part];
            if (known < 0) {
                known = int(members.size());
                members.emplace_back();
            }
            members[size_t(known)].push_back(i);
            plan_.sharedTypeOf[i] = known;
        }
        const bool allOwn = is("mode", "exact");
        if (!allOwn)
            for (const auto& casters : members) addShared(casters);
        plan_.firstOwn = plan_.types.size();
        const std::vector<uint32_t> owners = allOwn ? casting : ownersOf(items_, plan_.types, plan_.sharedTypeOf, size_t(number("own")), sunTurn_, [this]() -> const CasterView& { return view(); });
        for (const uint32_t i : owners) addType(ownType(items_, i), extentOf(i));
        plan_.sides.assign(plan_.extents.size(), estimated_ ? least_ : size_);
    }

    void addType(CasterType type, double extent) {
        type.firstMap = int(plan_.extents.size());
        plan_.extents.resize(plan_.extents.size() + type.angles.size(), extent);
        plan_.types.push_back(std::move(type));
    }

    void addShared(const std::vector<uint32_t>& casters) {
        CasterType type = ownType(items_, casters[0]);
        type.alone = casters.size() == 1;
        const int rotations = number("rotations");
        double extent = 0;
        for (const uint32_t i : casters) {
            extent = std::max(extent, extentOf(i));
            type.ring |= !type.alone && moves_[items_[i].instance];  // a yaw that changes has no map of its own
            if (type.ring) continue;
            if (std::ranges::any_of(type.angles, [&](double known) { return sameYaw(known, yawOf(i)); })) continue;
            type.angles.push_back(yawOf(i));
            type.ring = int(type.angles.size()) > rotations;
        }
        if (type.ring) {
            type.angles.clear();
            for (int r = 0; r < rotations; ++r) type.angles.push_back(2 * std::numbers::pi * r / rotations);
        }
        addType(std::move(type), extent);
    }

    size_t wantedBytes() const {
        const std::vector<int> all(plan_.sides.size(), size_);
        return std::accumulate(all.begin(), all.end(), size_t(0), [](size_t sum, int s) { return sum + size_t(s) * size_t(s) * kTexelBytes; });
    }

    void omitOutOfReach() {
        plan_.byView = true;
        const size_t before = kept(), maps = plan_.sides.size();
        for (uint32_t i = 0; i < items_.size(); ++i) kept_[i] = kept_[i] && view().inReach[i];
        layOut();
        notes_.push_back(fmt::format("{} maps of {}² take {:.0f} MiB, memory allows {:.0f}: {} of {} casters cannot reach this view and have none", maps, size_,
                                     double(plan_.wantedBytes) / kMiB, double(bounds_.bytes) / kMiB, before - kept(), before));
    }

    void shrink(const std::vector<int>& sides) {
        if (sides == plan_.sides) return;
        plan_.sides = sides;
        notes_.push_back(fmt::format("the {} maps left have {} to {} texels a side, as the casters' extents are", sides.size(), *std::ranges::min_element(sides), *std::ranges::max_element(sides)));
    }

    /// The types that look smallest, until maps of the least side fit for the others.
    void sendWhatDoesNotFit() {
        if (!hasFarField())
            throw base::Error(base::ExitCode::failed, fmt::format("{} instanced maps of {}² are more than {:.0f} MiB or this GL hold, and these settings have no far field to take casters: "
                                                                  "more memory, fewer rotations or own maps, apply zpass", plan_.sides.size(), least_, double(bounds_.bytes) / kMiB));
        std::vector<double> looks(plan_.types.size(), 0);
        std::vector<int> typeOf = plan_.sharedTypeOf;
        for (size_t t = plan_.firstOwn; t < plan_.types.size(); ++t)
            if (plan_.firstOwn == 0) typeOf[plan_.types[t].item] = int(t);
        for (uint32_t i = 0; i < items_.size(); ++i)
            if (typeOf[i] >= 0) looks[size_t(typeOf[i])] = std::max(looks[size_t(typeOf[i])], view().looks[i]);
        std::vector<size_t> order(plan_.firstOwn == 0 ? plan_.types.size() : plan_.firstOwn);
        std::iota(order.begin(), order.end(), size_t(0));
        std::ranges::stable_sort(order, [&](size_t a, size_t b) { return looks[a] > looks[b]; });
        std::vector<int> sides(plan_.firstOwn == 0 ? 0 : plan_.types.size() - plan_.firstOwn, least_);  // the own maps
        std::vector<bool> sent(plan_.types.size(), true);
        for (const size_t t : order) {
            sides.resize(sides.size() + plan_.types[t].angles.size(), least_);
            if (!fits(sides, bounds_)) break;
            sent[t] = false;
        }
        const size_t before = kept();
        for (uint32_t i = 0; i < items_.size(); ++i)
            if (typeOf[i] >= 0 && sent[size_t(typeOf[i])]) kept_[i] = false, plan_.cascaded[i] = true;
        layOut();
        shrink(sidesWithin(plan_.sides, plan_.extents, bounds_));
        notes_.push_back(fmt::format("instanced → cascaded for {} of {} casters in reach: their maps do not fit", before - kept(), before));
    }

    const gpuscene::Items& items_;
    const Settings& settings_;
    const MapBounds& bounds_;
    double sunTurn_;
    const std::function<CasterView()>& view_;
    CasterView seen_;
    bool estimated_;           ///< sides begin at the least, and follow what is asked for
    int size_, least_;
    std::vector<bool> kept_;   ///< by item: gets maps
    std::vector<bool> moves_;  ///< by instance
    MapPlan plan_;
    std::vector<std::string> notes_;
};

}  // namespace

bool sameYaw(double yaw, double other) { return std::abs(std::remainder(yaw - other, 2 * std::numbers::pi)) <= 1e-5; }

CasterType ownType(const gpuscene::Items& items, uint32_t item) {
    CasterType type;
    type.part = items[item].part;
    type.item = item;
    type.alone = true;
    type.angles = {double(items.instance(item).yaw)};
    return type;
}

bool needsOwnMap(const CasterType& shared, double yaw) { return shared.ring && sampleRotation(yaw, int(shared.angles.size())).weight != 0; }

std::vector<uint32_t> ownersOf(const gpuscene::Items& items, std::span<const CasterType> types, std::span<const int> sharedTypeOf, size_t most, double sunTurn,
                               const std::function<const CasterView&()>& view) {
    std::vector<uint32_t> turned;
    for (uint32_t i = 0; most > 0 && i < items.size(); ++i)
        if (sharedTypeOf[i] >= 0 && needsOwnMap(types[size_t(sharedTypeOf[i])], double(items.instance(i).yaw) - sunTurn)) turned.push_back(i);
    if (turned.empty()) return turned;
    const std::vector<double>& looks = view().looks;
    const size_t count = std::min(most, turned.size());
    std::ranges::partial_sort(turned, turned.begin() + std::ptrdiff_t(count), [&](uint32_t a, uint32_t b) { return looks[a] != looks[b] ? looks[a] > looks[b] : a < b; });
    turned.resize(count);
    return turned;
}

bool tooLarge(double extent, int side, double sceneExtent) { return extent * kSceneMap > sceneExtent * std::max(side, 512); }

std::vector<int> sidesWithin(std::span<const int> wishes, std::span<const double> extents, const MapBounds& bounds) {
    std::vector<int> sides(wishes.begin(), wishes.end());
    if (fits(sides, bounds)) return sides;
    // The pitch grows by steps until the maps fit. Half a power of two a step: not all maps of a kind shrink at once.
    double pitch = 1e300;
    for (size_t i = 0; i < sides.size(); ++i) pitch = std::min(pitch, extents[i] / wishes[i]);
    for (bool shrunk = true; shrunk; pitch *= std::numbers::sqrt2) {
        shrunk = false;
        for (size_t i = 0; i < sides.size(); ++i) {
            const int whole = int(std::bit_floor(unsigned(wishes[i]))), least = std::min(kLeastSide, whole);
            const double most = std::max(extents[i] / pitch, 1.0);
            sides[i] = most >= whole ? whole : std::max(least, int(std::bit_floor(unsigned(most))));
            shrunk |= sides[i] > least;
        }
        if (fits(sides, bounds)) return sides;
    }
    return {};
}

MapPlan planMaps(const gpuscene::Items& items, const std::vector<bool>& exact, const Settings& settings, const MapBounds& bounds, double sunTurn,
                 const std::function<CasterView()>& view) {
    return Planner(items, exact, settings, bounds, sunTurn, view).plan();
}

}  // namespace dapple::shadow
