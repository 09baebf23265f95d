#pragma once

#include "base/error.h"
#include "base/expect_error.h"
#include "base/file.h"
#include "base/image.h"
#include "scenegen/import/import.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace dapple::scenegen {
namespace fs = std::filesystem;
using Json = nlohmann::json;

inline fs::path gltfFixtures() { return base::homeFolder() / "tests/fixtures/gltf"; }

/// A glTF file under construction: one buffer beside it.
class Maker {
public:
    Maker() : folder_(fs::temp_directory_path() / fmt::format("dapple_gltf_{}", ::getpid())) {
        fs::create_directories(folder_);
        json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}, {"nodes", {{{"mesh", 0}, {"name", "n"}}}}};
    }
    ~Maker() { fs::remove_all(folder_); }

    template <class T>
    size_t view(const std::vector<T>& values) {
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}});
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        return json["bufferViews"].size() - 1;
    }
    template <class T>
    size_t accessor(const std::vector<T>& values, const char* type, int components, bool normalized = false) {
        const int component = std::is_same_v<T, float> ? 5126 : std::is_same_v<T, int8_t> ? 5120 : std::is_same_v<T, uint8_t> ? 5121 : std::is_same_v<T, int16_t> ? 5122
                              : std::is_same_v<T, uint16_t> ? 5123 : 5125;
        json["accessors"].push_back({{"bufferView", view(values)}, {"componentType", component}, {"count", values.size() / size_t(components)}, {"type", type}});
        if (normalized) json["accessors"].back()["normalized"] = true;
        return json["accessors"].size() - 1;
    }
    /// Square of corners (0,0) (1,0) (0,1) (1,1) in the file's xy plane, as a strip's order is.
    size_t square() { return accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3", 3); }
    void mesh(Json primitive) { json["meshes"].push_back({{"primitives", {std::move(primitive)}}}); }

    fs::path write(const std::string& name = "t.gltf") {
        if (!bytes_.empty()) {
            base::writeFile(folder_ / "t.bin", bytes_);
            json["buffers"] = {{{"uri", "t.bin"}, {"byteLength", bytes_.size()}}};
        }
        base::writeFile(folder_ / name, json.dump());
        return folder_ / name;
    }
    fs::path write(const std::string& name, std::string_view text) {
        base::writeFile(folder_ / name, text);
        return folder_ / name;
    }
    Scene read() { return importFile(write()); }
    std::string error() {
        const fs::path file = write();
        return base::errorLine([&] { importFile(file); });
    }
    const fs::path& folder() const { return folder_; }

    Json json;

private:
    fs::path folder_;
    std::string bytes_;
};

inline double areaOf(const Scene& scene) {
    double sum = 0;
    for (const Instance& i : scene.instances)
        for (const Mesh& m : scene.prototypes[i.prototype].meshes)
            for (size_t t = 0; t < m.indices.size(); t += 3) {
                const glm::dvec3 a(m.positions[m.indices[t]]), b(m.positions[m.indices[t + 1]]), c(m.positions[m.indices[t + 2]]);
                sum += glm::length(glm::cross(b - a, c - a)) / 2 * double(i.scale) * double(i.scale);
            }
    return sum;
}

inline base::DBox boxOf(const Scene& scene) {
    const base::Box box = scene.facts().box;
    return {glm::dvec3(box.lo) + scene.origin, glm::dvec3(box.hi) + scene.origin};
}

inline bool noted(const Scene& scene, const std::string& part) {
    return std::ranges::any_of(scene.notes, [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

}  // namespace dapple::scenegen
