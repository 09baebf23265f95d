#include "truth/reference.h"

#include "base/log.h"
#include "truth/occluders.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <mutex>

namespace dapple::truth {
namespace {

constexpr double kGrazing = 0.02;  ///< smallest N · (−l) at which a shadow is defined
/// A point rebuilt from a reversed-z D32F depth is off by about 1e-6 of its distance; twice that clears it.
constexpr float kDepthError = 2e-6f;
/// Embree's hit distance is off by a few roundings of the triangle's size; this clears it.
constexpr float kEdgeError = 1e-6f;
/// Embree rounds a ray in the space of the prototype that it meets. All three starts are moved by this many ulps of the receiver's
/// distance to the instance's origin: enough to clear its own triangle, without making the starts differ more.
constexpr float kPlacementUlps = 1;
/// Ray starts, in multiples of ε; where they disagree the label is ambiguous.
constexpr float kOffsets[] = {1, 4, 16};

constexpr int kBlock = 4;                  ///< pixels per side of a block
constexpr int kLanes = kBlock * kBlock;    ///< one block = one packet of parallel, neighbouring rays

float ulp(float x) { return std::nextafter(x, std::numeric_limits<float>::infinity()) - x; }
float largest(glm::vec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

bool faces(const Receivers& receivers, size_t pixel, const glm::dvec3& toSun) {
    return receivers.present[pixel] && glm::dot(glm::dvec3(receivers.normal[pixel]), toSun) > kGrazing &&
           base::allFinite(receivers.position[pixel]);
}

/// One 4 × 4 block of pixels on its way through Embree.
struct Packet {
    alignas(64) int active[kLanes] = {};  ///< −1 = traced, 0 = not (Embree's convention)
    size_t pixel[kLanes] = {};
    glm::vec3 position[kLanes] = {}, normal[kLanes] = {};
    float epsilon[kLanes] = {};
    float rounding[kLanes] = {};  ///< metres

    /// Start of a lane's ray at offset kOffsets[k].
    glm::vec3 start(int lane, size_t k) const { return position[lane] + (kOffsets[k] * epsilon[lane] + rounding[lane]) * normal[lane]; }
};

template <class Ray>
void setRay(Ray& ray, int lane, glm::vec3 start, glm::vec3 direction, float length) {
    ray.org_x[lane] = start.x;
    ray.org_y[lane] = start.y;
    ray.org_z[lane] = start.z;
    ray.dir_x[lane] = direction.x;
    ray.dir_y[lane] = direction.y;
    ray.dir_z[lane] = direction.z;
    ray.tnear[lane] = 0;
    ray.tfar[lane] = length;
    ray.time[lane] = 0;
    ray.mask[lane] = ~0u;
    ray.id[lane] = uint32_t(lane);
    ray.flags[lane] = 0;
}

/// ε of each lane = 8 ulp(max |p|) + 1e-6 · edge of the triangle that holds the receiver + its depth error.
/// The G-buffer does not name that triangle, so a short ray through the receiver along its normal finds
/// it. A receiver that no caster holds has no triangle of its own to hit and needs no edge and no rounding.
void setEpsilon(Packet& packet, const Occluders& occluders, const Occluders::Placement& placement) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    alignas(64) RTCRayHit16 probe;
    const float slack = 8 * ulp(occluders.reach()) + kEdgeError * occluders.longestEdge();
    for (int i = 0; i < kLanes; ++i) {
        const glm::vec3 p = packet.position[i], n = packet.normal[i];
        packet.epsilon[i] = kDepthError * glm::length(p) + 8 * ulp(largest(p));
        const float reach = kOffsets[2] * packet.epsilon[i] + slack;
        setRay(probe.ray, i, p + reach * n, -n, 2 * reach);
        probe.hit.geomID[i] = probe.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect16(packet.active, placement.scene.get(), &context, &probe);
    for (int i = 0; i < kLanes; ++i) {
        if (!packet.active[i] || probe.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const Occluders::Instance& instance = placement.instances[probe.hit.instID[0][i]];
        const OccluderMesh& mesh = occluders.mesh(instance.prototype, probe.hit.geomID[i]);
        const glm::vec3 p = packet.position[i];
        packet.epsilon[i] += kEdgeError * instance.scale * mesh.longestEdge(probe.hit.primID[i]);
        // Embree moves the ray into the prototype's space and rounds it there, far from the origin more than at the receiver.
        packet.rounding[i] = kPlacementUlps * ulp(glm::distance(p, instance.translation));
    }
}

void label(Packet& packet, const Occluders& occluders, const Occluders::Placement& placement, glm::vec3 toSun, Reference& reference) {
    setEpsilon(packet, occluders, placement);
    std::vector<Label>& labels = reference.label;
    if (occluders.translucent()) {
        for (int i = 0; i < kLanes; ++i) {
            if (!packet.active[i]) continue;
            float shares[std::size(kOffsets)];
            for (size_t k = 0; k < std::size(kOffsets); ++k)
                shares[k] = occluders.transmitted(placement, packet.start(i, k), toSun);
            const bool agree = shares[0] == shares[1] && shares[1] == shares[2];
            labels[packet.pixel[i]] = !agree ? Label::ambiguous : shares[0] >= 0.5f ? Label::lit : Label::shadowed;
            reference.transmitted[packet.pixel[i]] = shares[0];
        }
        return;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    // Not RTC_INTERSECT_CONTEXT_FLAG_COHERENT: with it, rtcOccluded16 of Embree 3.13.5 (AVX-512) was seen
    // never to return, on a box as on a forest.
    int blocked[kLanes] = {};
    for (size_t k = 0; k < std::size(kOffsets); ++k) {
        alignas(64) RTCRay16 ray;
        for (int i = 0; i < kLanes; ++i) setRay(ray, i, packet.start(i, k), toSun, std::numeric_limits<float>::infinity());
        rtcOccluded16(packet.active, placement.scene.get(), &context, &ray);
        for (int i = 0; i < kLanes; ++i) blocked[i] += ray.tfar[i] < 0;  // Embree marks a hit with −∞
    }
    for (int i = 0; i < kLanes; ++i) {
        if (!packet.active[i]) continue;
        const bool all = blocked[i] == int(std::size(kOffsets));
        labels[packet.pixel[i]] = blocked[i] == 0 ? Label::lit : all ? Label::shadowed : Label::ambiguous;
    }
}

/// Calls work(packet) for all receivers that face the sun, in blocks of the image, from several threads.
template <class Work>
void forEachPacket(const Receivers& receivers, const glm::dvec3& toSun, const Work& work) {
    const int width = receivers.width, height = receivers.height;
    const int rows = (height + kBlock - 1) / kBlock;
    base::Progress progress("reference", size_t(rows));
    std::mutex progressMutex;
    std::atomic<size_t> done = 0;
    tbb::parallel_for(0, rows, [&](int row) {
        for (int x0 = 0; x0 < width; x0 += kBlock) {
            Packet packet;
            bool any = false;
            for (int i = 0; i < kLanes; ++i) {
                const int x = x0 + i % kBlock, y = row * kBlock + i / kBlock;
                if (x >= width || y >= height) continue;
                const size_t pixel = size_t(y) * size_t(width) + size_t(x);
                if (!faces(receivers, pixel, toSun)) continue;
                any = true;
                packet.active[i] = -1;
                packet.pixel[i] = pixel;
                packet.position[i] = receivers.position[pixel];
                packet.normal[i] = receivers.normal[pixel];
            }
            if (any) work(packet);
        }
        ++done;
        if (const std::unique_lock lock(progressMutex, std::try_to_lock); lock) progress.update(done);
    });
}

}  // namespace

struct Tracer::Impl {
    Occluders occluders;
};

Tracer::Tracer(const scenegen::Scene& scene) : impl_(new Impl{Occluders(scene)}) {}
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

void Tracer::instancesMoved(const scenegen::Scene& scene) { impl_->occluders.instancesMoved(scene); }

Reference Tracer::trace(const Receivers& receivers, const glm::dvec3& eye, const glm::dvec3& light) const {
    const int width = receivers.width, height = receivers.height;
    const size_t pixels = size_t(width) * size_t(height);
    assert(receivers.position.size() == pixels && receivers.normal.size() == pixels && receivers.present.size() == pixels);
    Reference reference{width, height, std::vector<Label>(pixels, Label::excluded), {}};

    const glm::dvec3 toSun = -light;
    const bool day = toSun.z > 0;
    if (!day || impl_->occluders.empty()) {
        for (size_t i = 0; i < pixels; ++i)
            if (faces(receivers, i, toSun)) reference.label[i] = day ? Label::lit : Label::shadowed;
        return reference;
    }

    if (impl_->occluders.translucent()) reference.transmitted.assign(pixels, 1.0f);
    const Occluders::Placement placement = impl_->occluders.placeAround(eye);
    forEachPacket(receivers, toSun, [&](Packet& packet) { label(packet, impl_->occluders, placement, glm::vec3(toSun), reference); });
    return reference;
}

std::vector<uint32_t> Tracer::contributors(const Receivers& receivers, const glm::dvec3& eye, const glm::dvec3& light) const {
    const Occluders& occluders = impl_->occluders;
    const glm::dvec3 toSun = -light;
    if (toSun.z <= 0 || occluders.empty()) return {};
    const Occluders::Placement placement = occluders.placeAround(eye);
    std::vector<std::atomic<bool>> contributes(placement.instances.size());
    forEachPacket(receivers, toSun, [&](Packet& packet) {
        setEpsilon(packet, occluders, placement);
        std::vector<uint32_t> met;
        for (int i = 0; i < kLanes; ++i)
            if (packet.active[i]) occluders.blockers(placement, packet.start(i, 1), glm::vec3(toSun), met);
        for (const uint32_t placed : met) contributes[placed] = true;
    });
    std::vector<uint32_t> instances;
    for (uint32_t placed = 0; placed < contributes.size(); ++placed)
        if (contributes[placed]) instances.push_back(occluders.sceneInstance(placed));
    std::ranges::sort(instances);
    return instances;
}

}  // namespace dapple::truth
