#include "scenegen/import/ply_file.h"

#include "base/file.h"
#include "scenegen/import/mtl.h"
#include "scenegen/import/polygon_object.h"
#include "scenegen/import/texture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>

// Turk (1994), The PLY Polygon File Format.
namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Type> typeOf(std::string_view word) {
    static const std::map<std::string_view, Type> kTypes = {
        {"char", Type::int8},     {"int8", Type::int8},       {"uchar", Type::uint8},    {"uint8", Type::uint8},
        {"short", Type::int16},   {"int16", Type::int16},     {"ushort", Type::uint16},  {"uint16", Type::uint16},
        {"int", Type::int32},     {"int32", Type::int32},     {"uint", Type::uint32},    {"uint32", Type::uint32},
        {"float", Type::float32}, {"float32", Type::float32}, {"double", Type::float64}, {"float64", Type::float64}};
    const auto it = kTypes.find(word);
    return it != kTypes.end() ? std::optional(it->second) : std::nullopt;
}

struct Property {
    std::string name;
    Type type = Type::float32;
    std::optional<Type> countType;  ///< of a list
};

struct Element {
    std::string name;
    uint64_t count = 0;
    std::vector<Property> properties;
};

class Reader {
public:
    Reader(const fs::path& file, const Sidecar& sidecar)
        : file_(file),
          builder_(file, sidecar, 'z'),
          textures_(file, sidecar),
          budget_(file),
          bytes_(base::readFile(file)) {}

    FileScene read() {
        readHeader();
        for (const Element& element : elements_) readElement(element);
        if (faces_.sizes.empty()) builder_.fail("has no triangle");
        addPolygonObject(builder_, budget_, data_, file_.stem().string(), {{&faces_, look()}});
        builder_.scene.textures = std::move(textures_.textures);
        builder_.scene.notes.add(textures_.notes);
        return builder_.finish();
    }

private:
    [[noreturn]] void fail(const std::string& why) const { builder_.fail("cannot be read as a scene: " + why); }

    std::string_view headerLine() {
        const std::string_view rest = std::string_view(bytes_).substr(at_);
        const size_t end = rest.find('\n');
        if (end == std::string_view::npos) fail("its header has no end");
        at_ += end + 1;
        return trimmed(rest.substr(0, end));
    }

    void readHeader() {
        if (headerLine() != "ply") fail("is no PLY file");
        for (std::string_view line = headerLine(); line != "end_header"; line = headerLine()) {
            const std::string key(cutWord(line));
            if (key == "format") {
                const std::string_view format = cutWord(line);
                isText_ = format == "ascii";
                isSwapped_ = format == "binary_big_endian";
                if (!isText_ && !isSwapped_ && format != "binary_little_endian") fail("its format is not known");
            } else if (key == "element") {
                Element element{std::string(cutWord(line)), 0, {}};
                const std::string_view count = cutWord(line);
                if (std::from_chars(count.data(), count.data() + count.size(), element.count).ec != std::errc{})
                    fail("an element has no count");
                elements_.push_back(std::move(element));
            } else if (key == "property") {
                readProperty(line);
            } else if (key == "comment" && cutWord(line) == "TextureFile") {
                pictures_.emplace_back(trimmed(line));
            }
        }
    }

    void readProperty(std::string_view line) {
        Property property;
        const std::string_view word = cutWord(line);
        std::optional<Type> type = typeOf(word);
        if (word == "list") {
            property.countType = typeOf(cutWord(line));
            type = typeOf(cutWord(line));
        }
        if (!type || (word == "list" && !property.countType) || elements_.empty())
            fail("a property is of no type of the format");
        property.type = *type;
        property.name = cutWord(line);
        elements_.back().properties.push_back(std::move(property));
    }

    template <class T>
    double binary() {
        if (sizeof(T) > bytes_.size() - at_) fail("it is cut short");
        std::array<char, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
        at_ += sizeof(T);
        if (isSwapped_) std::ranges::reverse(raw);
        return double(std::bit_cast<T>(raw));
    }

    double value(Type type) {
        if (isText_) {
            std::string_view rest = std::string_view(bytes_).substr(at_);
            const size_t blanks = std::min(rest.find_first_not_of(" \t\r\n"), rest.size());
            rest = rest.substr(blanks, 64);
            rest = rest.substr(0, rest.find_first_of("\r\n"));
            const size_t before = rest.size();
            double number = 0;
            if (!cutNumber(rest, number))
                fail(rest.empty() ? "it is cut short" : fmt::format("'{}' is no number", rest.substr(0, 20)));
            at_ += blanks + before - rest.size();
            return number;
        }
        switch (type) {
            case Type::int8:
                return binary<int8_t>();
            case Type::uint8:
                return binary<uint8_t>();
            case Type::int16:
                return binary<int16_t>();
            case Type::uint16:
                return binary<uint16_t>();
            case Type::int32:
                return binary<int32_t>();
            case Type::uint32:
                return binary<uint32_t>();
            case Type::float32:
                return binary<float>();
            case Type::float64:
                return binary<double>();
        }
        return 0;
    }

    /// The values of a property: one, or those of a list.
    void readValues(const Property& property, std::vector<double>& values) {
        values.clear();
        double count = 1;
        if (property.countType) count = value(*property.countType);
        if (!(count >= 0 && count <= double(bytes_.size() - at_))) fail("a list is longer than the file");
        for (size_t i = 0; i < size_t(count); ++i) values.push_back(value(property.type));
    }

    void readElement(const Element& element) {
        if (element.properties.empty()) return;  // any number of nothing
        const bool isVertex = element.name == "vertex", isFace = element.name == "face",
                   isStrip = element.name == "tristrips";
        std::vector<double> values;
        for (uint64_t i = 0; i < element.count; ++i) {
            if (i % 65536 == 0) budget_.time();
            glm::dvec3 position(0), normal(0);
            glm::dvec2 uv(0);
            bool hasNormal = false, hasUv = false;
            std::vector<double> indices, corners;
            for (const Property& property : element.properties) {
                readValues(property, values);
                const std::string& name = property.name;
                const auto is = [&](std::initializer_list<const char*> names) {
                    return std::ranges::find(names, name) != names.end();
                };
                if (isVertex && !values.empty()) {
                    for (int k = 0; k < 3; ++k)
                        if (name == std::string(1, "xyz"[k])) position[k] = values[0];
                        else if (name == std::string("n") + "xyz"[k]) normal[k] = values[0], hasNormal = true;
                    if (is({"u", "s", "texture_u"})) uv.x = values[0], hasUv = true;
                    if (is({"v", "t", "texture_v"})) uv.y = values[0], hasUv = true;
                }
                if ((isFace || isStrip) && is({"vertex_indices", "vertex_index"})) indices = values;
                if (isFace && name == "texcoord") corners = values;
            }
            if (isVertex) {
                data_.positions.push_back(position);
                if (hasNormal) data_.normals.push_back(normal);
                if (hasUv) data_.uvs.push_back(uv);
            }
            if (isFace) addFace(indices, corners);
            if (isStrip) addStrip(indices);
        }
        if (isVertex) vertexUvs_ = data_.uvs.size();
    }

    void addFace(const std::vector<double>& indices, const std::vector<double>& texcoord) {
        if (indices.size() < 3) {
            builder_.scene.notes.add("faces with fewer than three corners are ignored");
            return;
        }
        budget_.triangles(indices.size() - 2);
        faces_.sizes.push_back(uint32_t(indices.size()));
        for (size_t k = 0; k < indices.size(); ++k) {
            const auto v = indices[k] >= 0 && indices[k] < 1e15 ? int64_t(indices[k]) : Faces::Corner::kNone;
            Faces::Corner corner{v, v, v};
            if (texcoord.size() == 2 * indices.size()) {
                corner.uv = int64_t(data_.uvs.size());
                data_.uvs.emplace_back(texcoord[2 * k], texcoord[2 * k + 1]);
            } else if (corner.uv >= int64_t(vertexUvs_)) {
                corner.uv = Faces::Corner::kNone;
            }
            faces_.corners.push_back(corner);
        }
    }

    /// Every vertex makes a triangle with the two before it, each wound the other way round; -1 begins anew.
    void addStrip(const std::vector<double>& strip) {
        size_t begin = 0;
        for (size_t i = 0; i < strip.size(); ++i) {
            if (strip[i] < 0) begin = i + 1;
            else if (i >= begin + 2 && (i - begin) % 2 == 0) addFace({strip[i - 2], strip[i - 1], strip[i]}, {});
            else if (i >= begin + 2) addFace({strip[i - 1], strip[i - 2], strip[i]}, {});
        }
    }

    Look look() {
        if (pictures_.size() > 1) builder_.scene.notes.add("textures after the first are ignored", pictures_[1]);
        Material m;
        m.albedo = glm::vec3(linearFromSrgb(0.6f));  // what Assimp takes
        Look look;
        look.flat = int(builder_.addMaterial(m));
        if (!pictures_.empty()) m.texture = textures_.load({pictures_[0], {}, 0, Wrap::repeat, Wrap::repeat, {}});
        if (m.texture >= 0) m.albedo = glm::vec3(1);
        setOpacity(m, textures_.textures, m.texture, 1);
        look.textured = int(builder_.addMaterial(m));
        return look;
    }

    const fs::path& file_;
    SceneBuilder builder_;
    TextureFiles textures_;
    Budget budget_;
    std::string bytes_;
    size_t at_ = 0;
    bool isText_ = true, isSwapped_ = false;
    std::vector<Element> elements_;
    std::vector<std::string> pictures_;
    PolygonData data_;
    size_t vertexUvs_ = 0;
    Faces faces_;
};

}  // namespace

FileScene readPly(const fs::path& file, const Sidecar& sidecar) { return Reader(file, sidecar).read(); }

}  // namespace dapple::scenegen
