#include "scenegen/terrain/height_file.h"

#include "base/error.h"
#include "base/file.h"
#include "base/image.h"
#include "scenegen/terrain/holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostSamples = size_t(1) << 28;

static_assert(std::endian::native == std::endian::little, "ZIP, NPY and the readers below are little-endian");

template <class T>
std::optional<T> number(std::string_view bytes, size_t at) {
    if (at > bytes.size() || bytes.size() - at < sizeof(T)) return {};
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

/// Value of `'key': value` in a .npy header, up to the comma that ends it.
std::string_view headerValue(std::string_view header, std::string_view key) {
    const size_t at = header.find(key);
    if (at == std::string_view::npos) return {};
    const size_t from = header.find(':', at);
    return from == std::string_view::npos ? std::string_view{} : header.substr(from + 1);
}

template <class T>
std::vector<float> converted(std::string_view data, size_t count) {
    std::vector<float> values(count);
    for (size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, data.data() + i * sizeof(T), sizeof(T));
        values[i] = float(value);
    }
    return values;
}

/// A two-dimensional, row-major .npy array of little-endian numbers; nothing for arrays of another rank.
/// Throws std::runtime_error with the reason for one that it cannot read.
std::optional<base::ImageF> readNpy(std::string_view bytes) {
    if (!bytes.starts_with("\x93NUMPY") || bytes.size() < 12) throw std::runtime_error("not a numpy array");
    const bool first = bytes[6] == 1;
    const size_t length = first ? *number<uint16_t>(bytes, 8) : *number<uint32_t>(bytes, 8), begin = first ? 10 : 12;
    if (length > bytes.size() - begin) throw std::runtime_error("a numpy array's header is truncated");
    const std::string_view header = bytes.substr(begin, length), data = bytes.substr(begin + length);
    const std::string shape(headerValue(header, "'shape'")), type(headerValue(header, "'descr'"));
    int rows = 0, columns = 0;
    if (std::sscanf(shape.c_str(), " (%d, %d)", &rows, &columns) != 2) return {};
    if (!headerValue(header, "'fortran_order'").starts_with(" False")) throw std::runtime_error("its array is in Fortran order");
    const size_t count = size_t(std::max(rows, 0)) * size_t(std::max(columns, 0));
    if (count > kMostSamples) throw std::runtime_error("an array of more than 2^28 samples");
    const auto read = [&]<class T>(T) {
        if (data.size() / sizeof(T) < count) throw std::runtime_error("its array is truncated");
        return base::ImageF{columns, rows, 1, converted<T>(data, count)};
    };
    if (type.starts_with(" '<i2'")) return read(int16_t{});
    if (type.starts_with(" '<u2'")) return read(uint16_t{});
    if (type.starts_with(" '<i4'")) return read(int32_t{});
    if (type.starts_with(" '<i8'")) return read(int64_t{});
    if (type.starts_with(" '<f4'")) return read(float{});
    if (type.starts_with(" '<f8'")) return read(double{});
    if (type.starts_with(" '|u1'")) return read(uint8_t{});
    throw std::runtime_error("its array has a type that is not read:" + type.substr(0, 8));
}

/// The first two-dimensional array of a ZIP archive's local entries (numpy.savez writes no streamed ones).
base::ImageF readNpz(std::string_view zip) {
    for (size_t at = 0; number<uint32_t>(zip, at) == 0x04034b50u;) {
        const auto method = number<uint16_t>(zip, at + 8);
        const auto nameLength = number<uint16_t>(zip, at + 26), extraLength = number<uint16_t>(zip, at + 28);
        uint64_t packed = number<uint32_t>(zip, at + 18).value_or(0), size = number<uint32_t>(zip, at + 22).value_or(0);
        if (!nameLength || !extraLength) break;
        const size_t begin = at + 30 + *nameLength + *extraLength;
        if (packed == 0xffffffffu || size == 0xffffffffu) {  // ZIP64: the sizes stand in the extra field, header of 4 bytes
            size = number<uint64_t>(zip, at + 30 + *nameLength + 4).value_or(0);
            packed = number<uint64_t>(zip, at + 30 + *nameLength + 12).value_or(0);
        }
        if (begin > zip.size() || packed > zip.size() - begin) throw std::runtime_error("truncated");
        if (size > (1u << 30)) throw std::runtime_error("an array of more than 1 GiB");
        std::string entry(zip.substr(begin, packed));
        if (method == 8) entry = base::inflate(entry, size);
        else if (method != 0) throw std::runtime_error("packed with a method that is not read");
        if (auto array = readNpy(entry)) return *std::move(array);
        at = begin + packed;
    }
    throw std::runtime_error("holds no two-dimensional array");
}

/// The one channel that the heights are in; what is transparent becomes NaN. Throws for colours, which code something else.
base::ImageF greyOf(const base::ImageF& image, const fs::path& file) {
    const auto channels = size_t(image.channels);
    if (channels == 1) return image;
    const bool hasAlpha = channels == 2 || channels == 4;
    base::ImageF grey{image.width, image.height, 1, std::vector<float>(image.texels.size() / channels)};
    for (size_t i = 0; i < grey.texels.size(); ++i) {
        const float* texel = &image.texels[i * channels];
        const bool isHole = std::isnan(texel[0]);
        if (channels > 2 && !isHole && (texel[0] != texel[1] || texel[0] != texel[2]))
            throw base::UsageError(file.string() + ": is coloured, and heights coded as colours are not read; convert it "
                                                   "to one channel of heights");
        grey.texels[i] = hasAlpha && texel[channels - 1] == 0 ? NAN : texel[0];
    }
    return grey;
}

base::ImageF readGrid(const fs::path& file) {
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    if (extension == ".png") return greyOf(base::readPng16(file), file);
    if (extension == ".exr") {
        base::ImageF image = base::readExr(file);
        if (image.channels == 2)
            throw base::UsageError(file.string() + ": has channels R and G, and a height map has one channel");
        return greyOf(image, file);
    }
    if (extension == ".npz") {
        try {
            return readNpz(base::readFile(file));
        } catch (const std::runtime_error& e) {
            if (dynamic_cast<const base::Error*>(&e)) throw;
            throw base::UsageError(fmt::format("{}: not a readable numpy archive ({})", file.string(), e.what()));
        }
    }
    throw base::UsageError(fmt::format("{}: a height map is a .png, .exr or .npz file", file.string()));
}

}  // namespace

HeightField readHeights(const fs::path& file, double spacing, double vertical, Notes& notes) {
    base::ImageF grid = readGrid(file);
    if (grid.width < 2 || grid.height < 2) throw base::UsageError(fmt::format("{}: a height map needs at least 2 × 2 samples", file.string()));
    const std::vector<bool> holes = holesOf(grid);
    if (const auto count = size_t(std::count(holes.begin(), holes.end(), true)); count > 0) {
        if (count == holes.size())
            throw base::UsageError(file.string() + ": holds no height, only marks for what was not measured");
        const auto first = size_t(std::find(holes.begin(), holes.end(), true) - holes.begin());
        const size_t column = first % size_t(grid.width), row = first / size_t(grid.width);
        notes.add("samples without a height are filled from their surroundings",
                  fmt::format("column {}, row {} of {}", column, row, file.filename().string()), count);
        fillHoles(grid, holes);
    }
    HeightField field{grid.width, grid.height, spacing, {}};
    field.heights.reserve(grid.texels.size());
    for (int row = grid.height - 1; row >= 0; --row)
        for (int i = 0; i < grid.width; ++i) {
            const float z = float(grid.texels[size_t(row) * size_t(grid.width) + size_t(i)] * vertical);
            if (!std::isfinite(z))
                throw base::UsageError(fmt::format("{}: the height in column {}, row {} is beyond a float's range",
                                                   file.string(), i, row));
            field.heights.push_back(z);
        }
    return field;
}

}  // namespace dapple::scenegen
