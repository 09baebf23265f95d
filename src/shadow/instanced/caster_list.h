#pragma once

#include "shadow/instanced/caster_maps.h"
#include "shadow/instanced/volume.h"

namespace dapple::shadow {

class FarField;

/// The casters whose shadow volumes can meet a receiver in view, with their maps, on the GPU (lib/instanced.glsl).
class CasterList {
public:
    CasterList(const frame::Frame& frame, const CasterMaps& maps) : frame_(frame), maps_(maps) {}

    /// Anew for the frame's present view; without those that `far` takes.
    void collect(FarField* far = nullptr);
    /// None, where the maps' plan is another: indices into the one that was mean nothing.
    void clear() {
        items_.clear();
        casters_.clear();
        notAboutEye_ = 0;
    }
    /// After the maps have changed: the same casters.
    void update();
    /// Binds it to storage buffer 1.
    void bind() const;

    size_t size() const { return casters_.size(); }
    /// So many stand first in the list whose volumes do not hold the eye, nor reach the near plane.
    size_t notAboutEye() const { return notAboutEye_; }
    const Extrusion& extrusion() const { return extrusion_; }
    /// By type, how many casters of the list look its maps up; by map, whether one does.
    std::vector<uint32_t> uses() const;
    std::vector<bool> mapsInUse() const;

private:
    // As in shaders/lib/instanced.glsl.
    struct GpuMap {
        glm::vec4 texels, square, light, turn;
    };
    struct GpuCaster {
        glm::vec4 place, box, reach, against, turn;
        GpuMap first, second;
        glm::uvec4 refers;
    };
    static_assert(sizeof(GpuCaster) == 224);

    void readMaps();
    void upload();
    double strayOf(const CasterType& type) const;
    GpuCaster casterOf(uint32_t item) const;
    GpuMap mapOf(uint32_t index, double turn, const CasterType& type, double scale) const;
    bool holdsEye(const GpuCaster& caster) const;

    const frame::Frame& frame_;
    const CasterMaps& maps_;
    double sunTurn_ = 0;
    std::vector<float> strays_;  ///< by type: metres by which shadows of maps of an earlier sun may leave the present one's volume
    std::vector<uint32_t> items_;      ///< by index
    std::vector<GpuCaster> casters_;   ///< of them, in another order
    size_t notAboutEye_ = 0;
    Extrusion extrusion_;
    gl::Buffer buffer_;
};

}  // namespace dapple::shadow
