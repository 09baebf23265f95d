#pragma once

#include "base/math.h"
#include "scenegen/scene.h"

#include <vector>

namespace dapple::scenegen {

/// A place of a prototype in the file's world: x ↦ translation + scale · Rz(yaw) · x, metres and radians.
struct Placed {
    glm::dvec3 translation;
    double scale, yaw;

    glm::dvec3 operator()(const glm::dvec3& p) const;
};

/// A prototype under construction with its places.
struct Draft {
    Prototype prototype;
    std::vector<Placed> places;
};

/// Sets Prototype::closed of all drafts, and turns closed parts that are wound inwards, with their normals. Returns how
/// many it has turned.
///
/// The signed volume of a connected part says which way it faces. A part that faces inwards and lies in one that faces
/// outwards is a cavity and stays. One that lies in another draft's part, or has something in it (a room with its
/// furniture, a dome with its scene, one of `views`), may face inwards on purpose. Nobody can tell, so its prototype is
/// not closed: both its sides are drawn.
size_t orientClosed(std::vector<Draft>& drafts, const std::vector<View>& views);

}  // namespace dapple::scenegen
