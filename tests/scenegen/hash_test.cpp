#include "base/hash.h"
#include "scenegen/library.h"

#include <gtest/gtest.h>

using namespace dapple::scenegen;

/// Taken from g++ 12 and clang++ 14 at -O0 and -O3, which agree. A change of these is a change of every published
/// number on these scenes: renew them only together with the change log.
TEST(Hash, recipesGiveTheSameBytesEverywhere) {
    const std::pair<const char*, const char*> golden[] = {
        {"box", "9f8ecad853930bcb"}, {"sphere", "68b4b7966b53cb21"}, {"slab", "37f689c73f139d86"}, {"empty", "38245f2a1f8d10be"}, {"nothing", "536e9ce8e53a26e1"},
        {"forest-small", "69d3978a3440b505"}, {"forest-105", "fe1a4aee75102d79"}, {"forest-card", "d200dbdd3159792b"}, {"arboretum", "f192eb57bbe63b29"},
    };
    for (const auto& [name, hash] : golden) EXPECT_EQ(dapple::base::hex16(loadScene(name).contentHash()), hash) << name;
    EXPECT_EQ(dapple::base::hex16(loadScene("arboretum", {"wind.strength=0.7", "wind.time=1.5"}).contentHash()), "0c0380bbd4b6a34c");
}

TEST(Hash, seedsChangeIt) {
    EXPECT_NE(loadScene("forest-small").contentHash(), loadScene("forest-small", {"seed=99"}).contentHash());
}
