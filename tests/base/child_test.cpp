#include "base/child.h"

#include "base/error.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <ctime>
#include <numeric>
#include <vector>

namespace dapple::base {
namespace {

using Work = std::function<void(Child::Output&)>;

/// Why `work` does not send a byte.
std::string failureOf(const Child::Limits& limits, const Work& work) {
    Child child(limits, work);
    char byte = 0;
    try {
        child.get(&byte, 1);
    } catch (const Child::Failure& e) {
        return e.what();
    }
    return "";
}

TEST(Child, SendsWhatItMakes) {
    std::vector<uint32_t> sent(3'000'000), got(sent.size());
    std::iota(sent.begin(), sent.end(), 7u);
    Child child({}, [&](Child::Output& out) {
        const size_t count = sent.size();
        out.put(&count, sizeof count);
        out.put(sent.data(), count * sizeof(uint32_t));
    });
    size_t count = 0;
    child.get(&count, sizeof count);
    ASSERT_EQ(count, sent.size());
    child.get(got.data(), got.size() * sizeof(uint32_t));
    EXPECT_EQ(got, sent);
    EXPECT_THROW(child.get(&count, 1), Child::Failure);  // there is no more
}

TEST(Child, ErrorsArriveAsTheyWere) {
    char byte = 0;
    Child usage({}, [](Child::Output&) { throw UsageError("t.obj: has no triangle"); });
    EXPECT_THROW(
        try { usage.get(&byte, 1); } catch (const UsageError& e) {
            EXPECT_STREQ(e.what(), "t.obj: has no triangle");
            throw;
        },
        UsageError);
    Child corrupt({}, [](Child::Output&) { throw Error(ExitCode::corrupt, "x"); });
    try {
        corrupt.get(&byte, 1);
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ExitCode::corrupt);
    }
    EXPECT_EQ(failureOf({}, [](Child::Output&) { throw std::runtime_error("odd"); }), "fails (odd)");
}

TEST(Child, CrashesEndTheChildAlone) {
    EXPECT_NE(failureOf({}, [](Child::Output&) { std::raise(SIGSEGV); }).find("crashes (Segmentation fault"), std::string::npos);
    EXPECT_NE(failureOf({}, [](Child::Output&) { std::abort(); }).find("crashes (Aborted"), std::string::npos);
    EXPECT_EQ(failureOf({}, [](Child::Output&) { ::_exit(0); }), "ends early");
}

TEST(Child, EndlessLoopsAreCutOff) {
    // 1 s of processor time, unless a busy machine does not give it in ten.
    EXPECT_EQ(failureOf({.seconds = 1}, [](Child::Output&) { for (;;) std::time(nullptr); }).find("takes longer than 1"), 0u);
    // Asleep it spends no processor time.
    EXPECT_EQ(failureOf({.seconds = 0.2}, [](Child::Output&) { for (;;) ::pause(); }), "takes longer than 2 s");
}

#ifndef __SANITIZE_ADDRESS__
TEST(Child, MemoryIsBounded) {
    const auto hoard = [](Child::Output&) {
        try {
            std::vector<char> all;
            for (;;) all.resize(all.size() + (1 << 20));
        } catch (const std::bad_alloc&) {  // as readers do that go on without
        }
    };
    EXPECT_EQ(failureOf({.bytes = size_t(64) << 20}, hoard), "asks for more than 64 MiB of memory");
}
#endif

TEST(Child, IsGoneWithItsOwner) {
    { const Child child({}, [](Child::Output&) { for (;;) ::pause(); }); }
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
}

}  // namespace
}  // namespace dapple::base
