#include "gpuscene/gpu_scene.h"

#include "base/random.h"
#include "gl/context.h"
#include "gl/program.h"
#include "scenegen/lod/grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

namespace dapple::gpuscene {
namespace {

/// `triangles` triangles about the prototype's origin.
scenegen::Mesh fan(size_t triangles, uint32_t material, bool uvs) {
    scenegen::Mesh mesh;
    mesh.material = material;
    mesh.positions.push_back({0, 0, 0});
    for (size_t i = 0; i < triangles + 1; ++i) mesh.positions.push_back({std::cos(float(i)), std::sin(float(i)), 0.3f * float(i)});
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    if (uvs) mesh.uvs.assign(mesh.positions.size(), {0.5f, 0.5f});
    for (uint32_t i = 0; i < triangles; ++i) mesh.indices.insert(mesh.indices.end(), {0, i + 1, i + 2});
    return mesh;
}

/// Materials: 0 plain, 1 textured, 2 alpha-tested.
scenegen::Scene sceneOf(std::vector<std::vector<scenegen::Mesh>> prototypes) {
    scenegen::Scene scene;
    scene.textures.push_back({"t", {4, 2, 4, std::vector<uint8_t>(32, 200)}});
    scene.materials.resize(3);
    scene.materials[1].texture = scene.materials[2].texture = 0;
    scene.materials[2].alphaTested = true;
    for (auto& meshes : prototypes) {
        scene.prototypes.emplace_back().meshes = std::move(meshes);
        scene.instances.push_back({{0, 0, 0}, 1, 0, uint32_t(scene.prototypes.size() - 1)});
    }
    scene.views.emplace_back();
    return scene;
}

class GpuSceneTest : public ::testing::Test {
protected:
    GpuSceneTest() : context_(gl::Context::headless()) {}
    ~GpuSceneTest() override { EXPECT_NO_THROW(gl::checkErrors("test")); }
    gl::Context context_;
};

TEST_F(GpuSceneTest, BucketsFollowFromTheContent) {
    const auto expectBuckets = [](std::vector<scenegen::Mesh> meshes, bool opaque, bool alpha, bool textures) {
        const scenegen::Scene scene = sceneOf({std::move(meshes)});
        const GpuScene gpu(scene);
        EXPECT_EQ(gpu.has(Bucket::opaque), opaque);
        EXPECT_EQ(gpu.has(Bucket::alphaTested), alpha);
        EXPECT_EQ(gpu.hasOpaqueTextures(), textures);
        EXPECT_EQ(gpu.facts().alphaTested, alpha);
    };
    expectBuckets({fan(3, 0, false)}, true, false, false);
    expectBuckets({fan(3, 1, true)}, true, false, true);
    expectBuckets({fan(3, 2, true)}, false, true, false);
    expectBuckets({fan(3, 0, false), fan(2, 2, true)}, true, true, false);
    expectBuckets({fan(3, 0, false), scenegen::Mesh{{}, {}, {}, {}, 2}}, true, false, false);  // an empty mesh is nothing
    expectBuckets({}, false, false, false);
}

TEST_F(GpuSceneTest, BytesAreThoseOfTheContent) {
    const scenegen::Scene scene = sceneOf({{fan(3, 0, false)}, {fan(5, 1, true)}});
    const GpuScene gpu(scene);
    // Neither fan lies on a grid. Texture coordinates stand beside all vertices as soon as there is a texture. The four
    // buffers for the other kinds are empty, for which GL asks 16 bytes.
    EXPECT_EQ(gpu.bufferBytes(), (5 + 7) * (16 + 8) + 3 * (3 + 5) * 2 + 4 * 16);
    EXPECT_EQ(gpu.textureBytes(), (4u * 2 + 2 * 1 + 1) * 4);
    ASSERT_EQ(gpu.prototypes().size(), 2u);
    EXPECT_EQ(gpu.prototypes()[1].triangles, 5u);
    EXPECT_EQ(gpu.prototypes()[1].meshes[0].baseVertex, 5);
    EXPECT_EQ(gpu.prototypes()[1].meshes[0].indexOffset, 9u * 2);
}

/// Leaves and a fan on a grid; `compact` false: the same with a vertex far out that no triangle uses.
scenegen::Scene gridded(bool compact) {
    base::Random random(3, 0, 0);
    scenegen::Mesh leaves, wheel = fan(40, 1, true);
    for (int i = 0; i < 400; ++i) {
        leaves.positions.push_back({random.next(-3, 3), random.next(-3, 3), random.next(0, 3)});
        leaves.normals.push_back(glm::normalize(glm::vec3(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1))));
    }
    for (uint32_t leaf = 0; leaf < 100; ++leaf)
        for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) leaves.indices.push_back(4 * leaf + corner);
    for (scenegen::Mesh* mesh : {&leaves, &wheel}) {
        scenegen::snapToGrid(*mesh);
        if (compact) continue;
        mesh->positions.push_back({1e6f, 0, 0});
        mesh->normals.push_back({0, 0, 1});
        if (!mesh->uvs.empty()) mesh->uvs.push_back({0, 0});
    }
    return sceneOf({{leaves, wheel}});
}

// Oracle: the float vertices of the same positions.
TEST_F(GpuSceneTest, CompactVerticesGiveTheSameDepthToTheBit) {
    const gl::Program program("shadow/map_depth.vert", "");
    std::vector<float> depths[2];
    for (const bool compact : {false, true}) {
        const scenegen::Scene scene = gridded(compact);
        const GpuScene gpu(scene);
        for (const GpuMesh& mesh : gpu.prototypes()[0].meshes) EXPECT_EQ(mesh.packing.vertices != Packing::Vertices::floats, compact);
        EXPECT_EQ(gpu.prototypes()[0].meshes[0].packing.indices == Packing::Indices::quads, compact);
        DrawList list;
        list.data.push_back({{0.1f, 0.2f, 0}, 1.1f, {0.6f, 0.8f}});
        list.ranges.push_back({0, 0, 1});
        list.upload();
        gl::Texture depth(GL_DEPTH_COMPONENT32F, 256, 256);
        const gl::Framebuffer target = gl::makeFramebuffer({}, &depth);
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, target.name());
        glViewport(0, 0, 256, 256);
        glEnable(GL_DEPTH_TEST);
        const float one = 1;
        glClearBufferfv(GL_DEPTH, 0, &one);
        program.set("uLightClip", glm::mat4(0.2f, 0.03f, 0.01f, 0, 0.02f, 0.2f, 0.05f, 0, 0.01f, 0.1f, 0.05f, 0, 0, 0, 0.3f, 1));
        program.use();
        gpu.draw(list, Bucket::opaque, Attributes::position, program.name(), Faces::both);
        depths[compact].resize(256 * 256);
        glGetTextureImage(depth.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, 256 * 256 * 4, depths[compact].data());
        gl::resetState();
    }
    EXPECT_GT(std::count_if(depths[0].begin(), depths[0].end(), [](float d) { return d < 1; }), 5000);
    EXPECT_EQ(depths[0], depths[1]);
}

TEST_F(GpuSceneTest, OnlySingleSidedMaterialsCullTheirBacks) {
    // A tree's prototype is open by its leaves; its bark is closed, and its material says so.
    scenegen::Scene scene = sceneOf({{fan(3, 0, false), fan(3, 1, true)}});
    scene.materials[0].doubleSided = false;
    const GpuScene gpu(scene);
    EXPECT_TRUE(gpu.prototypes()[0].meshes[0].cullBack);
    EXPECT_FALSE(gpu.prototypes()[0].meshes[1].cullBack);
}

/// 300 instances of three prototypes and of one without triangles, strewn about.
scenegen::Scene strewn() {
    scenegen::Scene scene = sceneOf({{fan(3, 0, false)}, {fan(5, 1, true), fan(2, 2, true)}, {}, {fan(7, 2, true)}});
    scene.instances.clear();
    base::Random random(9, 0, 0);
    for (int i = 0; i < 300; ++i)
        scene.instances.push_back({{random.next(-50, 50), random.next(-50, 50), random.next(0, 5)}, random.next(0.5f, 2), random.next(0, 6.28f), uint32_t(i % 4)});
    return scene;
}

/// Distance from a point to a box by its corners' coordinates, axis by axis.
double distanceTo(const base::Box& box, const glm::dvec3& p) {
    double squares = 0;
    for (int k = 0; k < 3; ++k) {
        const double outside = p[k] < double(box.lo[k]) ? double(box.lo[k]) - p[k] : p[k] > double(box.hi[k]) ? p[k] - double(box.hi[k]) : 0;
        squares += outside * outside;
    }
    return std::sqrt(squares);
}

TEST_F(GpuSceneTest, CollectFiltersGroupsAndOrdersNearestFirst) {
    const scenegen::Scene scene = strewn();
    const GpuScene gpu(scene);
    const glm::dvec3 eye(3.25, -60.5, 2.125);
    DrawList list;
    gpu.collect(eye, [](uint32_t i) { return i % 3 != 0; }, list);

    std::set<uint32_t> expected;
    for (uint32_t i = 0; i < 300; ++i)
        if (i % 3 != 0 && i % 4 != 2) expected.insert(i);  // prototype 2 has nothing to draw
    EXPECT_EQ(std::set<uint32_t>(list.items.begin(), list.items.end()), expected);
    ASSERT_EQ(list.items.size(), expected.size());
    ASSERT_EQ(list.data.size(), expected.size());

    ASSERT_EQ(list.ranges.size(), 3u);  // one per prototype
    uint32_t next = 0;
    double lastNearest = 0;
    for (const DrawList::Range& range : list.ranges) {
        EXPECT_EQ(range.first, next);
        double last = 0;
        for (uint32_t k = range.first; k < range.first + range.count; ++k) {
            const uint32_t i = list.items[k];
            EXPECT_EQ(scene.instances[i].prototype, range.part);
            const double distance = distanceTo(gpu.instanceBoxes()[i], eye);
            EXPECT_GE(distance, last - 1e-9);
            if (k == range.first) {
                EXPECT_GE(distance, lastNearest - 1e-9);
                lastNearest = distance;
            }
            last = distance;
        }
        next += range.count;
    }
    EXPECT_EQ(next, list.data.size());

    for (size_t k = 0; k < list.data.size(); ++k) {
        const scenegen::Instance& instance = scene.instances[list.items[k]];
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_EQ(list.data[k].position[axis], float(double(instance.translation[axis]) - eye[axis]));
        EXPECT_EQ(list.data[k].scale, instance.scale);
        EXPECT_NEAR(std::atan2(std::sin(double(instance.yaw)), std::cos(double(instance.yaw))),
                    std::atan2(double(list.data[k].cosSinYaw.y), double(list.data[k].cosSinYaw.x)), 1e-6);
    }
    std::vector<InstanceData> uploaded(list.data.size());
    glGetNamedBufferSubData(list.buffer.name(), 0, GLsizeiptr(uploaded.size() * sizeof(InstanceData)), uploaded.data());
    EXPECT_EQ(std::memcmp(uploaded.data(), list.data.data(), uploaded.size() * sizeof(InstanceData)), 0);

    gpu.collect(eye, [](uint32_t) { return false; }, list);
    EXPECT_TRUE(list.data.empty());
    EXPECT_TRUE(list.items.empty());
    EXPECT_TRUE(list.ranges.empty());
}

TEST_F(GpuSceneTest, InstanceBoxesHoldTheirVerticesTightly) {
    const scenegen::Scene scene = strewn();
    const GpuScene gpu(scene);
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const scenegen::Instance& instance = scene.instances[i];
        const base::Box& box = gpu.instanceBoxes()[i];
        EXPECT_EQ(box.empty(), instance.prototype == 2);
        for (const scenegen::Mesh& mesh : scene.prototypes[instance.prototype].meshes)
            for (const glm::vec3& p : mesh.positions) {
                const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw)), k = double(instance.scale);
                const glm::dvec3 q = glm::dvec3(instance.translation) + k * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
                EXPECT_LT(distanceTo(box, q), 1e-5);
            }
    }
}

// The draw's own counts against the GPU's count of primitives.
TEST_F(GpuSceneTest, DrawCountsWhatReachesTheGpu) {
    const scenegen::Scene scene = strewn();
    const GpuScene gpu(scene);
    DrawList list;
    gpu.collect({0, 0, 0}, [](uint32_t) { return true; }, list);
    const gl::Texture target(GL_RGBA8, 4, 4);
    const gl::Texture* targets[] = {&target};
    const gl::Framebuffer framebuffer = gl::makeFramebuffer(targets, nullptr);
    gl::resetState();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    const char* source = "#version 450 core\nlayout(location = 0) in vec3 a; out gl_PerVertex { vec4 gl_Position; };"
                         "void main() { gl_Position = vec4(a, 1); }";
    const GLuint program = glCreateShaderProgramv(GL_VERTEX_SHADER, 1, &source);
    glUseProgram(program);
    GLuint query = 0;
    glGenQueries(1, &query);
    const auto expectCount = [&](Bucket bucket, size_t draws, size_t triangles) {
        glBeginQuery(GL_PRIMITIVES_GENERATED, query);
        const DrawCount count = gpu.draw(list, bucket, Attributes::position, program);
        glEndQuery(GL_PRIMITIVES_GENERATED);
        GLuint primitives = 0;
        glGetQueryObjectuiv(query, GL_QUERY_RESULT, &primitives);
        EXPECT_EQ(count.draws, draws);
        EXPECT_EQ(count.triangles, triangles);
        EXPECT_EQ(primitives, triangles);
    };
    // 75 instances of each prototype; meshes of 3 and 5 opaque, of 2 and 7 alpha-tested triangles.
    expectCount(Bucket::opaque, 2, 75 * (3 + 5));
    expectCount(Bucket::alphaTested, 2, 75 * (2 + 7));
    glDeleteQueries(1, &query);
    glDeleteProgram(program);
}

}  // namespace
}  // namespace dapple::gpuscene
