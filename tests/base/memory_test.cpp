#include "base/memory.h"

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

namespace dapple::base {
namespace {

TEST(Memory, isSomethingAndNoMoreThanTheMachineHas) {
    const size_t physical = size_t(sysconf(_SC_PHYS_PAGES)) * size_t(sysconf(_SC_PAGESIZE));
    EXPECT_GT(availableMemory(), size_t{1} << 20);
    EXPECT_LE(availableMemory(), physical);
}

TEST(Memory, honoursTheProcessLimit) {
    rlimit old{};
    ASSERT_EQ(getrlimit(RLIMIT_AS, &old), 0);
    const rlimit tight{size_t{1} << 30, old.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_AS, &tight), 0);
    const size_t left = availableMemory();
    setrlimit(RLIMIT_AS, &old);
    EXPECT_LT(left, size_t{1} << 30);
}

}  // namespace
}  // namespace dapple::base
