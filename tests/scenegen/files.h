#pragma once

#include "base/file.h"
#include "base/math.h"
#include "scenegen/import/import.h"
#include "scenegen/scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// A folder of its own for each test.
class Files : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() /
                  fmt::format("dapple_{}_{}_{}", test->test_suite_name(), test->name(), ::getpid());
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path write(const std::string& name, std::string_view bytes) const {
        base::writeFile(folder_ / name, bytes);
        return folder_ / name;
    }

    std::filesystem::path folder_;
};

/// World points of all triangles, three each, origin included.
inline std::vector<glm::dvec3> worldCorners(const Scene& scene) {
    std::vector<glm::dvec3> points;
    for (const Instance& i : scene.instances)
        for (const Mesh& m : scene.prototypes[i.prototype].meshes)
            for (const uint32_t v : m.indices) {
                const glm::dvec3 p(m.positions[v]);
                const double c = std::cos(double(i.yaw)), s = std::sin(double(i.yaw));
                points.push_back(scene.origin + glm::dvec3(i.translation) +
                                 double(i.scale) * glm::dvec3(c * p.x - s * p.y, s * p.x + c * p.y, p.z));
            }
    return points;
}

/// Square metres.
inline double area(const Scene& scene) {
    const std::vector<glm::dvec3> p = worldCorners(scene);
    double sum = 0;
    for (size_t i = 0; i < p.size(); i += 3) sum += glm::length(glm::cross(p[i + 1] - p[i], p[i + 2] - p[i])) / 2;
    return sum;
}

/// Cubic metres; positive when closed surfaces face outwards.
inline double signedVolume(const Scene& scene) {
    const std::vector<glm::dvec3> p = worldCorners(scene);
    double sum = 0;
    for (size_t i = 0; i < p.size(); i += 3)
        sum += glm::dot(p[i] - p[0], glm::cross(p[i + 1] - p[0], p[i + 2] - p[0])) / 6;
    return sum;
}

/// Exact, not through the boxes of prototypes.
inline base::DBox worldBox(const Scene& scene) {
    base::DBox box;
    for (const glm::dvec3& p : worldCorners(scene)) box.extend(p);
    return box;
}

inline bool hasNote(const Scene& scene, const std::string& part) {
    for (const std::string& note : scene.notes)
        if (note.find(part) != std::string::npos) return true;
    return false;
}

}  // namespace dapple::scenegen
