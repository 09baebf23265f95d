#include "truth/occluders.h"

#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace dapple::truth {
namespace {

/// Rays may bring a filter of their own: blockers() and transmitted().
const auto kSceneFlags = RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);

int texelAt(float coordinate, int size, scenegen::Wrap wrap) {
    const double texel = std::floor(double(coordinate) * size);
    if (wrap == scenegen::Wrap::clamp) return int(std::clamp(texel, 0.0, double(size - 1)));
    const int period = wrap == scenegen::Wrap::mirror ? 2 * size : size;
    const int inPeriod = std::clamp(int(texel - period * std::floor(texel / period)), 0, period - 1);
    return inPeriod < size ? inPeriod : 2 * size - 1 - inPeriod;
}

/// Occlusion filter: a hit where the texture is transparent is no hit. Embree calls it from many threads.
void rejectTransparent(const RTCFilterFunctionNArguments* args) {
    const auto& mesh = *static_cast<const OccluderMesh*>(args->geometryUserPtr);
    for (unsigned int i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const unsigned int triangle = RTCHitN_primID(args->hit, args->N, i);
        if (!mesh.opaque(triangle, RTCHitN_u(args->hit, args->N, i), RTCHitN_v(args->hit, args->N, i))) args->valid[i] = 0;
    }
}

}  // namespace

OpacityMask::OpacityMask(const scenegen::Texture& texture, float cutoff)
    : width(texture.image.width), height(texture.image.height), wrapU(texture.wrapU), wrapV(texture.wrapV) {
    const base::Image8& image = texture.image;
    if (image.channels < 4) return;
    for (size_t texel = 0; texel < size_t(width) * size_t(height); ++texel)
        opaque.push_back(float(image.texels[4 * texel + 3]) / 255.0f >= cutoff);
    everywhere = std::ranges::all_of(opaque, [](uint8_t o) { return o != 0; });
}

bool OpacityMask::at(glm::vec2 uv) const {
    return opaque[size_t(texelAt(uv.y, height, wrapV)) * size_t(width) + size_t(texelAt(uv.x, width, wrapU))] != 0;
}

float OccluderMesh::longestEdge(size_t triangle) const {
    const glm::uvec3 t = triangles[triangle];
    const glm::vec3 a = positions[t.x], b = positions[t.y], c = positions[t.z];
    return std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
}

bool OccluderMesh::opaque(size_t triangle, float u, float v) const {
    const auto& uv = cornerUvs[triangle];
    return mask->at((1 - u - v) * uv[0] + u * uv[1] + v * uv[2]);
}

Occluders::Occluders(const scenegen::Scene& scene) : device_(rtcNewDevice(nullptr)) {
    if (!device_) throw base::Error(base::ExitCode::failed, "Embree does not start on this machine: the reference needs it (libembree3)");
    prototypes_.resize(scene.prototypes.size());
    translucent_ = scene.facts().translucent;
    for (const scenegen::Prototype& prototype : scene.prototypes) transmittances_.push_back(prototype.transmittance);
    std::vector<float> reach(prototypes_.size()), edge(prototypes_.size());
    for (const scenegen::Instance& instance : scene.instances) {
        const uint32_t id = instance.prototype;
        if (!scene.prototypes[id].castsShadow || scene.prototypes[id].triangles() == 0) continue;
        if (!prototypes_[id].scene) {
            build(scene, id);
            const base::Box box = scene.prototypes[id].box();
            const glm::vec3 far = glm::max(glm::abs(box.lo), glm::abs(box.hi));
            reach[id] = std::max({far.x, far.y, far.z});
            for (size_t m = 0; m < prototypes_[id].meshes.size(); ++m)
                for (size_t t = 0; t < scene.prototypes[id].meshes[m].triangles(); ++t)
                    edge[id] = std::max(edge[id], prototypes_[id].meshes[m].longestEdge(t));
        }
        instances_.push_back(instance);
        sceneInstances_.push_back(uint32_t(&instance - scene.instances.data()));
        reach_ = std::max(reach_, reach[id] * instance.scale);
        longestEdge_ = std::max(longestEdge_, edge[id] * instance.scale);
    }
    requireNoError();
}

void Occluders::instancesMoved(const scenegen::Scene& scene) {
    for (size_t i = 0; i < instances_.size(); ++i) instances_[i] = scene.instances[sceneInstances_[i]];
}

/// Null where all of the material blocks.
const OpacityMask* Occluders::maskOf(const scenegen::Scene& scene, const scenegen::Material& material) {
    if (!material.alphaTested || material.texture < 0) return nullptr;
    const std::pair key(material.texture, material.alphaCutoff);
    auto it = masks_.find(key);
    if (it == masks_.end()) it = masks_.emplace(key, OpacityMask(scene.textures[size_t(material.texture)], material.alphaCutoff)).first;
    return it->second.everywhere ? nullptr : &it->second;
}

/// No light through shared edges; and filters of rays, if rays have any.
void Occluders::build(const scenegen::Scene& scene, uint32_t id) {
    const std::vector<scenegen::Mesh>& meshes = scene.prototypes[id].meshes;
    Prototype& prototype = prototypes_[id];
    prototype.scene.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(prototype.scene.get(), kSceneFlags);
    rtcSetSceneBuildQuality(prototype.scene.get(), RTC_BUILD_QUALITY_HIGH);
    prototype.meshes.resize(meshes.size());
    for (size_t m = 0; m < meshes.size(); ++m) {
        const scenegen::Mesh& mesh = meshes[m];
        OccluderMesh& occluder = prototype.meshes[m];
        if (mesh.triangles() == 0) continue;
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.positions.size());
        void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangles());
        requireNoError();
        std::memcpy(positions, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
        std::memcpy(triangles, mesh.indices.data(), mesh.indices.size() * sizeof(uint32_t));
        occluder.positions = static_cast<const glm::vec3*>(positions);
        occluder.triangles = static_cast<const glm::uvec3*>(triangles);

        const scenegen::Material& material = scene.materials[mesh.material];
        if (const OpacityMask* mask = maskOf(scene, material)) {
            occluder.mask = mask;
            for (size_t i = 0; i < mesh.indices.size(); i += 3)
                occluder.cornerUvs.push_back({mesh.uvs[mesh.indices[i]], mesh.uvs[mesh.indices[i + 1]], mesh.uvs[mesh.indices[i + 2]]});
            rtcSetGeometryUserData(geometry, &occluder);
            rtcSetGeometryOccludedFilterFunction(geometry, rejectTransparent);
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(prototype.scene.get(), geometry, uint32_t(m));
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(prototype.scene.get());
}

Occluders::Placement Occluders::placeAround(const glm::dvec3& eye) const {
    Placement placement{SceneHandle(rtcNewScene(device_.get())), {}};
    rtcSetSceneFlags(placement.scene.get(), kSceneFlags);
    placement.instances.reserve(instances_.size());
    for (const scenegen::Instance& instance : instances_) {
        const glm::vec3 t(glm::dvec3(instance.translation) - eye);
        const auto c = float(std::cos(double(instance.yaw)) * instance.scale);
        const auto s = float(std::sin(double(instance.yaw)) * instance.scale);
        const float columns[12] = {c, s, 0, -s, c, 0, 0, 0, instance.scale, t.x, t.y, t.z};
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, prototypes_[instance.prototype].scene.get());
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(placement.scene.get(), geometry, uint32_t(placement.instances.size()));
        rtcReleaseGeometry(geometry);
        placement.instances.push_back({t, instance.scale, instance.prototype});
    }
    rtcCommitScene(placement.scene.get());
    requireNoError();
    return placement;
}

namespace {

/// What a ray has met. Embree hands the context on to its filter.
struct Passage {
    RTCIntersectContext context;
    const Occluders::Placement* placement = nullptr;
    const std::vector<float>* transmittances = nullptr;  ///< by prototype
    std::vector<uint32_t> met;                           ///< instances
    float product = 1;
};

/// Called for every triangle that the ray meets, more than once for some: takes note of its instance and lets the ray go on,
/// unless the instance is opaque.
void pass(const RTCFilterFunctionNArguments* args) {
    auto& passage = *reinterpret_cast<Passage*>(args->context);
    for (unsigned int i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const unsigned int instance = RTCHitN_instID(args->hit, args->N, i, 0);
        const float transmittance = (*passage.transmittances)[passage.placement->instances[instance].prototype];
        if (transmittance == 0) {
            passage.product = 0;
            continue;
        }
        if (std::ranges::find(passage.met, instance) == passage.met.end()) passage.met.push_back(instance);
        args->valid[i] = 0;
    }
}

/// What a ray goes through, all of it.
struct Notes {
    RTCIntersectContext context;
    std::vector<uint32_t>* met = nullptr;
};

void takeNote(const RTCFilterFunctionNArguments* args) {
    std::vector<uint32_t>& met = *reinterpret_cast<Notes*>(args->context)->met;
    for (unsigned int i = 0; i < args->N; ++i) {
        if (args->valid[i] != -1) continue;
        const unsigned int instance = RTCHitN_instID(args->hit, args->N, i, 0);
        if (std::ranges::find(met, instance) == met.end()) met.push_back(instance);
        args->valid[i] = 0;
    }
}

}  // namespace

void Occluders::blockers(const Placement& placement, const glm::vec3& start, const glm::vec3& direction, std::vector<uint32_t>& met) const {
    Notes notes;
    rtcInitIntersectContext(&notes.context);
    notes.context.filter = takeNote;
    notes.met = &met;
    RTCRay ray{start.x, start.y, start.z, 0, direction.x, direction.y, direction.z, 0, std::numeric_limits<float>::infinity(), ~0u, 0, 0};
    rtcOccluded1(placement.scene.get(), &notes.context, &ray);
}

float Occluders::transmitted(const Placement& placement, const glm::vec3& start, const glm::vec3& direction) const {
    Passage passage;
    rtcInitIntersectContext(&passage.context);
    passage.context.filter = pass;
    passage.placement = &placement;
    passage.transmittances = &transmittances_;
    RTCRay ray{start.x, start.y, start.z, 0, direction.x, direction.y, direction.z, 0, std::numeric_limits<float>::infinity(), ~0u, 0, 0};
    rtcOccluded1(placement.scene.get(), &passage.context, &ray);
    if (passage.product == 0) return 0;
    // In the order of the instances, so that equal sets give equal bits.
    std::ranges::sort(passage.met);
    for (const uint32_t instance : passage.met) passage.product *= transmittances_[placement.instances[instance].prototype];
    return passage.product;
}

void Occluders::requireNoError() const {
    const RTCError error = rtcGetDeviceError(device_.get());
    if (error == RTC_ERROR_NONE) return;
    const char* why = error == RTC_ERROR_OUT_OF_MEMORY ? "not enough memory for its acceleration structure" : "internal error";
    throw base::Error(base::ExitCode::failed, fmt::format("Embree cannot build the scene for the reference: {} (code {})", why, int(error)));
}

}  // namespace dapple::truth
