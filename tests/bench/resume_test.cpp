#include "bench/run.h"
#include "bench/run_folder.h"

#include "bench/killed_run.h"

#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

namespace dapple::bench {
namespace {
namespace fs = std::filesystem;

class Resume : public testing::Test {
protected:
    Resume() {
        TestWorkbench bench;
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = reference(), .resume = false});
    }
    std::string reference() const { return (folder.path / "reference").string(); }
    std::string out() const { return (folder.path / "out").string(); }

    void resumeAndCompare(size_t expectedOpened) {
        TestWorkbench bench;
        EXPECT_TRUE(runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = true}).clean());
        EXPECT_EQ(bench.opened.size(), expectedOpened);
        EXPECT_EQ(deterministicPart(out() + "/metrics.csv"), deterministicPart(reference() + "/metrics.csv"));
        EXPECT_EQ(base::readFile(out() + "/plan.csv"), base::readFile(reference() + "/plan.csv"));
        const CsvTable samples(base::readFile(out() + "/samples.csv"), "samples.csv");
        const CsvTable expected(base::readFile(reference() + "/samples.csv"), "samples.csv");
        ASSERT_EQ(samples.rows(), expected.rows());
        for (size_t i = 0; i < samples.rows(); ++i)
            for (const char* column : {"point_id", "block", "order", "arm", "frame", "pass", "metric", "value"})
                ASSERT_EQ(samples.at(i, column), expected.at(i, column)) << "row " << i;
        for (const auto& entry : fs::directory_iterator(out())) EXPECT_NE(entry.path().extension(), ".part");
    }
    void appendTo(const char* name, const std::string& text) { std::ofstream(out() + "/" + name, std::ios::app | std::ios::binary) << text; }

    TemporaryFolder folder;
};

TEST_F(Resume, AfterBeingKilledAnywhereEqualsAnUninterruptedRun) {
    const size_t framesOfAll = [&] {
        TestWorkbench bench;
        size_t frames = 0;
        bench.onFrame = [&](const PointSpec&) { ++frames; };
        TemporaryFolder counting;
        runPlan(makePlan(threeScenes(), bench), bench, {.folder = (counting.path / "x").string(), .resume = false});
        return frames;
    }();
    for (const double share : {0.0, 0.2, 0.4, 0.6, 0.8, 0.99}) {
        SCOPED_TRACE(share);
        fs::remove_all(out());
        ASSERT_TRUE(runAndDieAfter(out(), static_cast<long>(share * static_cast<double>(framesOfAll)), false));
        const size_t finished = static_cast<size_t>(share * 3);  // whole comparisons of equal length
        resumeAndCompare(4 * (3 - finished));
    }
}

TEST_F(Resume, SurvivesBeingKilledTwice) {
    ASSERT_TRUE(runAndDieAfter(out(), 10, false));
    for (int i = 0; i < 10 && runAndDieAfter(out(), 400, true); ++i) {}
    TestWorkbench bench;
    runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = true});
    EXPECT_EQ(deterministicPart(out() + "/metrics.csv"), deterministicPart(reference() + "/metrics.csv"));
}

TEST_F(Resume, IgnoresATornLastLine) {
    ASSERT_TRUE(runAndDieAfter(out(), 500, false));
    appendTo("metrics.csv.part", "1.0,abc,\"half a r");
    appendTo("samples.csv.part", "abc,0");
    appendTo("journal.part", "done 1 99");
    resumeAndCompare(8);
}

TEST_F(Resume, IgnoresAJournalThatIsAheadOfTheFiles) {
    ASSERT_TRUE(runAndDieAfter(out(), 500, false));
    appendTo("journal.part", "done 1 99999999 99999999\n");
    resumeAndCompare(8);
}

TEST_F(Resume, GoesOnWhenKilledBetweenTheFinalRenames) {
    ASSERT_TRUE(runAndDieAfter(out(), 500, false));
    fs::rename(out() + "/samples.csv.part", out() + "/samples.csv");
    resumeAndCompare(8);
}

TEST_F(Resume, OfAFinishedRunDoesNothing) {
    TestWorkbench bench;
    const std::string before = base::readFile(reference() + "/metrics.csv");
    EXPECT_TRUE(runPlan(makePlan(threeScenes(), bench), bench, {.folder = reference(), .resume = true}).clean());
    EXPECT_TRUE(bench.opened.empty());
    EXPECT_EQ(base::readFile(reference() + "/metrics.csv"), before);
}

TEST_F(Resume, OfAnotherPlanIsRefused) {
    TestWorkbench bench;
    for (const bool finished : {true, false}) {
        if (!finished) {
            ASSERT_TRUE(runAndDieAfter(out(), 500, false));
        }
        const RunOptions options{.folder = finished ? reference() : out(), .resume = true};
        EXPECT_EQ(codeOf([&] { runPlan(makePlan(smallSweep(), bench), bench, options); }), base::ExitCode::usage);
    }
    EXPECT_TRUE(bench.opened.empty());
    resumeAndCompare(8);
}

TEST_F(Resume, AfterCtrlC) {
    for (const int signal : {SIGINT, SIGTERM}) {
        fs::remove_all(out());
        TestWorkbench bench;
        bench.onOpen = [&](const PointSpec& spec) {
            if (spec.scene == "b") std::raise(signal);
        };
        const auto run = [&] { runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = false}); };
        try {
            run();
            FAIL() << "not interrupted";
        } catch (const base::Error& e) {
            EXPECT_EQ(e.code(), base::ExitCode::interrupted);
            EXPECT_NE(std::string(e.what()).find("--resume"), std::string::npos);
        }
        resumeAndCompare(8);
    }
}

TEST_F(Resume, AfterAFullDisk) {
    // A limit on the size of files stands in for the end of the disk: both make write() fall short.
    const pid_t child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit{40000, 40000};  // bytes: more than one comparison's samples, less than all
        ::setrlimit(RLIMIT_FSIZE, &limit);
        TestWorkbench bench;
        const auto run = [&] { runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = false}); };
        ::_exit(static_cast<int>(codeOf(run)));
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 2);
    EXPECT_FALSE(fs::exists(out() + "/metrics.csv"));
    TestWorkbench bench;
    runPlan(makePlan(threeScenes(), bench), bench, {.folder = out(), .resume = true});
    EXPECT_LT(bench.opened.size(), 12u);
    EXPECT_EQ(deterministicPart(out() + "/metrics.csv"), deterministicPart(reference() + "/metrics.csv"));
}

TEST_F(Resume, FoldersThatCannotTakeARunAreRefused) {
    const auto refused = [](const std::string& path, bool resume) {
        EXPECT_EQ(codeOf([&] { RunFolder::check(path, resume); }), base::ExitCode::usage) << path;
    };
    refused(reference(), false);
    refused("/proc/nowhere", false);
    base::writeFile(folder.path / "file", "x");
    refused((folder.path / "file").string(), false);
    refused((folder.path / "file" / "below").string(), false);
    RunFolder::check(folder.path / "new" / "deep", false);
    EXPECT_FALSE(fs::exists(folder.path / "new"));  // asking leaves nothing behind

    base::writeFile(folder.path / "other" / "thesis.tex", "x");
    TestWorkbench bench;
    const RunOptions options{.folder = (folder.path / "other").string(), .resume = true};
    EXPECT_EQ(codeOf([&] { runPlan(makePlan(smallSweep(), bench), bench, options); }), base::ExitCode::usage);
}

TEST_F(Resume, RemoveRunTakesOnlyThatSweepsRun) {
    base::writeFile(reference() + "/notes.txt", "x");
    EXPECT_EQ(codeOf([&] { RunFolder::removeRun(reference(), "quick"); }), base::ExitCode::usage);
    RunFolder::removeRun(reference(), "small");
    EXPECT_TRUE(fs::exists(reference() + "/notes.txt"));
    EXPECT_FALSE(fs::exists(reference() + "/metrics.csv"));
    ASSERT_TRUE(runAndDieAfter(out(), 500, false));
    RunFolder::removeRun(out(), "small");
    EXPECT_TRUE(fs::is_empty(out()));
}

}  // namespace
}  // namespace dapple::bench
