#pragma once

#include "shadow/instanced/caster_maps.h"
#include "shadow/instanced/volume.h"

namespace dapple::shadow {

class FarField;

/// The instances whose shadow volumes can meet a receiver in view, with their maps, on the GPU (lib/instanced.glsl).
class CasterList {
public:
    CasterList(const frame::Frame& frame, const CasterMaps& maps) : frame_(frame), maps_(maps) {}

    /// Anew for the frame's present view; without those that `far` takes.
    void collect(FarField* far = nullptr);
    /// Binds casters, types and maps to storage buffers 1, 2 and 3.
    void bind() const;

    size_t size() const { return casters_.size(); }
    /// So many stand first in the list whose volumes do not hold the eye, nor reach the near plane.
    size_t notAboutEye() const { return notAboutEye_; }
    const Extrusion& extrusion() const { return extrusion_; }
    /// By type, how many casters of the list look its maps up; by map, whether one does.
    std::vector<uint32_t> uses() const;
    std::vector<bool> mapsInUse() const;

private:
    struct GpuCaster {
        glm::vec4 place;    ///< position relative to the eye, scale
        glm::vec4 yaw;      ///< cosine, sine; weight of the second map
        glm::vec4 turns;    ///< the maps' rotation minus the caster's: cosine and sine for the first, cosine and sine for the second
        glm::uvec4 refers;  ///< to its type, first map, second map
    };
    static_assert(sizeof(GpuCaster) == 64);

    void uploadTypes();
    double strayOf(const CasterType& type) const;
    GpuCaster casterOf(uint32_t instance) const;
    bool holdsEye(const GpuCaster& caster) const;

    const frame::Frame& frame_;
    const CasterMaps& maps_;
    double sunTurn_ = 0;
    std::vector<float> strays_;  ///< by type: metres by which shadows of maps of an earlier sun may leave the present one's volume
    std::vector<uint32_t> instances_;  ///< by index
    std::vector<GpuCaster> casters_;   ///< of them, in another order
    size_t notAboutEye_ = 0;
    Extrusion extrusion_;
    int mapsVersion_ = -1;  ///< that types and maps on the GPU have
    gl::Buffer casterBuffer_, typeBuffer_, mapBuffer_;
};

}  // namespace dapple::shadow
