#pragma once

#include "shadow/instanced/caster_maps.h"
#include "shadow/instanced/volume.h"

#include <memory>
#include <span>
#include <vector>

namespace dapple::shadow {

/// Pixels that a caster's bounding shadow volume covers on the screen, hidden or not: that many fragments it has where nothing
/// hides its front. `corners`: of the caster's box, relative to the eye; `swept`: metres along `light` (unit) by which they are
/// extruded.
double volumePixels(const frame::Camera& camera, const std::array<glm::dvec3, 8>& corners, const glm::dvec3& light, double swept);

/// What one caster costs, nearest first: as a volume, and in a map.
struct FarCost {
    double fragments = 0, triangles = 0;
};
/// How many casters, the nearest, keep their volumes so that Σ fragments over them, plus, unless that is all of them,
/// `perTriangle` × Σ triangles over the others and `fixed`, is least. The most of several such.
size_t nearestAsVolumes(std::span<const FarCost> costs, double perTriangle, double fixed);
/// The same without regard to distance: which casters keep their volumes.
std::vector<bool> cheaperAsVolumes(std::span<const FarCost> costs, double perTriangle, double fixed);

/// Casters far from the eye, or those whose volumes cost most, are drawn into cascaded maps of the scene instead of having
/// volumes: axes `far-field` and `far-cost`. Where hundreds of volumes lie over one another, as under a low sun, what they cost
/// grows with the screen and not with the casters. Both darken one image, so that every pixel is shadowed by all casters. It also
/// takes the casters that the maps' plan leaves without one (MapPlan::cascaded).
class FarField {
public:
    /// Throws base::Error(failed) when there is no memory for its maps.
    FarField(frame::Frame& frame, const CasterMaps& maps, const Settings& settings);

    /// Chooses anew for the frame's present view, among all that cast instanced shadows; takes the far ones out of `casters`, of
    /// those that can darken the view.
    void takeFar(std::vector<uint32_t>& casters, const Extrusion& extrusion);
    /// Whether the last choice took one.
    bool any() const { return any_; }
    /// Of the maps that the far casters are drawn into, the technique `cascaded`: it writes the whole visibility image.
    Technique& technique() { return *technique_; }
    const Technique& technique() const { return *technique_; }

private:
    FarCost costOf(uint32_t item, const Extrusion& extrusion) const;

    const frame::Frame& frame_;
    const CasterMaps& maps_;
    enum class Kind { none, distance, nearest, each } kind_;
    double distance_ = 0;  ///< metres, of Kind::distance
    double perTriangle_;   ///< fragments
    bool any_ = false;
    std::vector<bool> drawn_;  ///< by instance: into the maps
    std::unique_ptr<Technique> technique_;
};

}  // namespace dapple::shadow
