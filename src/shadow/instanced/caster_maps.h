#pragma once

#include "shadow/instanced/map_atlas.h"
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

/// What shares maps: a prototype that casts, or one instance that has a map of its own.
struct CasterType {
    uint32_t prototype = 0;
    uint32_t instance = 0;       ///< one of those that share them: a lone map has its rotation
    int firstMap = 0;            ///< its maps are numbered from here on
    std::vector<double> angles;  ///< radians about the vertical at which the maps are laid out: 2πk/N, or the one that all its instances have
    bool ring = false;           ///< the former: instances turn against the maps
    base::Box box;               ///< prototype space, padded by the kernel's reach
    float pad = 0;               ///< of it, metres
};

/// One map, in metres of its object's own scale about the object's origin.
struct CasterMap {
    MapPose pose;      ///< what it shows
    glm::vec4 window;  ///< centre u, v, 1/half u, 1/half v
    double depthNear = 0, depthFar = 0;  ///< along the light
};

/// Maps of all caster types in one atlas, each fitted to the box of its object at its rotation. They depend on the sun's
/// elevation, on rotations against its azimuth, and the objects' shapes alone, not on the view: translation and uniform scale reuse them (Buntin & Stamminger 2007). Beyond
/// the paper, the instances that look largest have maps of their own, at their own rotation: axis `own`.
class CasterMaps {
public:
    /// Throws base::Error(failed) when GL has no texture for so many texels, or no memory.
    /// All maps are due.
    CasterMaps(const frame::Frame& frame, const Settings& settings);

    /// Gives the own maps to the instances that look largest from the frame's present view. Those that had one keep it;
    /// the maps of the others are due.
    void choose();
    /// Whether any map shows something else than it is used for, so that a frame may have to render.
    bool outdated() const { return !due_.empty() || policy_.outdated(wanted()); }

    std::span<const CasterType> types() const { return types_; }
    /// Index into types(); -1 for an instance that casts none, or exactly.
    int typeOf(uint32_t instance) const { return typeOf_[instance]; }
    /// Radians by which the light's heading has turned since the maps were laid out.
    double sunTurn() const;
    const MapAtlas& atlas() const { return atlas_; }
    std::span<const CasterMap> maps() const { return maps_; }
    double padTexels() const { return pad_; }                           ///< about each object in its map
    const std::vector<int>& sides() const { return sides_; }            ///< by map: texels
    /// Gives the maps other sides. Those that change are due.
    void resize(const std::vector<int>& sides);
    std::vector<LightMatrix> matrices() const;

    /// Renders the maps that are due in this frame by axis `update`. `uses`: by type, how many objects in view look it up.
    void render(std::span<const uint32_t> uses, measure::Ledger& tally);
    /// Renders all of them, as before a first frame.
    void renderAll(measure::Ledger& tally);
    /// `used`: by map.
    Staleness staleness(const std::vector<bool>& used) const { return policy_.staleness(wanted(), used); }

private:
    void makeTypes(const Settings& settings);
    void addType(CasterType type);
    void fit(CasterType& type);
    MapPose poseOf(const CasterType& type, size_t k) const;
    /// All maps as they are wanted now.
    std::vector<UpdatePolicy::Map> wanted() const;
    void draw(const std::vector<int>& maps, measure::Ledger& tally);
    glm::dmat4 clip(const CasterMap& map, double heading) const;

    const frame::Frame& frame_;
    const gpuscene::GpuScene& scene_;
    double heading_;  ///< of the light when the maps were laid out
    UpdatePolicy policy_;
    int size_;    ///< side at first, texels: the axis `size`, or the least until more is asked for
    double pad_;  ///< texels about an object's window
    std::vector<CasterType> types_;
    std::vector<int> sharedTypeOf_;  ///< without own maps
    size_t firstOwn_ = 0;            ///< index into types_: from it on each has one map, of ownerOf_[…]
    std::vector<uint32_t> ownerOf_;
    std::set<int> due_;              ///< maps without anything of use in them
    std::vector<int> typeOf_;
    std::vector<CasterMap> maps_;
    std::vector<int> sides_;
    MapAtlas atlas_;
    gpuscene::DrawList rotated_;  ///< by map: its prototype at its rotation
    gl::Program depth_, depthAlpha_;
};

}  // namespace dapple::shadow
