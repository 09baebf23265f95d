#include "scenegen/texture_size.h"

#include <gtest/gtest.h>

#include <array>

namespace dapple::scenegen {
namespace {

/// Every texel (x, y, 7), opaque where x is even.
Texture striped(int width, int height) {
    Texture texture{"wide", {width, height, 4, {}}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) texture.image.texels.insert(texture.image.texels.end(), {uint8_t(x), uint8_t(y), 7, uint8_t(x % 2 ? 0 : 255)});
    return texture;
}

TEST(TextureSize, WhatFitsStaysAsItIs) {
    Scene scene;
    scene.textures = {striped(64, 16), striped(1, 1)};
    const auto before = scene.textures[0].image.texels;
    fitTextures(scene, 64);
    EXPECT_EQ(scene.textures[0].image.texels, before);
    EXPECT_TRUE(scene.notes.empty());
}

TEST(TextureSize, LargerOnesAreMeansOfBlocksAndSaid) {
    for (const auto& [width, height, w, h] : {std::array{128, 3, 64, 3}, {129, 3, 43, 3}, {3, 200, 3, 50}, {65, 65, 33, 33}}) {
        Scene scene;
        scene.textures = {striped(width, height)};
        fitTextures(scene, 64);
        const base::Image8& image = scene.textures[0].image;
        ASSERT_EQ(image.width, w);
        ASSERT_EQ(image.height, h);
        EXPECT_EQ(image.texels.size(), size_t(w * h * 4));
        EXPECT_EQ(image.at(w - 1, h - 1)[2], 7);
        ASSERT_EQ(scene.notes.size(), 1u);
        EXPECT_NE(scene.notes[0].find("wide"), std::string::npos);
    }
    Scene scene;
    scene.textures = {striped(128, 3)};
    fitTextures(scene, 64);
    const uint8_t* t = scene.textures[0].image.at(10, 2);
    EXPECT_EQ(t[0], 20);   // 20 is seen, 21 is not
    EXPECT_EQ(t[1], 2);
    EXPECT_EQ(t[3], 128);  // half of 255, rounded
}

}  // namespace
}  // namespace dapple::scenegen
