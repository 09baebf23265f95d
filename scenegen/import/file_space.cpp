#include "scenegen/import/file_space.h"

#include "base/file.h"
#include "base/image.h"
#include "scenegen/import/budget.h"
#include "scenegen/import/mtl.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>

namespace dapple::scenegen {
namespace {

/// FBX says which axis points up, to the front and to the right, each with a sign, and the centimetres per unit.
FileSpace fbxSpace(const aiScene& scene) {
    int axis[3] = {0, 2, 1}, sign[3] = {1, 1, 1};  // right, front, up
    double centimetres = 1;
    if (const aiMetadata* data = scene.mMetaData) {
        const char* names[3] = {"CoordAxis", "FrontAxis", "UpAxis"};
        for (int i = 0; i < 3; ++i) {
            int32_t value = 0;
            if (data->Get(names[i], value) && value >= 0 && value <= 2) axis[i] = value;
            if (data->Get(std::string(names[i]) + "Sign", value)) sign[i] = value < 0 ? -1 : 1;
        }
        double factor = 0;
        float single = 0;
        if (!data->Get("UnitScaleFactor", factor) && data->Get("UnitScaleFactor", single)) factor = double(single);
        if (std::isfinite(factor) && factor > 0) centimetres = factor;
    }
    if (axis[0] == axis[1] || axis[1] == axis[2] || axis[0] == axis[2]) return {FileSpace('y').axes, centimetres / 100};
    glm::dmat3 axes(0);  // columns: where the file's axes go; its right to x, its front to -y, its up to z
    axes[axis[0]].x = sign[0];
    axes[axis[1]].y = -sign[1];
    axes[axis[2]].z = sign[2];
    return {axes, centimetres / 100};
}

template <class T>
T number(std::string_view bytes, size_t at) {
    T value{};
    if (at <= bytes.size() && sizeof value <= bytes.size() - at) std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// The first file in a zip archive whose name ends so; empty when there is none or it is damaged.
/// PKWARE, .ZIP File Format Specification, sections 4.3.7 and 4.3.12.
std::string fromZip(std::string_view zip, std::string_view ending, const Budget& budget) {
    for (size_t at = zip.find("PK\1\2"); at != std::string_view::npos; at = zip.find("PK\1\2", at + 1)) {
        const std::string_view name = zip.substr(std::min(at + 46, zip.size()), number<uint16_t>(zip, at + 28));
        if (!name.ends_with(ending)) continue;
        const size_t local = number<uint32_t>(zip, at + 42);
        const size_t begin = local + 30 + number<uint16_t>(zip, local + 26) + number<uint16_t>(zip, local + 28);
        const size_t size = number<uint32_t>(zip, at + 24);
        std::string bytes(zip.substr(std::min(begin, zip.size()), number<uint32_t>(zip, at + 20)));
        if (number<uint16_t>(zip, at + 10) == 0) return bytes;
        budget.bytes(size);
        try {
            return base::inflate(bytes, size);
        } catch (const std::runtime_error&) {
            return {};
        }
    }
    return {};
}

/// Value of an attribute of the first element of that name at or after `from`, which is moved behind the element;
/// nothing when there is no such element, "" when it lacks the attribute.
std::optional<std::string> attribute(std::string_view xml, std::string_view element, std::string_view name,
                                     size_t& from) {
    const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    for (size_t at = xml.find('<', from); at != std::string_view::npos; at = xml.find('<', at + 1)) {
        if (xml.substr(at + 1, element.size()) != element) continue;
        const std::string_view tag = xml.substr(at, xml.substr(at).find('>'));
        if (tag.size() > element.size() + 1 && !isBlank(tag[element.size() + 1]) && tag[element.size() + 1] != '/')
            continue;
        from = at + tag.size();
        for (size_t n = tag.find(name); n != std::string_view::npos; n = tag.find(name, n + 1)) {
            std::string_view rest = trimmed(tag.substr(n + name.size()));
            if (!isBlank(tag[n - 1]) || !rest.starts_with('=')) continue;
            rest = trimmed(rest.substr(1));
            if (rest.empty()) continue;
            return std::string(rest.substr(1, rest.substr(1).find(rest[0])));
        }
        return "";
    }
    return {};
}

/// Metres; nothing when the word is none of 3MF's and AMF's.
std::optional<double> metresOf(const std::string& unit) {
    static const std::map<std::string, double> kMetres = {{"", 1e-3},           {"millimeter", 1e-3}, {"micron", 1e-6},
                                                          {"micrometer", 1e-6}, {"centimeter", 1e-2}, {"inch", 0.0254},
                                                          {"foot", 0.3048},     {"feet", 0.3048},     {"meter", 1}};
    const auto it = kMetres.find(unit);
    return it != kMetres.end() ? std::optional(it->second) : std::nullopt;
}

/// 3MF Core Specification and ISO/ASTM 52915 (AMF): z points up, and the unit is the millimetre unless the
/// root says otherwise.
FileSpace printSpace(std::string_view xml, std::string_view root, Notes& notes) {
    size_t from = 0;
    const std::string unit = attribute(xml, root, "unit", from).value_or("");
    const std::optional<double> metres = metresOf(unit);
    if (!metres) notes.add("units that are not known are read as millimetres", unit);
    return {glm::dmat3(1), metres.value_or(1e-3)};
}

/// ISO/IEC 19775-1:2013 (X3D 3.3), UNIT statements. Without one, metres.
FileSpace x3dSpace(std::string_view xml) {
    FileSpace space('y');
    for (size_t from = 0;;) {
        size_t at = from;
        const auto category = attribute(xml, "unit", "category", from);
        if (!category) return space;
        const auto factor = attribute(xml, "unit", "conversionFactor", at);
        std::string_view text = *factor;
        double metres = 0;
        if (*category == "length" && cutNumber(text, metres) && std::isfinite(metres) && metres > 0)
            space.metresPerUnit = metres;
    }
}

/// What stands in the next braces behind the first `words`, each of which is looked for behind the one before.
std::string_view braced(std::string_view text, std::initializer_list<std::string_view> words) {
    for (const std::string_view word : words) {
        const size_t at = text.find(word);
        if (at == std::string_view::npos) return {};
        text.remove_prefix(at + word.size());
    }
    const size_t open = text.find('{');
    return open == std::string_view::npos ? std::string_view()
                                          : trimmed(text.substr(open + 1, text.substr(open + 1).find('}')));
}

/// Lengyel, OpenGEX Specification, the Metric structure.
FileSpace openGexSpace(std::string_view text) {
    const std::string_view up = braced(text, {"Metric", "\"up\"", "string"});
    FileSpace space(up.size() == 3 && (up[1] == 'x' || up[1] == 'z') ? up[1] : 'y');
    std::string_view distance = braced(text, {"Metric", "\"distance\"", "float"});
    double metres = 0;
    if (cutNumber(distance, metres) && std::isfinite(metres) && metres > 0) space.metresPerUnit = metres;
    return space;
}

/// Autodesk, DXF Reference, HEADER section, $INSUNITS; Assimp has turned z up to y.
FileSpace dxfSpace(std::string_view text) {
    static constexpr std::array<double, 17> kMetres = {1,       0.0254, 0.3048, 1609.344, 1e-3, 1e-2, 1,  1e3, 2.54e-8,
                                                       2.54e-5, 0.9144, 1e-10,  1e-9,     1e-6, 0.1,  10, 100};
    FileSpace space('y');
    const size_t at = text.find("$INSUNITS");
    if (at == std::string_view::npos) return space;
    text.remove_prefix(at + std::strlen("$INSUNITS"));
    double code = 0, unit = 0;
    std::string_view line;
    ObjLines lines(text);
    if (lines.next(line) && cutNumber(line, code) && code == 70 && lines.next(line) && cutNumber(line, unit) &&
        unit >= 0 && unit < double(kMetres.size()))
        space.metresPerUnit = kMetres[size_t(unit)];
    return space;
}

}  // namespace

FileSpace spaceOf(const aiScene& scene, const std::filesystem::path& file, Notes& notes) {
    const std::string extension = lowerExtension(file);
    if (extension == ".fbx") return fbxSpace(scene);
    if (extension == ".3mf") return printSpace(fromZip(base::readFile(file), ".model", Budget(file)), "model", notes);
    if (extension == ".amf") return printSpace(base::readFile(file), "amf", notes);
    if (extension == ".x3d") return x3dSpace(base::readFile(file));
    if (extension == ".ogex") return openGexSpace(base::readFile(file));
    if (extension == ".dxf") return dxfSpace(base::readFile(file));
    return extension == ".blend" || extension == ".stl" ? 'z' : 'y';
}

}  // namespace dapple::scenegen
