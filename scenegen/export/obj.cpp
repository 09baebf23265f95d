#include "scenegen/export/obj.h"

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "base/file_name.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostTriangles = 50'000'000;  // about 6 GiB of text

/// The image of each texture beside the .obj.
std::vector<std::string> imageNames(const Scene& scene, const fs::path& path) {
    std::vector<std::string> images;
    for (size_t i = 0; i < scene.textures.size(); ++i)
        images.push_back(fmt::format("{}-{}_{}.png", path.stem().string(), base::fileName(scene.textures[i].name), i));
    return images;
}

/// Names in OBJ end at a blank.
std::string word(std::string name) {
    for (char& c : name)
        if (c <= ' ' || c == '/') c = '_';
    return name.empty() ? "_" : name;
}

/// IEC 61966-2-1; what programs take the colours of MTL files for.
float srgbFromLinear(float v) { return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f; }

/// -clamp holds for both directions, and nothing says "mirror".
std::string mapOptions(const Scene& scene, const Texture& texture) {
    if (texture.wrapU == Wrap::clamp && texture.wrapV == Wrap::clamp) return "-clamp on ";
    if (texture.wrapU != Wrap::repeat || texture.wrapV != Wrap::repeat)
        base::logWarning(fmt::format("scene {}: OBJ cannot say how the texture '{}' is repeated; it is repeated as it is", scene.name, texture.name));
    return {};
}

std::string materialName(const Scene& scene, size_t index) { return fmt::format("{}_{}", word(scene.materials[index].name), index); }

std::string materials(const Scene& scene, const fs::path& path) {
    const std::vector<std::string> images = imageNames(scene, path);
    for (size_t i = 0; i < images.size(); ++i) base::writePng(path.parent_path() / images[i], scene.textures[i].image);
    std::string mtl;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& m = scene.materials[i];
        mtl += fmt::format("newmtl {}\nKd {} {} {}\nKs {} {} {}\nNs {}\n", materialName(scene, i), srgbFromLinear(m.albedo.r),
                           srgbFromLinear(m.albedo.g), srgbFromLinear(m.albedo.b), m.specular, m.specular, m.specular, m.shininess);
        if (m.texture >= 0) {
            const std::string map = mapOptions(scene, scene.textures[size_t(m.texture)]) + images[size_t(m.texture)];
            mtl += fmt::format("map_Kd {}\n", map);
            if (m.alphaTested) mtl += fmt::format("map_d {}\n", map);
            if (m.alphaTested && m.alphaCutoff > kAlphaCutoff) mtl += fmt::format("d {}\n", kAlphaCutoff / m.alphaCutoff);
            if (m.alphaTested && m.alphaCutoff < kAlphaCutoff)
                base::logWarning(fmt::format("scene {}: OBJ cannot say that '{}' is cut out below one half; it is cut out at one half", scene.name, m.name));
        }
        mtl += '\n';
    }
    return mtl;
}

}  // namespace

std::vector<fs::path> objFiles(const Scene& scene, const fs::path& path) {
    std::vector<fs::path> files{path, fs::path(path).replace_extension(".mtl")};
    for (const std::string& image : imageNames(scene, path)) files.push_back(path.parent_path() / image);
    return files;
}

void writeObj(const Scene& scene, const fs::path& path) {
    if (const size_t triangles = scene.facts().triangles; triangles > kMostTriangles)
        throw base::UsageError(fmt::format("scene {}: an OBJ of {} triangles would be too large; write .glb, which keeps instances", scene.name, triangles));
    std::string text = fmt::format("# {} triangles of scene {}, y up, metres\nmtllib {}.mtl\n", scene.facts().triangles, scene.name, path.stem().string());
    auto out = std::back_inserter(text);
    size_t vertices = 1, uvs = 1;  // OBJ counts from 1
    for (const Instance& instance : scene.instances) {
        const Prototype& prototype = scene.prototypes[instance.prototype];
        const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw));
        const auto turned = [&](const glm::dvec3& p) { return glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z); };
        fmt::format_to(out, "o {}\n", word(prototype.name));
        for (const Mesh& mesh : prototype.meshes) {
            for (const glm::vec3& p : mesh.positions) {
                const glm::vec3 q(glm::dvec3(instance.translation) + double(instance.scale) * turned(p));
                fmt::format_to(out, "v {} {} {}\n", q.x, q.z, -q.y);
            }
            for (const glm::vec3& n : mesh.normals) {
                const glm::vec3 q(turned(n));
                fmt::format_to(out, "vn {} {} {}\n", q.x, q.z, -q.y);
            }
            for (const glm::vec2& uv : mesh.uvs) fmt::format_to(out, "vt {} {}\n", uv.x, 1 - uv.y);  // v grows upwards
            fmt::format_to(out, "usemtl {}\n", materialName(scene, mesh.material));
            for (size_t i = 0; i < mesh.indices.size(); i += 3) {
                text += 'f';
                for (size_t k = 0; k < 3; ++k) {
                    const size_t at = mesh.indices[i + k];
                    if (mesh.uvs.empty()) fmt::format_to(out, " {0}//{0}", vertices + at);
                    else fmt::format_to(out, " {0}/{1}/{0}", vertices + at, uvs + at);
                }
                text += '\n';
            }
            vertices += mesh.positions.size();
            uvs += mesh.uvs.size();
        }
    }
    base::writeFile(fs::path(path).replace_extension(".mtl"), materials(scene, path));
    base::writeFile(path, text);
}

}  // namespace dapple::scenegen
