#include "base/hash.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

using namespace dapple::scenegen;

/// Taken from g++ 12 and clang++ 14 at -O0 and -O3, which agree. A change of these is a change of every published
/// number on these scenes: renew them only together with the change log.
TEST(Hash, recipesGiveTheSameBytesEverywhere) {
    const std::pair<const char*, const char*> golden[] = {
        {"box", "9f8ecad853930bcb"}, {"sphere", "56a47a7119c15269"}, {"slab", "9e6533cee5bb2555"}, {"empty", "38245f2a1f8d10be"}, {"nothing", "536e9ce8e53a26e1"},
        {"forest-small", "e06b46d9581f7818"}, {"forest-105", "0e4155bf22119db4"}, {"forest-card", "f84de27e94252f08"}, {"arboretum", "4bad1b71cc4598d9"},
    };
    for (const auto& [name, hash] : golden) EXPECT_EQ(dapple::base::hex16(loadScene(name).contentHash()), hash) << name;
    EXPECT_EQ(dapple::base::hex16(loadScene("arboretum", {"wind.strength=0.7", "time=1.5"}).contentHash()), "c5446b822ff02495");
}

TEST(Hash, seedsChangeIt) {
    EXPECT_NE(loadScene("forest-small").contentHash(), loadScene("forest-small", {"seed=99"}).contentHash());
}
