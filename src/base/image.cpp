#include "base/image.h"

#include "base/error.h"
#include "base/file.h"
#include "base/webp.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <limits>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wunused-function"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

namespace dapple::base {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::array<const char*, 4>, 4> kChannelNames{{{"Y"}, {"R", "G"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}};

/// Before memory is asked for: a few bytes of header can stand for gigabytes of texels.
void requireSize(size_t width, size_t height, size_t fileBytes, const std::string& name) {
    constexpr size_t kFree = size_t(1) << 26, kPerByte = 64;
    const size_t most = std::max(kFree, kPerByte * fileBytes);
    if (width > 0 && height > most / width)
        throw UsageError(fmt::format("{}: {} × {} texels are too many for an image of {} bytes", name, width, height, fileBytes));
}

/// Bytes of texels that a BMP or TGA of this size has at least; 0 for other formats.
size_t leastBytes(std::span<const uint8_t> b, size_t width, size_t height) {
    if (b.size() < 30) return b.size() < 18 ? 0 : width * height;
    const auto u16 = [&](size_t i) { return size_t(b[i + 1]) << 8 | b[i]; };
    if (b[0] == 'B' && b[1] == 'M') return width * height * u16(28) / 8;
    const bool raw = b[2] >= 1 && b[2] <= 3, packed = b[2] >= 9 && b[2] <= 11;  // 128 texels a packet
    if ((!raw && !packed) || u16(12) != width || u16(14) != height) return 0;
    const size_t texel = (size_t(b[16]) + 7) / 8;
    return raw ? width * height * texel : width * height / 128 * (1 + texel);
}

/// Throws for what stb_image would make room for without having the bytes.
void requireSize(std::span<const uint8_t> bytes, const std::string& name) {
    int w = 0, h = 0, channels = 0;
    if (bytes.size() > size_t(std::numeric_limits<int>::max())) throw UsageError(fmt::format("{}: more than 2 GiB in one image", name));
    if (!stbi_info_from_memory(bytes.data(), int(bytes.size()), &w, &h, &channels)) return;  // the decoder says why
    requireSize(size_t(w), size_t(h), bytes.size(), name);
    if (leastBytes(bytes, size_t(w), size_t(h)) > bytes.size())
        throw UsageError(fmt::format("{}: truncated: {} bytes for {} × {} texels", name, bytes.size(), w, h));
}

bool isSgi(std::span<const uint8_t> b) { return b.size() > 512 && b[0] == 0x01 && b[1] == 0xda; }

/// SGI image file format 1.0 (Haeberli): planar channels, rows from the bottom, optional run-length coding.
Image8 decodeSgi(std::span<const uint8_t> b, const std::string& name) {
    const auto fail = [&]() -> UsageError { return UsageError(fmt::format("{}: damaged or unsupported SGI image", name)); };
    const auto u16 = [&](size_t i) { return size_t(b[i]) << 8 | b[i + 1]; };
    const auto u32 = [&](size_t i) { return u16(i) << 16 | u16(i + 2); };
    const bool packed = b[2] == 1;
    const size_t w = u16(6), h = u16(8), c = u16(4) >= 3 ? u16(10) : 1;
    if (b[3] != 1 || w == 0 || h == 0 || c == 0 || c > 4) throw fail();
    requireSize(w, h, b.size(), name);
    if (packed && b.size() < 512 + 8 * h * c) throw fail();
    if (!packed && b.size() < 512 + w * h * c) throw fail();

    std::vector<uint8_t> planes(w * h * c);
    for (size_t row = 0; row < h * c; ++row) {
        uint8_t* out = &planes[row * w];
        if (!packed) {
            std::copy_n(&b[512 + row * w], w, out);
            continue;
        }
        size_t in = u32(512 + 4 * row);
        for (size_t x = 0; x < w;) {
            if (in >= b.size()) throw fail();
            const uint8_t code = b[in++];
            const size_t count = code & 0x7fu;
            if (count == 0) throw fail();  // the row ends before its last column
            const size_t bytes = (code & 0x80u) ? count : 1;
            if (x + count > w || in + bytes > b.size()) throw fail();
            for (size_t k = 0; k < count; ++k) out[x++] = b[in + std::min(k, bytes - 1)];
            in += bytes;
        }
    }
    Image8 image{int(w), int(h), 4, std::vector<uint8_t>(w * h * 4)};
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) {
            const auto plane = [&](size_t k) { return planes[(k * h + (h - 1 - y)) * w + x]; };
            uint8_t* texel = image.at(int(x), int(y));
            for (size_t k = 0; k < 3; ++k) texel[k] = plane(c >= 3 ? k : 0);
            texel[3] = c == 4 ? plane(3) : c == 2 ? plane(1) : 255;
        }
    return image;
}

/// Whether the checksums of all chunks up to the end mark hold (PNG, third edition, §5.3): stb_image does not look.
bool isIntactPng(std::span<const uint8_t> b) {
    const auto u32 = [&](size_t i) { return size_t(b[i]) << 24 | size_t(b[i + 1]) << 16 | size_t(b[i + 2]) << 8 | b[i + 3]; };
    for (size_t at = 8; at + 12 <= b.size();) {
        const size_t length = u32(at);
        if (length > b.size() - at - 12) return false;
        const uint8_t* type = &b[at + 4];
        if (stbiw__crc32(const_cast<uint8_t*>(type), int(length) + 4) != u32(at + 8 + length)) return false;
        if (std::equal(type, type + 4, "IEND")) return true;
        at += 12 + length;
    }
    return false;
}

}  // namespace

Image8 decodeImage(std::span<const uint8_t> bytes, const std::string& name) {
    if (isSgi(bytes)) return decodeSgi(bytes, name);
    if (isWebp(bytes)) return decodeWebp(bytes, name);
    const std::array<uint8_t, 8> pngSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    if (bytes.size() >= 8 && std::equal(pngSignature.begin(), pngSignature.end(), bytes.begin()) && !isIntactPng(bytes))
        throw UsageError(fmt::format("{}: damaged or truncated PNG image", name));
    requireSize(bytes, name);
    int w = 0, h = 0, channels = 0;
    stbi_uc* texels = stbi_load_from_memory(bytes.data(), int(bytes.size()), &w, &h, &channels, 4);
    if (!texels) throw UsageError(fmt::format("{}: not an image that can be read ({})", name, stbi_failure_reason()));
    Image8 image{w, h, 4, std::vector<uint8_t>(texels, texels + size_t(w) * size_t(h) * 4)};
    stbi_image_free(texels);
    return image;
}

Image8 readImage(const fs::path& path) {
    const std::string bytes = readFile(path);
    return decodeImage({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, path.string());
}

ImageF readPng16(const fs::path& path) {
    const std::string bytes = readFile(path);
    const std::span<const uint8_t> data{reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()};
    if (!isIntactPng(data)) throw UsageError(fmt::format("{}: not a PNG image, or damaged", path.string()));
    requireSize(data, path.string());
    int w = 0, h = 0, channels = 0;
    stbi_us* texels = stbi_load_16_from_memory(data.data(), int(data.size()), &w, &h, &channels, 0);
    if (!texels) throw UsageError(fmt::format("{}: not an image that can be read ({})", path.string(), stbi_failure_reason()));
    ImageF image{w, h, channels, {texels, texels + size_t(w) * size_t(h) * size_t(channels)}};
    stbi_image_free(texels);
    return image;
}

std::string inflate(const std::string& packed, size_t size) {
    if (size / 1032 > packed.size()) throw std::runtime_error("deflate packs no more than 1032 bytes into one");
    // The decoder reads a few bytes ahead and takes the end of its input for damage.
    const std::string padded = packed + std::string(8, '\0');
    std::string bytes(size, '\0');
    const int got = stbi_zlib_decode_noheader_buffer(bytes.data(), int(size), padded.data(), int(padded.size()));
    if (got != int(size)) throw std::runtime_error("damaged deflate data");
    return bytes;
}

std::string encodePng(const Image8& image) {
    std::string bytes;
    const auto append = [](void* context, void* data, int size) {
        static_cast<std::string*>(context)->append(static_cast<const char*>(data), size_t(size));
    };
    stbi_write_png_to_func(append, &bytes, image.width, image.height, image.channels, image.texels.data(),
                           image.width * image.channels);
    return bytes;
}

void writePng(const fs::path& path, const Image8& image) { writeFile(path, encodePng(image)); }

void writeExr(const fs::path& path, const ImageF& image) {
    if (!path.parent_path().empty()) requireWritableFolder(path.parent_path());
    const fs::path temporary = path.string() + fmt::format(".{}.tmp", ::getpid());
    try {
        Imf::Header header(image.width, image.height);
        Imf::FrameBuffer frame;
        const size_t stride = size_t(image.channels) * sizeof(float);
        for (int c = 0; c < image.channels; ++c) {
            const char* name = kChannelNames[size_t(image.channels) - 1][size_t(c)];
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            auto* base = reinterpret_cast<char*>(const_cast<float*>(image.texels.data() + c));
            frame.insert(name, Imf::Slice(Imf::FLOAT, base, stride, stride * size_t(image.width)));
        }
        {
            Imf::OutputFile file(temporary.c_str(), header);
            file.setFrameBuffer(frame);
            file.writePixels(image.height);
        }
        fs::rename(temporary, path);
    } catch (const std::exception& e) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw UsageError(fmt::format("cannot write {}: {}", path.string(), e.what()));
    }
}

ImageF readExr(const fs::path& path) {
    requireRegularFile(path);
    try {
        Imf::InputFile file(path.c_str());
        const auto window = file.header().dataWindow();
        ImageF image{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, 0, {}};
        for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) ++image.channels;
        if (image.channels < 1 || image.channels > 4) throw std::runtime_error("not 1 to 4 channels");
        for (int c = 0; c < image.channels; ++c)
            if (!file.header().channels().findChannel(kChannelNames[size_t(image.channels) - 1][size_t(c)]))
                throw std::runtime_error("its channels are not Y; R, G; R, G, B or R, G, B, A");
        requireSize(size_t(image.width) * size_t(image.channels), size_t(image.height), fs::file_size(path), "its header");
        if (window.min.x != 0 || window.min.y != 0) throw std::runtime_error("its data window does not start at 0, 0");
        image.texels.resize(size_t(image.width) * size_t(image.height) * size_t(image.channels));
        Imf::FrameBuffer frame;
        const size_t stride = size_t(image.channels) * sizeof(float);
        for (int c = 0; c < image.channels; ++c)
            frame.insert(kChannelNames[size_t(image.channels) - 1][size_t(c)],
                         Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(image.texels.data() + c), stride,
                                    stride * size_t(image.width)));
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
        return image;
    } catch (const std::exception& e) {
        throw UsageError(fmt::format("cannot read {}: {}", path.string(), e.what()));
    }
}

}  // namespace dapple::base
