#include "base/image.h"

#include "base/expect_error.h"
#include "base/file.h"
#include "base/random.h"

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

}  // namespace
}  // namespace dapple::base
