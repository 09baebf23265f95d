#pragma once

#include "shadow/map/fit.h"
#include "shadow/technique.h"

#include <cstdint>
#include <span>
#include <vector>

/// When maps of objects that stand about the vertical are rendered, while the sun and the objects move (Buntin & Stamminger
/// 2007, section 5.2). No GL.
namespace dapple::shadow {

/// The light as such maps see it, radians.
struct SunAngles {
    double heading = 0;    ///< of the light's travel, counter-clockwise from +x
    double elevation = 0;  ///< of the sun above the horizon

    glm::dvec3 light() const;  ///< unit, direction in which the light travels
    LightBasis basis() const;  ///< v is the projected vertical, so that it turns with the heading
};
/// `light`: unit. At the zenith the heading is that of +y.
SunAngles sunAngles(const glm::dvec3& light);

/// What a map of an object shows, radians. The sun's azimuth is not part of it: turning the sun and the object alike about
/// the vertical turns the map's axes with them and leaves its texels as they are, so that a map rendered under one azimuth
/// serves, under another, an object that is rotated by the difference. Hence rotations are counted against the light's
/// heading, and only the elevation makes a map of a given rotation another one.
struct MapPose {
    double yaw = 0;        ///< of the object, less what the light's heading has changed since the maps were laid out
    double elevation = 0;  ///< of the sun
};
/// Angle between the directions of the light that the poses stand for, on one object: radians.
double lagOf(const MapPose& shown, const MapPose& wanted);

/// Axis `update`, with axis `budget`.
class UpdatePolicy {
public:
    /// One map.
    struct Map {
        MapPose wanted;
        double texel = 0, height = 0;  ///< metres in the object's own scale: a texel across the light, the object's height
        uint32_t type = 0;
        bool moves = false;  ///< the object's shape does
    };

    explicit UpdatePolicy(const Settings& settings);

    /// Indices of the maps that this frame renders; they count as rendered. `maps` are the same from frame to frame but for
    /// their contents; `uses`: by type, how many objects in view look up its maps (missing: none). Call once per frame.
    std::vector<int> due(std::span<const Map> maps, std::span<const uint32_t> uses);
    /// All of them, as for a start; no frame has passed.
    std::vector<int> renderAll(std::span<const Map> maps);
    /// Whether any map shows something else than it is used for, so that a frame may have to render.
    bool outdated(std::span<const Map> maps) const;
    /// That map shows nothing of use: it is due whatever the policy is.
    void forget(int map);
    /// What a map shows since it was rendered.
    const MapPose& shown(int map) const { return states_[size_t(map)].shown; }
    /// `used`: by map, whether an object in view looks it up.
    Staleness staleness(std::span<const Map> maps, const std::vector<bool>& used) const;

private:
    struct State {
        MapPose shown;
        bool known = false;
        long age = 0;  ///< frames
    };
    enum class Kind { cached, regenerate, moving, criterion, roundRobin };
    bool isOutdated(const Map& map, const State& state) const;
    std::vector<int> queued(std::span<const Map> maps, std::span<const uint32_t> uses);

    Kind kind_;
    size_t budget_;
    std::vector<State> states_;
    std::vector<int> queue_;  ///< round-robin: the rest of this round, last first
};

}  // namespace dapple::shadow
