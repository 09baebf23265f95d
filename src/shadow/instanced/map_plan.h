#pragma once

#include "gpuscene/items.h"
#include "shadow/instanced/caster_type.h"
#include "shadow/registry.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

/// Which instanced maps a scene gets, decided on the CPU before anything is allocated. No GL.
namespace dapple::shadow {

/// What the view sees of the casters; all by item.
struct CasterView {
    std::vector<bool> inReach;  ///< its shadow can reach a receiver in view
    std::vector<double> looks;  ///< sine of half the angle that it fills, [0, 1]; less where it is out of sight
};

/// Maps for a scene's casters. The plan tries these steps in turn, and stops at the first that fits axis `memory`:
///  1. Every caster has maps of `size`²: one for each of its yaws where they are at most `rotations`, else a ring.
///  2. Casters whose shadows cannot reach the view have none.
///  3. Maps are smaller. Objects of small extent shrink first: no texel is finer than a common pitch.
///  4. Casters that look smallest are drawn into the cascaded maps of the far field.
/// Before them, casters larger than a map of their own can show go to the far field: see tooLarge.
struct MapPlan {
    std::vector<CasterType> types;
    size_t firstOwn = 0;              ///< index into types: from it on, each is one instance with a map of its own (axis `own`)
    std::vector<int> sharedTypeOf;    ///< by item: the type without regard to own maps; -1: it has no map
    std::vector<bool> cascaded;       ///< by item: drawn into the far field's maps for want of a map of its own
    std::vector<int> sides;           ///< by map: texels, all equal or powers of two
    std::vector<double> extents;      ///< by map: metres, of the largest caster that looks it up
    bool byView = false;              ///< another view may want other maps
    size_t bytes = 0;                 ///< of all maps at these sides
    size_t wantedBytes = 0;           ///< of a map of `size`² for every yaw of every caster in the scene
    std::string note;                 ///< what had to give way, or ""
};

/// What the maps must stay within.
struct MapBounds {
    int maxSide = 16384, maxPages = 2048;  ///< of GL's array textures
    size_t bytes = 512u << 20;
};

/// Whether a map over a caster of this extent (metres) has coarser texels than one map of kSceneMap² over the whole scene would.
/// A `side` below 512 counts as 512: who asks for coarse maps gets them, and not another technique.
inline constexpr int kSceneMap = 1024;
bool tooLarge(double extent, int side, double sceneExtent);

/// `exact`: by prototype, whether stencil volumes cast its shadow. `view` is asked only where the plan depends on it.
/// `sunTurn`: radians by which the light's heading differs from the one that rings are counted against.
/// Throws base::Error(failed) where nothing fits and the settings allow no far field.
MapPlan planMaps(const gpuscene::Items& items, const std::vector<bool>& exact, const Settings& settings, const MapBounds& bounds, double sunTurn,
                 const std::function<CasterView()>& view);

/// Where memory is short, no map shrinks below this side: coarser ones can show less than no shadow at all does.
inline constexpr int kLeastSide = 64;

/// Sides within the bounds: powers of two, none above its wish, none below kLeastSide or its wish. Maps of small extents shrink first.
/// The wishes themselves where they fit; empty where even the least sides do not.
std::vector<int> sidesWithin(std::span<const int> wishes, std::span<const double> extents, const MapBounds& bounds);

/// A caster with a map of its own.
CasterType ownType(const gpuscene::Items& items, uint32_t item);

/// Whether maps of its own would show a caster at `yaw` (radians, against the light's heading) better than the shared ones.
bool needsOwnMap(const CasterType& shared, double yaw);

/// Casters that get maps of their own, at most `most`: those that look largest, of those that need one.
std::vector<uint32_t> ownersOf(const gpuscene::Items& items, std::span<const CasterType> types, std::span<const int> sharedTypeOf, size_t most, double sunTurn,
                               const std::function<const CasterView&()>& view);

/// Whether casters at these yaws, radians, share a map: at 4,096 texels a side they differ by less than 1/50 texel.
bool sameYaw(double yaw, double other);

}  // namespace dapple::shadow
