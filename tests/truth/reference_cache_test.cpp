#include "truth/closed_form.h"

#include "base/file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>

namespace dapple::truth::test {
namespace {

class ReferenceCache : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("dapple_cache_" + std::to_string(getpid()));
        std::filesystem::remove_all(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    /// The labels, what was warned about, and how the folder stands afterwards.
    Reference cached(uint64_t sceneHash = 1) {
        testing::internal::CaptureStderr();
        Reference g = cachedReference(tracer_, sceneHash, patch_.receivers, eye_, light_, folder_);
        warnings_ = testing::internal::GetCapturedStderr();
        return g;
    }
    std::vector<std::filesystem::path> entries() const {
        std::vector<std::filesystem::path> all;
        for (const auto& e : std::filesystem::directory_iterator(folder_)) all.push_back(e.path());
        return all;
    }

    std::filesystem::path folder_;
    std::string warnings_;
    dvec3 eye_{1.5, -3, 2.2}, light_ = glm::normalize(dvec3(1, 0.5, -1));
    Tracer tracer_{sceneOf({boxMesh({-1, -1, 0}, {1, 1, 2})})};
    Patch patch_ = patchOf(planeGrid(37, 5), 37, eye_);  // 37² labels do not fill the last byte
};

TEST_F(ReferenceCache, RoundTripGivesTheSameLabels) {
    const Reference traced = tracer_.trace(patch_.receivers, eye_, light_);
    EXPECT_EQ(cached().label, traced.label);
    ASSERT_EQ(entries().size(), 1u);
    EXPECT_LT(std::filesystem::file_size(entries()[0]), traced.label.size() / 4 + 64);
    EXPECT_EQ(cached().label, traced.label);
    EXPECT_EQ(warnings_, "");
}

TEST_F(ReferenceCache, SecondCallReadsAndDoesNotTrace) {
    const Reference first = cached();
    // Another scene behind the same key: only a cache that reads gives the first scene's labels.
    const Tracer empty(sceneOf({}));
    EXPECT_EQ(cachedReference(empty, 1, patch_.receivers, eye_, light_, folder_).label, first.label);
    EXPECT_NE(empty.trace(patch_.receivers, eye_, light_).label, first.label);
}

TEST_F(ReferenceCache, EveryPartOfTheContentChangesTheKey) {
    cached();
    cached(2);
    EXPECT_EQ(entries().size(), 2u);
    eye_.x = std::nextafter(eye_.x, 2.0);
    cached();
    light_ = glm::normalize(dvec3(1, 0.5, -1.0001));
    cached();
    patch_.receivers.position[5].y += 1e-6f;
    cached();
    patch_.receivers.normal[5].y += 1e-6f;
    cached();
    patch_.receivers.present[5] = 0;
    cached();
    EXPECT_EQ(entries().size(), 7u);
}

TEST_F(ReferenceCache, DamagedEntryIsTracedAnewWithOneWarningAndMended) {
    const Reference good = cached();
    const std::filesystem::path path = entries()[0];
    const std::string bytes = base::readFile(path);
    std::vector<std::string> damaged = {"", bytes.substr(0, 20), bytes.substr(0, bytes.size() - 1), bytes + "x"};
    for (const size_t at : {size_t(0), size_t(9), size_t(17), size_t(25), size_t(40), bytes.size() - 1}) {
        damaged.push_back(bytes);
        damaged.back()[at] = char(damaged.back()[at] ^ 1);
    }
    for (const std::string& content : damaged) {
        std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
        EXPECT_EQ(cached().label, good.label);
        EXPECT_EQ(std::ranges::count(warnings_, '\n'), 1) << warnings_;
        EXPECT_NE(warnings_.find(path.string()), std::string::npos);
        EXPECT_EQ(base::readFile(path), bytes);
    }
}

TEST_F(ReferenceCache, FolderThatCannotBeWrittenWarnsOnceAndWorks) {
    const Reference traced = tracer_.trace(patch_.receivers, eye_, light_);
    std::ofstream(folder_) << "a file where the folder should be";
    EXPECT_EQ(cached().label, traced.label);
    EXPECT_EQ(std::ranges::count(warnings_, '\n'), 1) << warnings_;
    EXPECT_EQ(cached().label, traced.label);
    EXPECT_EQ(warnings_, "");
}

}  // namespace
}  // namespace dapple::truth::test
