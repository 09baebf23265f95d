#include "scenegen/city/building_tags.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dapple::scenegen::city {
namespace {
using Json = nlohmann::json;

constexpr double kHighest = 2000;  // metres; more is a slip of the unit or of the key

struct Unit {
    const char* name;
    double metres;
};
constexpr Unit kUnits[] = {
    {"", 1},        {"m", 1},        {"m.", 1},       {"meter", 1},     {"meters", 1},    {"metre", 1},
    {"metres", 1},  {"cm", 0.01},    {"km", 1000},    {"ft", 0.3048},   {"ft.", 0.3048},  {"feet", 0.3048},
    {"'", 0.3048},  {"’", 0.3048},   {"′", 0.3048},   {"foot", 0.3048}, {"in", 0.0254},   {"inch", 0.0254},
    {"\"", 0.0254}, {"''", 0.0254},  {"”", 0.0254},   {"″", 0.0254},    {"in.", 0.0254},  {"inches", 0.0254},
};

bool dropPrefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

void dropBlanks(std::string_view& text) {
    constexpr std::string_view kBlanks[] = {" ", "\t", "\n", "\r", "\u00a0"};
    const auto drop = [&](std::string_view blank) { return dropPrefix(text, blank); };
    while (std::any_of(std::begin(kBlanks), std::end(kBlanks), drop)) {}
}

/// The number that the text begins with, with a decimal point or comma; it is taken off the text.
std::optional<double> dropNumber(std::string_view& text) {
    const size_t length = std::min(text.find_first_not_of("0123456789.,"), text.size());
    std::string digits(text.substr(0, length));
    if (const size_t comma = digits.find(','); comma != digits.npos) {
        if (digits.find_first_of(".,", comma + 1) != digits.npos || digits.find('.') != digits.npos) return {};
        digits[comma] = '.';
    }
    double number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error != std::errc() || end != digits.data() + digits.size()) return {};
    text.remove_prefix(length);
    return number;
}

/// Metres of the unit that the text begins with, up to a blank or digit; it is taken off the text.
std::optional<double> dropUnit(std::string_view& text) {
    dropBlanks(text);
    const std::string_view name = text.substr(0, std::min(text.find_first_of(" \t0123456789"), text.size()));
    std::string lower(name);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    for (const Unit& unit : kUnits)
        if (lower == unit.name) {
            text.remove_prefix(name.size());
            dropBlanks(text);
            return unit.metres;
        }
    return {};
}

/// The first of the keys that says a positive number; what says something else is noted.
double firstOf(const Json& properties, std::initializer_list<const char*> keys, bool isLength, Notes& notes) {
    for (const char* key : keys) {
        const auto at = properties.find(key);
        if (at == properties.end() || at->is_null()) continue;
        std::optional<double> value;
        if (at->is_number()) value = at->get<double>();
        if (at->is_string()) {
            const std::string& text = at->get_ref<const std::string&>();
            value = parseLength(text);
            // A number of storeys has no unit.
            const bool hasUnit = text.find_first_not_of(" +~0123456789.,") != std::string::npos;
            if (!isLength && hasUnit) value.reset();
        }
        const double highest = isLength ? kHighest : kHighest / kStorey;
        if (value && *value > 0 && *value < highest) return *value;
        // 0 is for a base the usual value, and for a height none.
        if (value && *value == 0) continue;
        const char* kind = isLength ? "height" : "number of storeys";
        notes.add(fmt::format("values of {} that are no {} are ignored", key, kind), at->dump());
    }
    return 0;
}

bool says(const Json& properties, const char* key, const char* value) {
    const auto at = properties.find(key);
    return at != properties.end() && at->is_string() && at->get_ref<const std::string&>() == value;
}

/// Whether the key is there and neither null, false nor "no".
bool has(const Json& properties, const char* key) {
    const auto at = properties.find(key);
    return at != properties.end() && !at->is_null() && *at != false && !says(properties, key, "no");
}

}  // namespace

std::optional<double> parseLength(std::string_view text) {
    dropBlanks(text);
    for (const std::string_view about : {"~", "≈", "+", "ca.", "c."})
        if (dropPrefix(text, about)) dropBlanks(text);
    const bool isNegative = dropPrefix(text, "-");
    const std::optional<double> number = dropNumber(text);
    if (!number) return {};
    const std::optional<double> unit = dropUnit(text);
    if (!unit) return {};
    double metres = *number * *unit;
    if (*unit == 0.3048 && !text.empty()) {
        const std::optional<double> inches = dropNumber(text);
        const std::optional<double> inch = inches ? dropUnit(text) : std::nullopt;
        if (!inch || (*inch != 0.0254 && *inch != 1) || !text.empty()) return {};
        metres += *inches * 0.0254;
    }
    if (!text.empty()) return {};
    return isNegative ? -metres : metres;
}

BuildingTags readBuildingTags(const Json& properties, Notes& notes) {
    BuildingTags tags;
    tags.isPart = has(properties, "building:part") || says(properties, "type", "building_part");
    if (says(properties, "building", "no") && !tags.isPart) {
        tags.stands = false;
        notes.add("polygons with building=no are left out");
    }
    const auto below = properties.find("is_underground");
    if (says(properties, "location", "underground") || (below != properties.end() && *below == true)) {
        tags.stands = false;
        notes.add("buildings under the ground are left out");
    }
    if (!tags.stands) return tags;
    for (const char* key : {"roof:shape", "roof_shape"})
        if (has(properties, key) && !says(properties, key, "flat"))
            notes.add(fmt::format("roofs are flat, at the building's full height, whatever {} says", key),
                      properties[key].dump());

    tags.base = firstOf(properties, {"min_height", "render_min_height", "building:min_height"}, true, notes);
    if (tags.base == 0)
        tags.base = kStorey * firstOf(properties, {"building:min_level", "min_level", "min_floor"}, false, notes);
    tags.height = firstOf(properties, {"height", "render_height", "building:height"}, true, notes);
    if (tags.height == 0)
        tags.height = kStorey * firstOf(properties, {"building:levels", "levels", "num_floors"}, false, notes);
    tags.knowsHeight = tags.height > 0;
    if (!tags.knowsHeight) tags.height = tags.base + kUsualHeight;
    if (tags.base >= tags.height) {
        notes.add("buildings whose base is not below their height stand on the ground");
        tags.base = 0;
    }
    return tags;
}

}  // namespace dapple::scenegen::city
