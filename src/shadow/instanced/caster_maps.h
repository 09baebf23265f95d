#pragma once

#include "shadow/instanced/map_atlas.h"
#include "shadow/instanced/map_plan.h"
#include "shadow/instanced/update_policy.h"
#include "shadow/map/fit.h"
#include "shadow/technique.h"

#include <set>
#include <span>
#include <vector>

namespace dapple::shadow {

/// Whether a caster's shadow is left to stencil volumes: closed, opaque, without alpha test, and within the limit of triangles that
/// axis `exact-casters` sets.
bool castsExactly(const scenegen::Scene& scene, const scenegen::Prototype& prototype, const Settings& settings);

/// One map, in metres of its object's own scale about the object's origin.
struct CasterMap {
    MapPose pose;      ///< what it shows
    glm::vec4 window;  ///< centre u, v, 1/half u, 1/half v
    double depthNear = 0, depthFar = 0;  ///< along the light
};

/// Maps of all caster types in one atlas, each fitted to the box of its object at its rotation. They depend on the sun's
/// elevation, on rotations against its azimuth, and on the objects' shapes alone: translation and uniform scale reuse them
/// (Buntin & Stamminger 2007). Which there are, and how large, says MapPlan. Beyond the paper, instances that look largest have
/// maps of their own, at their own rotation: axis `own`. Casters are counted as gpuscene::Items.
class CasterMaps {
public:
    /// All maps are due. Throws base::Error(failed) when no plan fits axis `memory`, or GL has not that much.
    CasterMaps(const frame::Frame& frame, const Settings& settings);

    /// For the frame's present view and sun: gives own maps to the casters that look largest of those that need one. Those that
    /// had one keep it; the maps of the others are due. Plans anew where the plan was another view's, or needs another number of
    /// own maps: then all are due. Returns whether it did.
    bool choose();
    /// Whether any map shows something else than it is used for, so that a frame may have to render.
    bool outdated() const { return !due_.empty() || policy_.outdated(wanted()); }

    const gpuscene::Items& items() const { return items_; }
    const MapPlan& plan() const { return plan_; }
    std::span<const CasterType> types() const { return plan_.types; }
    /// Index into types(); -1 for a caster that has no map: out of reach, exact, or the far field's.
    int typeOf(uint32_t item) const { return typeOf_[item]; }
    /// Of a type without ring: index into its angles.
    size_t angleOf(const CasterType& type, uint32_t item) const;
    /// Radians by which the light's heading has turned since the maps were laid out.
    double sunTurn() const;
    const MapAtlas& atlas() const { return atlas_; }
    std::span<const CasterMap> maps() const { return maps_; }
    double padTexels() const { return pad_; }                           ///< about each object in its map
    const std::vector<int>& sides() const { return sides_; }            ///< by map: texels
    /// Gives the maps other sides, less where axis `memory` asks it. Those that change are due.
    void resize(const std::vector<int>& wishes);
    /// Most bytes that the maps may take: as planned, or with sides that follow what is asked for, as far as axis `memory` lets them.
    size_t plannedBytes() const;
    /// What that map has to show now.
    MapPose poseOf(const CasterType& type, size_t angle) const;
    std::vector<LightMatrix> matrices() const;

    /// Renders the maps that are due in this frame by axis `update`. `uses`: by type, how many objects in view look it up.
    void render(std::span<const uint32_t> uses, measure::Ledger& tally);
    /// Renders all of them, as before a first frame.
    void renderAll(measure::Ledger& tally);
    /// `used`: by map.
    Staleness staleness(const std::vector<bool>& used) const { return policy_.staleness(wanted(), used); }

private:
    void layOut();
    void fit(CasterType& type);
    CasterView view() const;
    /// All maps as they are wanted now.
    std::vector<UpdatePolicy::Map> wanted() const;
    void draw(const std::vector<int>& maps, measure::Ledger& tally);
    glm::dmat4 clip(const CasterMap& map, double heading) const;

    const frame::Frame& frame_;
    const Settings settings_;
    const gpuscene::GpuScene& scene_;
    const gpuscene::Items& items_;
    std::vector<bool> exact_;  ///< by prototype
    MapBounds bounds_;
    double heading_;           ///< of the light when the maps were laid out
    double pad_;               ///< texels about an object's window
    UpdatePolicy policy_;
    MapPlan plan_;
    std::set<int> due_;        ///< maps without anything of use in them
    std::vector<int> typeOf_;  ///< by item
    std::vector<CasterMap> maps_;
    std::vector<int> sides_;
    MapAtlas atlas_;
    gpuscene::DrawList rotated_;  ///< by map: its part at its rotation
    gl::Program depth_, depthAlpha_;
};

}  // namespace dapple::shadow
