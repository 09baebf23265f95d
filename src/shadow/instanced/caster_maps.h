#pragma once

#include "shadow/map/fit.h"
#include "shadow/technique.h"

#include <set>
#include <span>
#include <vector>

namespace dapple::shadow {

/// What shares maps: a prototype that casts, or one instance that has a map of its own.
struct CasterType {
    uint32_t prototype = 0;
    int firstLayer = 0;          ///< of its maps in the array
    std::vector<double> angles;  ///< radians about the vertical at which the maps show it: 2πk/N, or the one that all its instances have
    base::Box box;               ///< prototype space, padded by the kernel's reach
    double depthNear = 0, depthFar = 0;  ///< metres along the light from its origin, common to its maps
};

/// Maps of all caster types in one array, each fitted to the box of its object at its rotation. They depend on the sun and
/// the objects' shapes alone, not on the view: translation and uniform scale reuse them (Buntin & Stamminger 2007). Beyond
/// the paper, the instances that look largest have maps of their own, at their own rotation: axis `own`.
class CasterMaps {
public:
    /// Throws base::Error(failed) when the array would have more layers than GL allows, or there is no memory for it.
    /// All maps are due.
    CasterMaps(const frame::Frame& frame, const Settings& settings);

    /// Gives the own maps to the instances that look largest from the frame's present view. Those that had one keep it;
    /// the maps of the others are due.
    void choose();
    bool due() const { return !due_.empty(); }
    void setAllDue();
    /// Counts the changes of types and windows.
    int version() const { return version_; }

    std::span<const CasterType> types() const { return types_; }
    /// Index into types(); -1 for an instance that casts no shadow.
    int typeOf(uint32_t instance) const { return typeOf_[instance]; }
    const LightBasis& basis() const { return basis_; }
    const gl::Texture& array() const { return array_; }
    const std::vector<glm::vec4>& windows() const { return windows_; }  ///< by layer: centre u, v, 1/half u, 1/half v
    std::vector<LightMatrix> matrices() const;

    /// Renders the maps that are due.
    void render(measure::Ledger& tally);

private:
    void makeTypes(const Settings& settings);
    void addType(CasterType type);
    void fit(CasterType& type);
    glm::dmat4 clip(const CasterType& type, int k) const;

    const frame::Frame& frame_;
    const gpuscene::GpuScene& scene_;
    LightBasis basis_;
    int size_;
    double pad_;  ///< texels about an object's window
    std::vector<CasterType> types_;
    std::vector<int> sharedTypeOf_;  ///< without own maps
    size_t firstOwn_ = 0;            ///< index into types_: from it on each has one map, of ownerOf_[…]
    std::vector<uint32_t> ownerOf_;
    std::set<int> due_;              ///< layers
    int version_ = 0;
    std::vector<int> typeOf_;
    std::vector<glm::vec4> windows_;
    gl::Texture array_;
    std::vector<gl::Framebuffer> targets_;
    gpuscene::DrawList rotated_;  ///< by layer: its prototype at its rotation
    gl::Program depth_, depthAlpha_;
};

}  // namespace dapple::shadow
