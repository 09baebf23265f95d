#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace dapple::base {

/// 8-bit image, rows from the top, channels interleaved, sRGB unless its user says otherwise.
struct Image8 {
    int width = 0, height = 0, channels = 4;
    std::vector<uint8_t> texels;  ///< width · height · channels

    const uint8_t* at(int x, int y) const { return &texels[(size_t(y) * size_t(width) + size_t(x)) * size_t(channels)]; }
    uint8_t* at(int x, int y) { return &texels[(size_t(y) * size_t(width) + size_t(x)) * size_t(channels)]; }
};

/// Float image, rows from the top, channels interleaved, linear.
struct ImageF {
    int width = 0, height = 0, channels = 1;
    std::vector<float> texels;  ///< width · height · channels
};

/// Decodes PNG, JPEG, WebP, TGA, BMP or SGI (.rgb) bytes into RGBA. `name` is used in the message of the
/// UsageError that is thrown when the bytes are not one of these, are damaged, or ask for more texels than a file of their
/// size may: 8192², and beyond that 64 for each byte.
Image8 decodeImage(std::span<const uint8_t> bytes, const std::string& name);
Image8 readImage(const std::filesystem::path& path);

/// All channels of a PNG as 0 … 65535; 8-bit values count 257 each. Throws as readImage().
ImageF readPng16(const std::filesystem::path& path);

/// Raw deflate data, which must yield `size` bytes. Throws std::runtime_error when damaged. (The image decoder brings it.)
std::string inflate(const std::string& packed, size_t size);

std::string encodePng(const Image8& image);
/// Whole or not at all, like writeFile().
void writePng(const std::filesystem::path& path, const Image8& image);
/// 32-bit float EXR with channels named Y; R,G; R,G,B or R,G,B,A by their count.
void writeExr(const std::filesystem::path& path, const ImageF& image);
ImageF readExr(const std::filesystem::path& path);

}  // namespace dapple::base
