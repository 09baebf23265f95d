#include "gpuscene/gpu_scene.h"

#include "gpuscene/clusters.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

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

/// In the order of scenegen::Wrap.
constexpr std::array<GLenum, 3> kWraps{GL_REPEAT, GL_CLAMP_TO_EDGE, GL_MIRRORED_REPEAT};

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
    std::vector<FlatVertex> flats;
    std::vector<uint8_t> uvs[kKinds];
    std::vector<uint8_t> indices;
    size_t quads = 0;  // of the largest mesh without indices of its own
    std::vector<Packing> packings;  // of all meshes, in their order: finding one reads the whole mesh
    for (const scenegen::Prototype& prototype : scene.prototypes)
        for (const scenegen::Mesh& mesh : prototype.meshes) {
            packings.push_back(choosePacking(mesh));
            if (packings.back().indices == Packing::Indices::quads) quads = std::max(quads, mesh.indices.size() / 6);
        }
    auto nextPacking = packings.begin();
    append(indices, quadIndices(quads));
    for (const scenegen::Prototype& prototype : scene.prototypes) {
        GpuPrototype gpu{prototype.box(), prototype.castsShadow, {}, prototype.triangles()};
        for (const scenegen::Mesh& mesh : prototype.meshes) {
            const Packing packing = *nextPacking++;
            if (mesh.indices.empty()) continue;
            const scenegen::Material& material = scene.materials[mesh.material];
            const auto kind = size_t(packing.vertices);
            const size_t stored[kKinds] = {floats.size(), compacts.size(), flats.size()};
            GpuMesh m{packing, 0, uint32_t(mesh.indices.size()), int32_t(stored[kind]), mesh.material, material.alphaTested, !material.doubleSided};
            const std::vector<uint32_t> drawn = packing.slivers ? drawnIndices(mesh) : std::vector<uint32_t>();
            const std::vector<uint32_t>& own = packing.slivers ? drawn : mesh.indices;
            if (packing.indices == Packing::Indices::bits32) m.indexOffset = append(indices, own);
            if (packing.indices == Packing::Indices::bits16) m.indexOffset = append(indices, std::vector<uint16_t>(own.begin(), own.end()));
            (material.alphaTested ? hasAlpha_ : hasOpaque_) = true;
            hasOpaqueTextures_ |= !material.alphaTested && material.texture >= 0;
            for (size_t v = 0; v < mesh.positions.size(); ++v)
                if (packing.vertices == Packing::Vertices::flat) flats.emplace_back(packing, mesh.positions[v]);
                else if (packing.vertices == Packing::Vertices::compact) compacts.emplace_back(packing, mesh.positions[v], mesh.normals[v]);
                else floats.emplace_back(mesh.positions[v], mesh.normals[v]);
            if (!scene.textures.empty()) {  // parallel to the vertices, whether this mesh has any or not
                std::vector<uint32_t> halves;
                for (const glm::vec2& uv : mesh.uvs) halves.push_back(glm::packHalf2x16(uv));
                if (packing.vertices == Packing::Vertices::floats) append(uvs[kind], mesh.uvs);
                else append(uvs[kind], halves);
                uvs[kind].resize((stored[kind] + mesh.positions.size()) * (packing.vertices == Packing::Vertices::floats ? sizeof(glm::vec2) : sizeof(uint32_t)));
            }
            gpu.meshes.push_back(m);
        }
        prototypes_.push_back(std::move(gpu));
    }
    vertices_[0] = gl::Buffer::of<FloatVertex>(floats);
    vertices_[1] = gl::Buffer::of<CompactVertex>(compacts);
    vertices_[2] = gl::Buffer::of<FlatVertex>(flats);
    for (size_t kind = 0; kind < kKinds; ++kind) uvs_[kind] = gl::Buffer::of<uint8_t>(uvs[kind]);
    indices_ = gl::Buffer::of<uint8_t>(indices);
    for (const scenegen::Texture& texture : scene.textures) textures_.push_back(uploadTexture(texture.image));
    // Alpha is tested as the reference tests it: nearest texel of level 0.
    for (size_t i = 0; i < 9; ++i) {
        samplers_[0][i] = gl::makeSampler({.filter = GL_LINEAR, .mipmaps = true, .wrap = kWraps[i / 3], .wrapT = kWraps[i % 3]});
        samplers_[1][i] = gl::makeSampler({.filter = GL_NEAREST, .wrap = kWraps[i / 3], .wrapT = kWraps[i % 3]});
    }

    std::vector<Part> parts;
    for (uint32_t p = 0; p < prototypes_.size(); ++p) parts.push_back({p, prototypes_[p].box, prototypes_[p].castsShadow, prototypes_[p].triangles, prototypes_[p].meshes});
    items_.try_emplace(0, scene, std::move(parts));
    instancesMoved();

    struct Layout {
        GLenum position, uv, normal;
        GLsizei vertexBytes, uvBytes;
        GLuint normalOffset;
    };
    constexpr Layout kLayouts[kKinds] = {{GL_FLOAT, GL_FLOAT, GL_SHORT, sizeof(FloatVertex), sizeof(glm::vec2), offsetof(FloatVertex, normal)},
                                         {GL_UNSIGNED_SHORT, GL_HALF_FLOAT, GL_BYTE, sizeof(CompactVertex), sizeof(uint32_t), offsetof(CompactVertex, normal)},
                                         {GL_UNSIGNED_SHORT, GL_HALF_FLOAT, GL_NONE, sizeof(FlatVertex), sizeof(uint32_t), 0}};
    // What a vertex without a normal reads in its place: outside the octahedral square.
    glVertexAttrib2f(kNormal, 2, 2);
    for (size_t kind = 0; kind < kKinds; ++kind)
        for (int i = 0; i < 4; ++i) {
            const auto set = Attributes(i);
            const Layout& layout = kLayouts[kind];
            const GLuint vao = (arrays_[kind][i] = gl::makeVertexArray()).name();
            const auto attribute = [&](GLuint index, GLuint binding, GLint size, GLenum type, bool normalized, GLuint offset) {
                glEnableVertexArrayAttrib(vao, index);
                glVertexArrayAttribFormat(vao, index, size, type, normalized, offset);
                glVertexArrayAttribBinding(vao, index, binding);
            };
            attribute(kPosition, kVertexBinding, 3, layout.position, false, 0);
            glVertexArrayVertexBuffer(vao, kVertexBinding, vertices_[kind].name(), 0, layout.vertexBytes);
            if (set == Attributes::positionUv || set == Attributes::all) {
                attribute(kUv, kUvBinding, 2, layout.uv, false, 0);
                glVertexArrayVertexBuffer(vao, kUvBinding, uvs_[kind].name(), 0, layout.uvBytes);
            }
            if ((set == Attributes::positionNormal || set == Attributes::all) && layout.normal != GL_NONE)
                attribute(kNormal, kVertexBinding, 2, layout.normal, true, layout.normalOffset);
            attribute(kInstancePosition, kInstanceBinding, 4, GL_FLOAT, false, 0);
            attribute(kInstanceYaw, kInstanceBinding, 2, GL_FLOAT, false, offsetof(InstanceData, cosSinYaw));
            glVertexArrayBindingDivisor(vao, kInstanceBinding, 1);
            glVertexArrayElementBuffer(vao, indices_.name());
        }
}

void GpuScene::instancesMoved() {
    for (auto& [cluster, items] : items_) items.instancesMoved();
    box_ = {};
    for (const base::Box& box : instanceBoxes()) box_.extend(box);
}

const Items& GpuScene::items(uint32_t clusterTriangles) const {
    const auto large = [&](const GpuPrototype& prototype) { return clusterTriangles > 0 && prototype.triangles > clusterTriangles; };
    if (std::ranges::none_of(prototypes_, large)) return items_.at(0);
    if (const auto made = items_.find(clusterTriangles); made != items_.end()) return made->second;
    std::vector<Part> parts;
    std::vector<uint8_t> more;
    const size_t before = (indices_.bytes() + 3) / 4 * 4;
    for (uint32_t p = 0; p < prototypes_.size(); ++p)
        if (large(prototypes_[p])) std::ranges::move(clusters(scene_->prototypes[p], prototypes_[p], p, clusterTriangles, before, more), std::back_inserter(parts));
        else parts.push_back(items_.at(0).parts()[p]);
    gl::Buffer grown(before + more.size(), nullptr, true);
    glCopyNamedBufferSubData(indices_.name(), grown.name(), 0, 0, GLsizeiptr(indices_.bytes()));
    glNamedBufferSubData(grown.name(), GLintptr(before), GLsizeiptr(more.size()), more.data());
    indices_ = std::move(grown);
    for (const auto& arrays : arrays_)
        for (const gl::VertexArray& array : arrays) glVertexArrayElementBuffer(array.name(), indices_.name());
    return items_.try_emplace(clusterTriangles, *scene_, std::move(parts)).first->second;
}

size_t GpuScene::bufferBytes() const {
    size_t sum = indices_.bytes();
    for (size_t kind = 0; kind < kKinds; ++kind) sum += vertices_[kind].bytes() + uvs_[kind].bytes();
    return sum;
}

size_t GpuScene::textureBytes() const {
    size_t sum = 0;
    for (const gl::Texture& texture : textures_) sum += texture.bytes();
    return sum;
}

void GpuScene::collect(const glm::dvec3& eye, const std::function<bool(uint32_t)>& keep, DrawList& list) const {
    std::vector<uint32_t> kept;
    for (uint32_t i = 0; i < instanceBoxes().size(); ++i)
        if (!instanceBoxes()[i].empty() && keep(i)) kept.push_back(i);
    items().collect(eye, kept, list);
}

/// Where a program has them.
struct GpuScene::Uniforms {
    explicit Uniforms(GLuint p)
        : program(p), grid(glGetUniformLocation(p, "uGrid")), albedo(glGetUniformLocation(p, "uAlbedo")), textured(glGetUniformLocation(p, "uTextured")),
          cutoff(glGetUniformLocation(p, "uAlphaCutoff")) {}
    GLuint program;
    GLint grid, albedo, textured, cutoff;
};

void GpuScene::setMaterial(uint32_t index, const Uniforms& uniforms) const {
    const scenegen::Material& material = scene_->materials[index];
    const bool textured = material.texture >= 0;
    glProgramUniform4f(uniforms.program, uniforms.albedo, material.albedo.r, material.albedo.g, material.albedo.b, material.specular);
    glProgramUniform1i(uniforms.program, uniforms.textured, textured);
    if (!textured) return;
    glProgramUniform1f(uniforms.program, uniforms.cutoff, material.alphaCutoff);
    const scenegen::Texture& texture = scene_->textures[size_t(material.texture)];
    for (GLuint unit = 0; unit < 2; ++unit) {
        glBindTextureUnit(unit, textures_[size_t(material.texture)].name());
        glBindSampler(unit, samplers_[unit][size_t(texture.wrapU) * 3 + size_t(texture.wrapV)].name());
    }
}

DrawCount GpuScene::draw(const DrawList& list, Bucket bucket, Attributes attributes, GLuint program, Faces faces, bool readBack) const {
    DrawCount count;
    if (list.ranges.empty()) return count;
    std::vector<IndirectCommand> commands;
    if (list.commands && readBack) {
        commands.resize(list.commands.bytes() / sizeof(IndirectCommand));
        glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
        glGetNamedBufferSubData(list.commands.name(), 0, GLsizeiptr(commands.size() * sizeof(IndirectCommand)), commands.data());
    }
    for (const auto& arrays : arrays_)
        glVertexArrayVertexBuffer(arrays[int(attributes)].name(), kInstanceBinding, list.buffer.name(), 0, sizeof(InstanceData));
    if (list.commands) glBindBuffer(GL_DRAW_INDIRECT_BUFFER, list.commands.name());
    const Uniforms uniforms(program);
    const std::span<const Part> parts = list.parts.empty() ? items().parts() : list.parts;
    uint32_t material = ~0u;
    for (const DrawList::Range& range : list.ranges) {
        size_t command = range.first;
        for (const GpuMesh& mesh : parts[range.part].meshes) {
            const size_t own = command++;
            if (mesh.alphaTested != (bucket == Bucket::alphaTested)) continue;
            if (attributes != Attributes::position && mesh.material != material) setMaterial(material = mesh.material, uniforms);
            (mesh.cullBack && faces == Faces::front ? glEnable : glDisable)(GL_CULL_FACE);
            glBindVertexArray(arrays_[size_t(mesh.packing.vertices)][int(attributes)].name());
            glProgramUniform4fv(program, uniforms.grid, 1, &mesh.packing.grid.x);
            const GLenum type = mesh.packing.indices == Packing::Indices::bits32 ? GL_UNSIGNED_INT : GL_UNSIGNED_SHORT;
            if (list.commands)
                glDrawElementsIndirect(GL_TRIANGLES, type, reinterpret_cast<const void*>(own * sizeof(IndirectCommand)));
            else
                glDrawElementsInstancedBaseVertexBaseInstance(GL_TRIANGLES, GLsizei(mesh.indexCount), type, reinterpret_cast<const void*>(mesh.indexOffset),
                                                              GLsizei(range.count), mesh.baseVertex, range.first);
            ++count.draws;
            count.triangles += commands.empty() ? size_t(mesh.indexCount / 3) * range.count : size_t(commands[own].indices / 3) * commands[own].instances;
        }
    }
    glDisable(GL_CULL_FACE);
    return count;
}

}  // namespace dapple::gpuscene
