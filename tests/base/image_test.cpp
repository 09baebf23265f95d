#include "base/image.h"

#include "base/expect_error.h"
#include "base/file.h"
#include "base/random.h"

#include <sys/resource.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

namespace dapple::base {
namespace {
namespace fs = std::filesystem;

std::span<const uint8_t> asBytes(const std::string& s) { return {reinterpret_cast<const uint8_t*>(s.data()), s.size()}; }

class ImageTest : public ::testing::Test {
protected:
    ImageTest() {
        std::string pattern = (fs::path(testing::TempDir()) / "dapple_image_XXXXXX").string();
        folder_ = ::mkdtemp(pattern.data());
    }
    ~ImageTest() override { fs::remove_all(folder_); }
    fs::path folder_;
};

Image8 noise(int width, int height, int channels) {
    Image8 image{width, height, channels, {}};
    Random random{uint64_t(width), uint64_t(height), uint64_t(channels)};
    for (int i = 0; i < width * height * channels; ++i) image.texels.push_back(uint8_t(random.next(0, 256)));
    return image;
}

/// The four components of a texel as RGBA, by the meaning of 1 to 4 channels.
std::array<uint8_t, 4> rgba(const Image8& image, int x, int y) {
    const uint8_t* t = image.at(x, y);
    switch (image.channels) {
        case 1: return {t[0], t[0], t[0], 255};
        case 2: return {t[0], t[0], t[0], t[1]};
        case 3: return {t[0], t[1], t[2], 255};
        default: return {t[0], t[1], t[2], t[3]};
    }
}

void expectSame(const Image8& read, const Image8& written) {
    ASSERT_EQ(read.width, written.width);
    ASSERT_EQ(read.height, written.height);
    ASSERT_EQ(read.channels, 4);
    for (int y = 0; y < read.height; ++y)
        for (int x = 0; x < read.width; ++x) ASSERT_EQ(rgba(read, x, y), rgba(written, x, y)) << x << ", " << y;
}

TEST_F(ImageTest, PngRoundTripIsExact) {
    for (int channels = 1; channels <= 4; ++channels)
        for (const auto& [width, height] : {std::pair(1, 1), std::pair(37, 5), std::pair(3, 64)}) {
            const Image8 image = noise(width, height, channels);
            writePng(folder_ / "a.png", image);
            expectSame(readImage(folder_ / "a.png"), image);
        }
}

TEST_F(ImageTest, DamagedPngIsRefused) {
    const std::string good = encodePng(noise(9, 7, 4));
    for (size_t size = 0; size < good.size() - 12; size += 7)  // the last 12 bytes are the end mark
        expectHolds(errorLine([&] { decodeImage(asBytes(good.substr(0, size)), "some.png"); }), "some.png");
    for (size_t i = 0; i < good.size() - 12; ++i) {
        std::string bad = good;
        bad[i] = char(bad[i] ^ 0x10);
        expectHolds(errorLine([&] { decodeImage(asBytes(bad), "some.png"); }), "some.png");
    }
    for (const std::string& bytes : {std::string("no image at all"), std::string(2000, '\0'), std::string()})
        expectHolds(errorLine([&] { decodeImage(asBytes(bytes), "some.png"); }), "some.png");
    expectHolds(errorLine([&] { readImage(folder_ / "missing.png"); }), "missing.png");
}

TEST_F(ImageTest, ExrRoundTripIsExact) {
    for (int channels = 1; channels <= 4; ++channels) {
        ImageF image{13, 6, channels, {}};
        Random random(1, 2, uint64_t(channels));
        for (int i = 0; i < 13 * 6 * channels; ++i) image.texels.push_back(std::ldexp(random.next(-1, 1), int(random.next(-120, 120))));
        image.texels[0] = std::numeric_limits<float>::infinity();
        image.texels[1] = std::numeric_limits<float>::denorm_min();
        image.texels[2] = -0.0f;
        writeExr(folder_ / "sub/a.exr", image);
        const ImageF read = readExr(folder_ / "sub/a.exr");
        ASSERT_EQ(read.width, 13);
        ASSERT_EQ(read.height, 6);
        ASSERT_EQ(read.channels, channels);
        EXPECT_EQ(std::memcmp(read.texels.data(), image.texels.data(), image.texels.size() * sizeof(float)), 0) << channels;
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "sub"), fs::directory_iterator{}), 1);
}

TEST_F(ImageTest, ExrErrorsAreNamed) {
    const ImageF image{2, 2, 1, {1, 2, 3, 4}};
    expectHolds(errorLine([&] { writeExr("/proc/dapple.exr", image); }), "/proc");
    fs::create_directory(folder_ / "taken.exr");
    expectHolds(errorLine([&] { writeExr(folder_ / "taken.exr", image); }), "taken.exr");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 1);
    expectHolds(errorLine([&] { readExr(folder_ / "missing.exr"); }), "missing.exr");
    writeExr(folder_ / "a.exr", image);
    const std::string bytes = readFile(folder_ / "a.exr");
    writeFile(folder_ / "cut.exr", bytes.substr(0, bytes.size() / 2));
    expectHolds(errorLine([&] { readExr(folder_ / "cut.exr"); }), "cut.exr");
}

/// An SGI file by the letter of its specification (Haeberli): big-endian, planes one after the other, rows from the
/// bottom; packed rows are runs (count, value) and literals (0x80 | count, values), ended by 0.
std::string sgi(const Image8& image, bool packed) {
    std::string file;
    const auto u16 = [](std::string& s, int v) { s += char(v >> 8), s += char(v); };
    const auto u32 = [&](std::string& s, size_t v) { u16(s, int(v >> 16)), u16(s, int(v & 0xffff)); };
    u16(file, 474);
    file += char(packed);
    file += char(1);
    u16(file, image.channels == 1 ? 2 : 3);
    u16(file, image.width), u16(file, image.height), u16(file, image.channels);
    file.resize(512);
    std::string starts, lengths, data;
    const size_t dataStart = 512 + 8 * size_t(image.height * image.channels);
    for (int c = 0; c < image.channels; ++c)
        for (int y = image.height; y-- > 0;) {
            std::string row, code;
            for (int x = 0; x < image.width; ++x) row += char(image.at(x, y)[c]);
            for (size_t x = 0; x < row.size();) {
                size_t run = 1;
                while (run < 127 && x + run < row.size() && row[x + run] == row[x]) ++run;
                if (run >= 2) {
                    code += char(run), code += row[x];
                } else {
                    while (run < 127 && x + run < row.size() && row[x + run] != row[x + run - 1]) ++run;
                    code += char(0x80 | run), code += row.substr(x, run);
                }
                x += run;
            }
            code += '\0';
            u32(starts, dataStart + data.size()), u32(lengths, code.size());
            data += packed ? code : row;
        }
    return packed ? file + starts + lengths + data : file + data;
}

/// Noise with runs that are longer than one packet can hold.
Image8 striped(int channels) {
    Image8 image = noise(300, 5, channels);
    for (int y = 0; y < 5; ++y)
        for (int x = 40; x < 40 + 50 * y; ++x) std::fill_n(image.at(x, y), channels, uint8_t(y));
    return image;
}

TEST(Sgi, DecodesRawAndPacked) {
    for (int channels = 1; channels <= 4; ++channels)
        for (const bool packed : {false, true}) {
            SCOPED_TRACE(testing::Message() << channels << (packed ? " packed" : " raw"));
            const Image8 image = striped(channels);
            expectSame(decodeImage(asBytes(sgi(image, packed)), "some.rgb"), image);
        }
}

TEST(Sgi, RefusesDamage) {
    for (const bool packed : {false, true}) {
        const std::string good = sgi(striped(3), packed);
        // The last byte of a packed file is the end mark of a row that is already whole.
        for (size_t size = 0; size < good.size() - (packed ? 1 : 0); size += 97)
            expectHolds(errorLine([&] { decodeImage(asBytes(good.substr(0, size)), "some.rgb"); }), "some.rgb");
        const auto refuse = [&](size_t at, const char* bytes, size_t count) {
            std::string bad = good;
            bad.replace(at, count, bytes, count);
            expectHolds(errorLine([&] { decodeImage(asBytes(bad), "some.rgb"); }), "some.rgb");
        };
        refuse(3, "\2", 1);            // two bytes per channel
        refuse(6, "\0\0", 2);          // no columns
        refuse(8, "\0\0", 2);          // no rows
        refuse(10, "\0\7", 2);         // seven channels
        refuse(8, "\xff\xff", 2);      // more rows than there are bytes
        if (!packed) continue;
        refuse(512, "\x7f\xff\xff\xff", 4);                   // a row that starts beyond the end
        refuse(512 + 8 * 15, "\x7f", 1);                      // a packet that reaches beyond the row's bytes
        refuse(512 + 8 * 15, "\0", 1);                        // a row that ends before its last column
    }
}

std::string little16(size_t v) { return {char(v & 0xff), char(v >> 8)}; }

std::string tgaHeader(char type, size_t width, size_t height, char bits) {
    return std::string{0, 0, type, 0, 0, 0, 0, 0, 0, 0, 0, 0} + little16(width) + little16(height) + std::string{bits, 0x20};
}

std::string bmpHeader(uint32_t width, uint32_t height) {
    std::string file = "BM" + std::string(12, '\0') + std::string{40, 0, 0, 0};
    file[10] = 54;
    for (const uint32_t side : {width, height}) file += little16(side & 0xffff) + little16(side >> 16);
    return file + std::string{1, 0, 24, 0} + std::string(24, '\0');
}

/// Memory of this process at its highest, bytes.
size_t peakMemory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return size_t(usage.ru_maxrss) * 1024;
}

TEST(Sizes, HeadersThatAskForMoreThanThereIsAreRefusedBeforeMemoryIs) {
    const size_t before = peakMemory();
    const auto refused = [](const std::string& bytes) { expectHolds(errorLine([&] { decodeImage(asBytes(bytes), "small.img"); }), "small.img"); };
    refused(tgaHeader(2, 32768, 32768, 24) + "x");
    refused(tgaHeader(2, 4000, 4000, 32) + "some");
    refused(tgaHeader(10, 30000, 30000, 32) + std::string(400, '\x7f'));
    refused(tgaHeader(10, 4096, 4096, 24) + std::string(1000, '\x7f'));
    refused(bmpHeader(20000, 20000) + std::string(100, 'x'));
    refused(bmpHeader(3000, 3000) + std::string(100, 'x'));
    // All rows of a packed SGI image may be one and the same.
    std::string rows = std::string("\x01\xda\x01\x01\x00\x03\xff\xff\xff\xff\x00\x03", 12);
    rows.resize(512 + 8 * 65535 * 3);
    refused(rows + "\x7f" "A");
    EXPECT_LT(peakMemory(), before + (size_t(64) << 20));
}

TEST(Sizes, RunLengthCodedImagesAreRead) {
    std::string packed = tgaHeader(10, 1024, 1024, 24);
    for (int i = 0; i < 1024 * 1024 / 128; ++i) packed += "\xff" "abc";  // the most that 4 bytes can hold
    const Image8 image = decodeImage(asBytes(packed), "flat.tga");
    EXPECT_EQ(image.width, 1024);
    EXPECT_EQ(rgba(image, 1023, 1023), (std::array<uint8_t, 4>{'c', 'b', 'a', 255}));
}

TEST(Sizes, FlatImagesOfUsualSizesAreRead) {
    const Image8 flat{1024, 1024, 1, std::vector<uint8_t>(size_t(1024) * 1024, 255)};
    const std::string png = encodePng(flat);
    EXPECT_LT(png.size() * 64, flat.texels.size());
    EXPECT_EQ(decodeImage(asBytes(png), "flat.png").width, 1024);
}

/// CRC of a PNG's chunk (PNG, third edition, annex D), bit by bit.
uint32_t crc(std::string_view bytes) {
    uint32_t c = ~0u;
    for (const char byte : bytes) {
        c ^= uint8_t(byte);
        for (int k = 0; k < 8; ++k) c = (c >> 1) ^ (c & 1 ? 0xedb88320u : 0u);
    }
    return ~c;
}

TEST_F(ImageTest, PngOfManyTexelsInFewBytesIsRefused) {
    std::string png = encodePng(noise(4, 4, 1));
    const auto big32 = [&](size_t at, uint32_t v) { for (size_t k = 0; k < 4; ++k) png[at + k] = char(v >> (24 - 8 * k)); };
    big32(16, 16000), big32(20, 16000);
    big32(29, crc(std::string_view(png).substr(12, 17)));
    const size_t before = peakMemory();
    expectHolds(errorLine([&] { decodeImage(asBytes(png), "bomb.png"); }), "16000 × 16000");
    writeFile(folder_ / "bomb.png", png);
    expectHolds(errorLine([&] { readPng16(folder_ / "bomb.png"); }), "16000 × 16000");
    EXPECT_LT(peakMemory(), before + (size_t(64) << 20));
}

TEST(Inflate, RefusesWhatCannotBe) {
    EXPECT_THROW(inflate("few bytes", size_t(1) << 30), std::runtime_error);
}

TEST_F(ImageTest, ExrHeaderThatAsksForGigabytesIsRefused) {
    writeExr(folder_ / "a.exr", ImageF{2, 2, 1, {1, 2, 3, 4}});
    std::string bytes = readFile(folder_ / "a.exr");
    const int32_t far = 60000;
    for (const char* name : {"dataWindow", "displayWindow"}) {
        const size_t at = bytes.find(name) + std::strlen(name) + 1 + 6 + 4 + 8;  // "box2i", its size, xMin, yMin
        std::memcpy(&bytes[at], &far, 4);
        std::memcpy(&bytes[at + 4], &far, 4);
    }
    writeFile(folder_ / "large.exr", bytes);
    const size_t before = peakMemory();
    expectHolds(errorLine([&] { readExr(folder_ / "large.exr"); }), "large.exr");
    EXPECT_LT(peakMemory(), before + (size_t(64) << 20));
}

}  // namespace
}  // namespace dapple::base
