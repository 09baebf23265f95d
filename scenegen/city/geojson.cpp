#include "scenegen/city/geojson.h"

#include "base/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace dapple::scenegen::city {
namespace {
using Json = nlohmann::json;

constexpr int kDeepest = 64;  // a town nests to 8; a reader that recurses must not be led to the end of its stack

[[noreturn]] void fail(const std::string& name, const std::string& why) { throw base::UsageError(name + ": " + why); }

/// Text as UTF-8: a byte order mark goes, and what is no UTF-8 is taken for Latin-1.
std::string asUtf8(std::string_view text, const std::string& name, Notes& notes) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") || text.substr(0, 4).find('\0') != text.npos)
        fail(name, "is UTF-16 or UTF-32 text, or none; GeoJSON is UTF-8");
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    bool isUtf8 = true;
    for (size_t i = 0; i < text.size() && isUtf8;) {
        const auto c = static_cast<unsigned char>(text[i]);
        const size_t length = c < 0x80 ? 1 : c < 0xc2 ? 0 : c < 0xe0 ? 2 : c < 0xf0 ? 3 : c < 0xf5 ? 4 : 0;
        isUtf8 = length > 0 && i + length <= text.size();
        for (size_t k = 1; k < length && isUtf8; ++k) isUtf8 = (static_cast<unsigned char>(text[i + k]) & 0xc0) == 0x80;
        i += length;
    }
    if (isUtf8) return std::string(text);
    notes.add("the text is not UTF-8 and is taken for Latin-1");
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) out += c;
        else out += char(0xc0 | byte >> 6), out += char(0x80 | (byte & 0x3f));
    }
    return out;
}

/// The values that stand one after the other, by their brackets; what is left over at the end counts as one more.
std::vector<std::string_view> topValues(std::string_view text, const std::string& name) {
    std::vector<std::string_view> values;
    size_t begin = 0;
    int depth = 0;
    bool inString = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\') ++i;
            else if (c == '"') inString = false;
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kDeepest) fail(name, fmt::format("is nested deeper than {}, as no GeoJSON is", kDeepest));
        } else if ((c == '}' || c == ']') && --depth == 0) {
            values.push_back(text.substr(begin, i + 1 - begin));
            begin = i + 1;
        } else if (c == '\x1e' && depth == 0) {
            begin = i + 1;  // RFC 8142 sets a record separator before each
        }
    }
    if (text.find_first_not_of(" \t\r\n", begin) != text.npos || values.empty()) values.push_back(text.substr(begin));
    return values;
}

std::string typeOf(const Json& value) {
    const auto type = value.is_object() ? value.find("type") : value.end();
    return value.is_object() && type != value.end() && type->is_string() ? type->get<std::string>() : "";
}

const Json* member(const Json& object, const char* key) {
    const auto at = object.find(key);
    return at == object.end() || at->is_null() ? nullptr : &*at;
}

class Reader {
public:
    Reader(const std::string& name, const PolygonSink& sink, Notes& notes) : name_(name), sink_(sink), notes_(notes) {}

    void root(const Json& value) {
        const std::string type = typeOf(value);
        if (type == "FeatureCollection") {
            const Json* features = member(value, "features");
            if (!features || !features->is_array()) fail(name_, "not a GeoJSON FeatureCollection: it has no features");
            readCrs(value);
            for (const Json& f : *features) feature(f);
        } else if (type == "Feature") {
            readCrs(value);
            feature(value);
        } else if (isGeometry(type)) {
            readCrs(value);
            ++number_;
            geometry(value, kNoProperties);
        } else {
            const std::string what = type.empty() ? "" : fmt::format("is of type '{}', ", printable(type));
            fail(name_, what + "not a GeoJSON FeatureCollection, Feature or geometry");
        }
    }

    std::string crs;

private:
    static bool isGeometry(const std::string& type) {
        for (const char* known : {"Polygon", "MultiPolygon", "GeometryCollection", "Point", "MultiPoint", "LineString",
                                  "MultiLineString"})
            if (type == known) return true;
        return false;
    }

    [[noreturn]] void failHere(const char* why) const { fail(name_, fmt::format("feature {}: {}", number_, why)); }

    void feature(const Json& value) {
        ++number_;
        if (!value.is_object()) return notes_.add("members of a collection that are no features are left out", label());
        const Json *shape = member(value, "geometry"), *properties = member(value, "properties");
        if (!shape) return notes_.add("features without a geometry are left out", label());
        geometry(*shape, properties && properties->is_object() ? *properties : kNoProperties);
    }

    void geometry(const Json& value, const Json& properties) {
        const std::string type = typeOf(value);
        if (type == "GeometryCollection") {
            const Json* parts = member(value, "geometries");
            if (!parts || !parts->is_array()) failHere("a collection without geometries");
            for (const Json& part : *parts) geometry(part, properties);
        } else if (type == "Polygon") {
            polygon(coordinates(value), properties);
        } else if (type == "MultiPolygon") {
            for (const Json& part : coordinates(value)) polygon(part, properties);
        } else {
            const std::string kind = isGeometry(type) ? type : "unknown type";
            notes_.add(fmt::format("geometries that are no polygons are left out: {}", kind), label());
        }
    }

    const Json& coordinates(const Json& geometry) const {
        const Json* found = member(geometry, "coordinates");
        if (!found || !found->is_array()) failHere("a polygon without coordinates");
        return *found;
    }

    void polygon(const Json& value, const Json& properties) const {
        if (!value.is_array()) failHere("a polygon is not an array of rings");
        std::vector<Ring> rings;
        for (const Json& ring : value) rings.push_back(readRing(ring));
        if (rings.empty()) return notes_.add("polygons without a ring are left out", label());
        sink_(std::move(rings), properties);
    }

    Ring readRing(const Json& value) const {
        if (!value.is_array()) failHere("a ring is not an array");
        Ring ring;
        for (const Json& p : value) {
            if (!p.is_array() || p.size() < 2 || !p[0].is_number() || !p[1].is_number())
                failHere("a coordinate is not a pair of numbers");
            ring.emplace_back(p[0].get<double>(), p[1].get<double>());
            if (!(std::abs(ring.back().x) < 1e9 && std::abs(ring.back().y) < 1e9))
                failHere("a coordinate is beyond reason");
        }
        return ring;
    }

    void readCrs(const Json& root) {
        const Json* value = member(root, "crs");
        if (!value) return;
        const Json* properties = value->is_object() ? member(*value, "properties") : nullptr;
        std::string found = "unknown kind";
        if (value->is_string()) found = value->get<std::string>();
        for (const char* key : {"href", "code", "name"})
            if (const Json* text = properties && properties->is_object() ? member(*properties, key) : nullptr)
                found = text->is_string() ? text->get<std::string>() : "EPSG:" + text->dump();
        if (!crs.empty() && crs != found) fail(name_, "names two coordinate reference systems");
        crs = found;
    }

    std::string label() const { return fmt::format("feature {}", number_); }

    static inline const Json kNoProperties = Json::object();
    const std::string& name_;
    const PolygonSink& sink_;
    Notes& notes_;
    size_t number_ = 0;
};

}  // namespace

std::string readGeoJson(std::string_view text, const std::string& name, const PolygonSink& sink, Notes& notes) {
    const std::string utf8 = asUtf8(text, name, notes);
    Reader reader(name, sink, notes);
    for (const std::string_view value : topValues(utf8, name)) {
        const Json json = Json::parse(value, nullptr, false);
        if (json.is_discarded()) fail(name, "not valid JSON");
        reader.root(json);
    }
    return reader.crs;
}

}  // namespace dapple::scenegen::city
