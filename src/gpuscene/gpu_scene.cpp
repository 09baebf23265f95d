#include "gpuscene/gpu_scene.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace dapple::gpuscene {
namespace {

enum Attribute : GLuint { kPosition = 0, kNormal = 1, kUv = 2, kInstancePosition = 3, kInstanceYaw = 4 };
enum Binding : GLuint { kPositionBinding = 0, kNormalBinding = 1, kUvBinding = 2, kInstanceBinding = 3 };

uint32_t packNormal(const glm::vec3& n) { return glm::packSnorm3x10_1x2(glm::vec4(n, 0)); }

gl::Texture uploadTexture(const base::Image8& image) {
    const int levels = int(std::floor(std::log2(std::max(image.width, image.height)))) + 1;
    gl::Texture texture(GL_SRGB8_ALPHA8, image.width, image.height, 0, levels);
    glTextureSubImage2D(texture.name(), 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.texels.data());
    glGenerateTextureMipmap(texture.name());
    return texture;
}

}  // namespace

GpuScene::GpuScene(const scenegen::Scene& scene) : scene_(&scene), facts_(scene.facts()) {
    std::vector<glm::vec3> positions;
    std::vector<uint32_t> normals, indices;
    std::vector<glm::vec2> uvs;
    for (const scenegen::Prototype& prototype : scene.prototypes) {
        GpuPrototype gpu{prototype.box(), prototype.castsShadow, {}, prototype.triangles()};
        for (const scenegen::Mesh& mesh : prototype.meshes) {
            if (mesh.indices.empty()) continue;
            const scenegen::Material& material = scene.materials[mesh.material];
            gpu.meshes.push_back({uint32_t(indices.size()), uint32_t(mesh.indices.size()), int32_t(positions.size()),
                                  mesh.material, material.alphaTested, !material.doubleSided});
            (material.alphaTested ? hasAlpha_ : hasOpaque_) = true;
            hasOpaqueTextures_ |= !material.alphaTested && material.texture >= 0;
            positions.insert(positions.end(), mesh.positions.begin(), mesh.positions.end());
            for (const glm::vec3& n : mesh.normals) normals.push_back(packNormal(n));
            if (mesh.uvs.empty()) uvs.resize(positions.size());
            else uvs.insert(uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
            indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
        }
        prototypes_.push_back(std::move(gpu));
    }
    positions_ = gl::Buffer::of<glm::vec3>(positions);
    normals_ = gl::Buffer::of<uint32_t>(normals);
    uvs_ = gl::Buffer::of<glm::vec2>(uvs);
    indices_ = gl::Buffer::of<uint32_t>(indices);
    for (const scenegen::Texture& texture : scene.textures) textures_.push_back(uploadTexture(texture.image));
    colourSampler_ = gl::makeSampler({GL_LINEAR, true, GL_REPEAT});
    // Alpha is tested as the reference tests it: nearest texel of level 0.
    alphaSampler_ = gl::makeSampler({GL_NEAREST, false, GL_REPEAT});

    for (const scenegen::Instance& instance : scene.instances) {
        boxes_.push_back(scenegen::instanceBox(prototypes_[instance.prototype].box, instance));
        box_.extend(boxes_.back());
    }

    for (int i = 0; i < 4; ++i) {
        const auto set = Attributes(i);
        arrays_[i] = gl::makeVertexArray();
        const GLuint vao = arrays_[i].name();
        const auto attribute = [&](GLuint index, GLuint binding, GLint size, GLenum type, bool normalized, GLuint offset) {
            glEnableVertexArrayAttrib(vao, index);
            glVertexArrayAttribFormat(vao, index, size, type, normalized, offset);
            glVertexArrayAttribBinding(vao, index, binding);
        };
        attribute(kPosition, kPositionBinding, 3, GL_FLOAT, false, 0);
        glVertexArrayVertexBuffer(vao, kPositionBinding, positions_.name(), 0, sizeof(glm::vec3));
        if (set == Attributes::positionUv || set == Attributes::all) {
            attribute(kUv, kUvBinding, 2, GL_FLOAT, false, 0);
            glVertexArrayVertexBuffer(vao, kUvBinding, uvs_.name(), 0, sizeof(glm::vec2));
        }
        if (set == Attributes::positionNormal || set == Attributes::all) {
            attribute(kNormal, kNormalBinding, 4, GL_INT_2_10_10_10_REV, true, 0);
            glVertexArrayVertexBuffer(vao, kNormalBinding, normals_.name(), 0, sizeof(uint32_t));
        }
        attribute(kInstancePosition, kInstanceBinding, 4, GL_FLOAT, false, 0);
        attribute(kInstanceYaw, kInstanceBinding, 2, GL_FLOAT, false, offsetof(InstanceData, cosSinYaw));
        glVertexArrayBindingDivisor(vao, kInstanceBinding, 1);
        glVertexArrayElementBuffer(vao, indices_.name());
    }
}

size_t GpuScene::bufferBytes() const {
    return positions_.bytes() + normals_.bytes() + uvs_.bytes() + indices_.bytes();
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
    const GLuint vao = arrays_[int(attributes)].name();
    glVertexArrayVertexBuffer(vao, kInstanceBinding, list.buffer.name(), 0, sizeof(InstanceData));
    glBindVertexArray(vao);
    uint32_t material = ~0u;
    for (const DrawList::Range& range : list.ranges)
        for (const GpuMesh& mesh : prototypes_[range.prototype].meshes) {
            if (mesh.alphaTested != (bucket == Bucket::alphaTested)) continue;
            if (attributes != Attributes::position && mesh.material != material) setMaterial(material = mesh.material, program);
            (mesh.cullBack && faces == Faces::front ? glEnable : glDisable)(GL_CULL_FACE);
            glDrawElementsInstancedBaseVertexBaseInstance(
                GL_TRIANGLES, GLsizei(mesh.indexCount), GL_UNSIGNED_INT,
                reinterpret_cast<const void*>(size_t(mesh.firstIndex) * sizeof(uint32_t)), GLsizei(range.count),
                mesh.baseVertex, range.first);
            ++count.draws;
            count.triangles += size_t(mesh.indexCount / 3) * range.count;
        }
    glDisable(GL_CULL_FACE);
    return count;
}

}  // namespace dapple::gpuscene
