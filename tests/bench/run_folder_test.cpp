#include "bench/killed_run.h"
#include "bench/manifest.h"
#include "bench/run_folder.h"

#include <nlohmann/json.hpp>

#include <csignal>
#include <fstream>

namespace dapple::bench {
namespace {
namespace fs = std::filesystem;

class RunFolderTest : public testing::Test {
protected:
    RunFolderTest() {
        TestWorkbench bench;
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = reference()});
    }
    std::string reference() const { return (folder.path / "reference").string(); }
    std::string out() const { return (folder.path / "out").string(); }

    RunOutcome resume(RunOptions options) {
        TestWorkbench bench;
        options.folder = out();
        options.resume = true;
        const RunOutcome outcome = runPlan(makePlan(threeScenes(), bench), bench, options);
        opened = bench.opened.size();
        return outcome;
    }
    void expectEqualToReference() {
        EXPECT_EQ(deterministicPart(out() + "/metrics.csv"), deterministicPart(reference() + "/metrics.csv"));
        EXPECT_EQ(base::readFile(out() + "/plan.csv"), base::readFile(reference() + "/plan.csv"));
    }
    /// A run in which scene b cannot be opened.
    void runWithFailures() {
        TestWorkbench bench;
        bench.onOpen = [](const PointSpec& spec) {
            if (spec.scene == "b") throw std::runtime_error("no memory");
        };
        EXPECT_EQ(runPlan(makePlan(threeScenes(), bench), bench, {.folder = out()}).failed, 4u);
    }
    std::string flagsOf(const std::string& file) const {
        const CsvTable table(base::readFile(file), file);
        std::set<std::string> all;
        for (size_t row = 0; row < table.rows(); ++row) all.insert(table.at(row, "flags").find("mixed") == std::string::npos ? "clean" : "mixed");
        std::string text;
        for (const std::string& flags : all) text += flags + " ";
        return text;
    }

    TemporaryFolder folder;
    size_t opened = 0;
};

TEST_F(RunFolderTest, OneProcessAtATime) {
    std::array<int, 2> ready{}, goOn{};
    ASSERT_EQ(::pipe(ready.data()), 0);
    ASSERT_EQ(::pipe(goOn.data()), 0);
    const pid_t child = ::fork();
    if (child == 0) {
        TestWorkbench bench;
        long frames = 0;
        bench.onFrame = [&](const PointSpec&) {
            if (++frames != 300) return;
            char byte = 1;
            if (::write(ready[1], &byte, 1) != 1 || ::read(goOn[0], &byte, 1) != 1) ::_exit(1);
        };
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = out()});
        ::_exit(0);
    }
    char byte = 0;
    ASSERT_EQ(::read(ready[0], &byte, 1), 1);
    for (const bool resumes : {false, true}) {
        EXPECT_NE(messageOf([&] { RunFolder::check(out(), resumes); }).find(std::to_string(child)), std::string::npos);
        TestWorkbench bench;
        EXPECT_EQ(codeOf([&] { runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = resumes}); }), base::ExitCode::usage);
        EXPECT_TRUE(bench.opened.empty());
    }
    EXPECT_EQ(codeOf([&] { RunFolder::removeRun(out(), "small"); }), base::ExitCode::usage);
    ASSERT_EQ(::write(goOn[1], &byte, 1), 1);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    expectEqualToReference();
}

TEST_F(RunFolderTest, AKilledHolderDoesNotKeepTheFolder) {
    ASSERT_TRUE(runAndDieAfter(out(), 10, false));
    EXPECT_TRUE(fs::exists(out() + "/lock.part"));
    EXPECT_TRUE(resume({}).clean());
    expectEqualToReference();
    EXPECT_FALSE(fs::exists(out() + "/lock.part"));
}

TEST_F(RunFolderTest, WhatAKillLeavesBehindIsSwept) {
    for (const char* name : {".dapple-probe-123", "metrics.csv.77.tmp", "lock.part"}) base::writeFile(folder.path / "out" / name, "x");
    base::writeFile(folder.path / "out" / "pictures" / "a.png.9.tmp", "x");
    TestWorkbench bench;
    EXPECT_EQ(codeOf([&] { RunFolder::check(out(), false); }), base::ExitCode::usage);  // pictures are somebody's
    fs::rename(folder.path / "out" / "pictures", folder.path / "pictures");
    runPlan(makePlan(threeScenes(), bench), bench, {.folder = out()});
    std::set<std::string> left;
    for (const auto& entry : fs::directory_iterator(out())) left.insert(entry.path().filename());
    EXPECT_EQ(left, (std::set<std::string>{"manifest.json", "metrics.csv", "plan.csv", "run.json", "samples.csv"}));
}

TEST_F(RunFolderTest, AnotherProgramOrMachineIsRefusedOrMixedOnPurpose) {
    ASSERT_TRUE(runAndDieAfter(out(), 500, false));
    std::string journal = base::readFile(out() + "/journal.part");
    const size_t at = journal.find("\"program\":\"") + 11;
    journal[at] = journal[at] == '0' ? '1' : '0';
    base::writeFile(out() + "/journal.part", journal);
    const std::string line = messageOf([&] { resume({}); });
    EXPECT_NE(line.find("another program"), std::string::npos);
    EXPECT_NE(line.find("--mix"), std::string::npos);
    EXPECT_TRUE(resume({.mix = true}).clean());
    EXPECT_EQ(opened, 8u);
    EXPECT_EQ(flagsOf(out() + "/metrics.csv"), "mixed ");
    EXPECT_EQ(flagsOf(out() + "/samples.csv"), "mixed ");
    EXPECT_EQ(nlohmann::json::parse(base::readFile(out() + "/run.json"))["origins"].size(), 2u);
    EXPECT_EQ(flagsOf(reference() + "/metrics.csv"), "clean ");
}

TEST_F(RunFolderTest, FailedComparisonsAreMeasuredAgainOnRequest) {
    runWithFailures();
    EXPECT_EQ(resume({}).failed, 4u);
    EXPECT_EQ(opened, 0u);
    EXPECT_TRUE(resume({.retryFailed = true}).clean());
    EXPECT_EQ(opened, 4u);
    expectEqualToReference();
    verifyManifest(out());
    EXPECT_TRUE(resume({.retryFailed = true}).clean());
    EXPECT_EQ(opened, 0u);
}

TEST_F(RunFolderTest, FailedComparisonsOfAKilledRunAreMeasuredAgainToo) {
    const pid_t child = ::fork();
    if (child == 0) {
        TestWorkbench bench;
        bench.onOpen = [](const PointSpec& spec) {
            if (spec.scene == "a") throw std::runtime_error("no memory");
            if (spec.scene == "c") ::_exit(kKilled);
        };
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = out()});
        ::_exit(0);
    }
    ::waitpid(child, nullptr, 0);
    ASSERT_TRUE(runAndDieAfter(out(), 1, true));  // and killed again
    EXPECT_TRUE(resume({.retryFailed = true}).clean());
    EXPECT_EQ(opened, 8u);  // a and c; b was whole
    expectEqualToReference();
}

TEST_F(RunFolderTest, AFlippedBitOfAFinishedRunIsSeen) {
    for (const char* name : {"plan.csv", "metrics.csv", "samples.csv", "run.json", "manifest.json"}) {
        const std::string path = reference() + "/" + name, good = base::readFile(path);
        for (int trial = 0; trial < 40; ++trial) {
            std::string bad = good;
            // JSON's blanks between words carry nothing; every other byte does.
            size_t at = size_t(trial) * (good.size() - 1) / 39;
            while (name == std::string("manifest.json") && good[at] != '"') at = (at + 1) % good.size();
            bad[at] = char(bad[at] ^ (1 << (trial % 7)));
            base::writeFile(path, bad);
            EXPECT_EQ(codeOf([&] { verifyManifest(reference()); }), base::ExitCode::corrupt) << name << " byte " << at;
        }
        base::writeFile(path, good);
        verifyManifest(reference());
    }
    fs::remove(reference() + "/samples.csv");
    EXPECT_EQ(codeOf([&] { verifyManifest(reference()); }), base::ExitCode::corrupt);
}

TEST_F(RunFolderTest, AFlippedBitOfARunningRunIsMeasuredAgain) {
    for (const char* name : {"metrics.csv.part", "samples.csv.part"})
        for (int trial = 0; trial < 5; ++trial) {
            fs::remove_all(out());
            ASSERT_TRUE(runAndDieAfter(out(), 800, false));
            std::string bytes = base::readFile(out() + "/" + name);
            bytes[bytes.size() * size_t(1 + trial) / 6] ^= 4;
            base::writeFile(out() + "/" + name, bytes);
            EXPECT_TRUE(resume({}).clean());
            expectEqualToReference();
        }
}

TEST(Sha256, EqualsThePublishedVectors) {  // FIPS 180-4, examples of the standard
    EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace dapple::bench
