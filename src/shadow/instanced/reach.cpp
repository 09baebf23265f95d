#include "shadow/instanced/reach.h"

#include "shadow/map/caster_cull.h"

namespace dapple::shadow {
namespace {

constexpr uint64_t kLeafTriangles = 10'000;  ///< of the hierarchy: some trees

}  // namespace

std::vector<uint32_t> castersInReach(const frame::Frame& frame, const gpuscene::Items& items, double stray) {
    const frame::Camera& camera = frame.camera();
    const base::DBox sceneBox = frame.relativeSceneBox();
    const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, sceneBox);
    const CasterCull cull(lightBasis(frame.light(), {0, 0, 1}), camera, body, 1e-3 * glm::length(sceneBox.size()) + stray);
    return cull.kept(items.hierarchy(kLeafTriangles, true), items.boxes(), camera.eye);
}

}  // namespace dapple::shadow
