#include "gpuscene/gpu_scene.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace dapple::gpuscene {
namespace {

enum Attribute : GLuint { kPosition = 0, kNormal = 1, kUv = 2, kInstancePosition = 3, kInstanceYaw = 4 };
enum Binding : GLuint { kVertexBinding = 0, kUvBinding = 2, kInstanceBinding = 3 };

/// Appends `values` as bytes; the result is where they begin.
template <class T>
size_t append(std::vector<uint8_t>& bytes, const std::vector<T>& values) {
    const size_t begin = (bytes.size() + sizeof(T) - 1) / sizeof(T) * sizeof(T);
    bytes.resize(begin + values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(&bytes[begin], values.data(), values.size() * sizeof(T));
    return begin;
}

std::vector<uint16_t> quadIndices(size_t quads) {
    std::vector<uint16_t> indices;
    for (size_t q = 0; q < quads; ++q)
        for (const size_t corner : {0, 1, 2, 0, 2, 3}) indices.push_back(uint16_t(4 * q + corner));
    return indices;
}

gl::Texture uploadTexture(const base::Image8& image) {
    const int levels = int(std::floor(std::log2(std::max(image.width, image.height)))) + 1;
    gl::Texture texture(GL_SRGB8_ALPHA8, image.width, image.height, 0, levels);
    glTextureSubImage2D(texture.name(), 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.texels.data());
    glGenerateTextureMipmap(texture.name());
    return texture;
}

}  // namespace

GpuScene::GpuScene(const scenegen::Scene& scene) : scene_(&scene), facts_(scene.facts()) {
    std::vector<FloatVertex> floats;
    std::vector<CompactVertex> compacts;
    std::vector<glm::vec2> uvs;
    std::vector<uint32_t> halfUvs;
    std::vector<uint8_t> indices;
    size_t quads = 0;  // of the largest mesh without indices of its own
    for (const scenegen::Prototype& prototype : scene.prototypes)
        for (const scenegen::Mesh& mesh : prototype.meshes)
            if (choosePacking(mesh).indices == Packing::Indices::quads) quads = std::max(quads, mesh.indices.size() / 6);
    append(indices, quadIndices(quads));
    for (const scenegen::Prototype& prototype : scene.prototypes) {
        GpuPrototype gpu{prototype.box(), prototype.castsShadow, {}, prototype.triangles()};
        for (const scenegen::Mesh& mesh : prototype.meshes) {
            if (mesh.indices.empty()) continue;
            const scenegen::Material& material = scene.materials[mesh.material];
            const Packing packing = choosePacking(mesh);
            GpuMesh m{packing, 0, uint32_t(mesh.indices.size()), int32_t(packing.compact ? compacts.size() : floats.size()), mesh.material, material.alphaTested, !material.doubleSided};
            if (packing.indices == Packing::Indices::bits32) m.indexOffset = append(indices, mesh.indices);
            if (packing.indices == Packing::Indices::bits16) m.indexOffset = append(indices, std::vector<uint16_t>(mesh.indices.begin(), mesh.indices.end()));
            (material.alphaTested ? hasAlpha_ : hasOpaque_) = true;
            hasOpaqueTextures_ |= !material.alphaTested && material.texture >= 0;
            for (size_t v = 0; v < mesh.positions.size(); ++v)
                if (packing.compact) compacts.emplace_back(packing, mesh.positions[v], mesh.normals[v]);
                else floats.emplace_back(mesh.positions[v], mesh.normals[v]);
            if (!scene.textures.empty()) {  // parallel to the vertices, whether this mesh has any or not
                for (const glm::vec2& uv : mesh.uvs)
                    if (packing.compact) halfUvs.push_back(glm::packHalf2x16(uv));
                    else uvs.push_back(uv);
                halfUvs.resize(compacts.size());
                uvs.resize(floats.size());
            }
            gpu.meshes.push_back(m);
        }
        prototypes_.push_back(std::move(gpu));
    }
    vertices_[0] = gl::Buffer::of<FloatVertex>(floats);
    vertices_[1] = gl::Buffer::of<CompactVertex>(compacts);
    uvs_[0] = gl::Buffer::of<glm::vec2>(uvs);
    uvs_[1] = gl::Buffer::of<uint32_t>(halfUvs);
    indices_ = gl::Buffer::of<uint8_t>(indices);
    for (const scenegen::Texture& texture : scene.textures) textures_.push_back(uploadTexture(texture.image));
    colourSampler_ = gl::makeSampler({GL_LINEAR, true, GL_REPEAT});
    // Alpha is tested as the reference tests it: nearest texel of level 0.
    alphaSampler_ = gl::makeSampler({GL_NEAREST, false, GL_REPEAT});

    for (const scenegen::Instance& instance : scene.instances) {
        boxes_.push_back(scenegen::instanceBox(prototypes_[instance.prototype].box, instance));
        box_.extend(boxes_.back());
    }

    for (const bool compact : {false, true})
        for (int i = 0; i < 4; ++i) {
            const auto set = Attributes(i);
            gl::VertexArray& array = arrays_[compact][i] = gl::makeVertexArray();
            const GLuint vao = array.name();
            const auto attribute = [&](GLuint index, GLuint binding, GLint size, GLenum type, bool normalized, GLuint offset) {
                glEnableVertexArrayAttrib(vao, index);
                glVertexArrayAttribFormat(vao, index, size, type, normalized, offset);
                glVertexArrayAttribBinding(vao, index, binding);
            };
            attribute(kPosition, kVertexBinding, 3, compact ? GL_UNSIGNED_SHORT : GL_FLOAT, false, 0);
            glVertexArrayVertexBuffer(vao, kVertexBinding, vertices_[compact].name(), 0, compact ? sizeof(CompactVertex) : sizeof(FloatVertex));
            if (set == Attributes::positionUv || set == Attributes::all) {
                attribute(kUv, kUvBinding, 2, compact ? GL_HALF_FLOAT : GL_FLOAT, false, 0);
                glVertexArrayVertexBuffer(vao, kUvBinding, uvs_[compact].name(), 0, compact ? sizeof(uint32_t) : sizeof(glm::vec2));
            }
            if (set == Attributes::positionNormal || set == Attributes::all)
                attribute(kNormal, kVertexBinding, 2, compact ? GL_BYTE : GL_SHORT, true, compact ? offsetof(CompactVertex, normal) : offsetof(FloatVertex, normal));
            attribute(kInstancePosition, kInstanceBinding, 4, GL_FLOAT, false, 0);
            attribute(kInstanceYaw, kInstanceBinding, 2, GL_FLOAT, false, offsetof(InstanceData, cosSinYaw));
            glVertexArrayBindingDivisor(vao, kInstanceBinding, 1);
            glVertexArrayElementBuffer(vao, indices_.name());
        }
}

size_t GpuScene::bufferBytes() const {
    return vertices_[0].bytes() + vertices_[1].bytes() + uvs_[0].bytes() + uvs_[1].bytes() + indices_.bytes();
}

size_t GpuScene::textureBytes() const {
    size_t sum = 0;
    for (const gl::Texture& texture : textures_) sum += texture.bytes();
    return sum;
}

void GpuScene::collect(const glm::dvec3& eye, const std::function<bool(uint32_t)>& keep, DrawList& list) const {
    struct Item {
        uint32_t instance, prototype;
        double distance;
    };
    std::vector<Item> items;
    for (uint32_t i = 0; i < boxes_.size(); ++i) {
        if (boxes_[i].empty() || !keep(i)) continue;
        const glm::dvec3 nearest = glm::clamp(eye, glm::dvec3(boxes_[i].lo), glm::dvec3(boxes_[i].hi));
        items.push_back({i, scene_->instances[i].prototype, glm::distance(nearest, eye)});
    }
    // Nearest first within a prototype, and prototypes by their nearest instance: early depth rejection.
    std::vector<double> nearestOf(prototypes_.size(), 1e300);
    for (const Item& item : items) nearestOf[item.prototype] = std::min(nearestOf[item.prototype], item.distance);
    std::sort(items.begin(), items.end(), [&](const Item& a, const Item& b) {
        if (a.prototype != b.prototype) {
            const double da = nearestOf[a.prototype], db = nearestOf[b.prototype];
            return da != db ? da < db : a.prototype < b.prototype;
        }
        return a.distance != b.distance ? a.distance < b.distance : a.instance < b.instance;
    });
    list.data.clear();
    list.instances.clear();
    list.ranges.clear();
    for (const Item& item : items) {
        const scenegen::Instance& instance = scene_->instances[item.instance];
        if (list.ranges.empty() || list.ranges.back().prototype != item.prototype)
            list.ranges.push_back({item.prototype, uint32_t(list.data.size()), 0});
        ++list.ranges.back().count;
        list.data.push_back({glm::vec3(glm::dvec3(instance.translation) - eye), instance.scale,
                             {float(std::cos(double(instance.yaw))), float(std::sin(double(instance.yaw)))}});
        list.instances.push_back(item.instance);
    }
    list.upload();
}

void GpuScene::setMaterial(uint32_t index, GLuint program) const {
    const scenegen::Material& material = scene_->materials[index];
    const bool textured = material.texture >= 0;
    glProgramUniform4f(program, glGetUniformLocation(program, "uAlbedo"), material.albedo.r, material.albedo.g,
                       material.albedo.b, material.specular);
    glProgramUniform1i(program, glGetUniformLocation(program, "uTextured"), textured);
    if (!textured) return;
    const GLuint name = textures_[size_t(material.texture)].name();
    glBindTextureUnit(0, name);
    glBindSampler(0, colourSampler_.name());
    glBindTextureUnit(1, name);
    glBindSampler(1, alphaSampler_.name());
}

DrawCount GpuScene::draw(const DrawList& list, Bucket bucket, Attributes attributes, GLuint program, Faces faces) const {
    DrawCount count;
    for (const bool compact : {false, true})
        glVertexArrayVertexBuffer(arrays_[compact][int(attributes)].name(), kInstanceBinding, list.buffer.name(), 0, sizeof(InstanceData));
    const GLint gridLocation = glGetUniformLocation(program, "uGrid");
    uint32_t material = ~0u;
    for (const DrawList::Range& range : list.ranges)
        for (const GpuMesh& mesh : prototypes_[range.prototype].meshes) {
            if (mesh.alphaTested != (bucket == Bucket::alphaTested)) continue;
            if (attributes != Attributes::position && mesh.material != material) setMaterial(material = mesh.material, program);
            (mesh.cullBack && faces == Faces::front ? glEnable : glDisable)(GL_CULL_FACE);
            glBindVertexArray(arrays_[mesh.packing.compact][int(attributes)].name());
            glProgramUniform4fv(program, gridLocation, 1, &mesh.packing.grid.x);
            glDrawElementsInstancedBaseVertexBaseInstance(
                GL_TRIANGLES, GLsizei(mesh.indexCount), mesh.packing.indices == Packing::Indices::bits32 ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT,
                reinterpret_cast<const void*>(mesh.indexOffset), GLsizei(range.count), mesh.baseVertex, range.first);
            ++count.draws;
            count.triangles += size_t(mesh.indexCount / 3) * range.count;
        }
    glDisable(GL_CULL_FACE);
    return count;
}

}  // namespace dapple::gpuscene
