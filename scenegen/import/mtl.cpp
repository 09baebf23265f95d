#include "scenegen/import/mtl.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

namespace dapple::scenegen {
namespace {

constexpr std::string_view kBlanks = " \t\v\f\r";

std::string lower(std::string_view word) {
    std::string s(word);
    std::ranges::transform(s, s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

/// A comment is a # between blanks, or one that begins the line: "Material #25" is a name.
std::string_view withoutComment(std::string_view line) {
    const auto isBlank = [&](size_t at) { return trimmed(line.substr(std::min(at, line.size()), 1)).empty(); };
    for (size_t at = line.find('#'); at != std::string_view::npos; at = line.find('#', at + 1)) {
        const std::string_view before = line.substr(0, at);
        if (trimmed(before).empty() || (isBlank(at - 1) && isBlank(at + 1))) return before;
    }
    return line;
}

glm::vec3 colour(std::string_view line, const glm::vec3& before, Notes& notes) {
    double r = 0, g = 0, b = 0;
    if (!cutNumber(line, r)) {  // "spectral FILE", "xyz X Y Z"
        notes.add("colours that are not three numbers are ignored", std::string(line));
        return before;
    }
    if (!cutNumber(line, g)) return glm::vec3(float(r));
    cutNumber(line, b);
    return {float(r), float(g), float(b)};
}

/// "-s 2 2 1 -clamp on leaf.png"
MtlMaterial::Map readMap(std::string_view line, Notes& notes) {
    MtlMaterial::Map map;
    for (std::string_view rest = line; !rest.empty(); line = rest) {
        const std::string option = lower(cutWord(rest));
        if (option == "-s" || option == "-o") {
            glm::dvec2& v = option == "-s" ? map.scale : map.offset;
            double w = 0;  // of no use to a picture
            if (cutNumber(rest, v.x) && cutNumber(rest, v.y)) cutNumber(rest, w);
        } else if (option == "-clamp") {
            map.clamp = lower(cutWord(rest)) == "on";
        } else if (option == "-imfchan") {
            const std::string channel = lower(cutWord(rest));
            if (channel.size() == 1 && std::string_view("rgbml").find(channel[0]) != std::string_view::npos)
                map.channel = channel[0];
            else notes.add("options of maps are ignored", "-imfchan " + channel);
        } else if (option == "-mm" || option == "-t" || option == "-texres" || option == "-boost") {
            double number = 0;
            while (cutNumber(rest, number)) {}
            notes.add("options of maps are ignored", option);
        } else if (option == "-blendu" || option == "-blendv" || option == "-cc" || option == "-type" ||
                   option == "-bm") {
            cutWord(rest);  // how a texture is filtered, or for what: nothing that a scene has
        } else {
            break;
        }
        rest = trimmed(rest);
    }
    line = trimmed(line);
    if (line.size() >= 2 && line.front() == '"' && line.back() == '"') line = line.substr(1, line.size() - 2);
    map.file = std::string(line);
    return map;
}

}  // namespace

ObjLines::ObjLines(std::string_view text) : text_(text) {
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
}

bool ObjLines::next(std::string_view& line) {
    joined_.clear();
    for (bool more = true; more && !text_.empty();) {
        const size_t end = std::min(text_.find_first_of("\r\n"), text_.size());
        line = text_.substr(0, end);
        text_.remove_prefix(std::min(end + (text_.substr(end).starts_with("\r\n") ? 2 : 1), text_.size()));
        more = line.ends_with('\\');
        if (more) line.remove_suffix(1);
        if (more || !joined_.empty()) joined_.append(line).append(more ? " " : "");
        else {
            line = trimmed(withoutComment(line));
            if (!line.empty()) return true;
            more = true;  // to the next line that says something
        }
    }
    if (joined_.empty()) return false;
    line = trimmed(withoutComment(joined_));
    return true;
}

std::string_view cutWord(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    line.remove_prefix(word.size());
    return word;
}

bool cutNumber(std::string_view& line, double& number) {
    std::string_view rest = line, word = cutWord(rest);
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (word.empty() || end != word.data() + word.size() || error == std::errc::invalid_argument) return false;
    // Beyond double from_chars leaves the value alone: too small is 0, too large is not finite.
    if (error == std::errc::result_out_of_range)
        value = word.find("e-") == std::string_view::npos && word.find("E-") == std::string_view::npos ? HUGE_VAL : 0;
    number = value;
    line = rest;
    return true;
}

std::string_view trimmed(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

std::vector<MtlMaterial> readMtl(std::string_view text, Notes& notes) {
    // What neither casts a shadow nor catches one, and exporters write into every file.
    static const std::set<std::string> kOfNoUse = {"ka",     "ke",     "ni",      "illum", "sharpness", "map_ka",
                                                   "map_ks", "map_ns", "map_aat", "pr",    "pm",        "ps",
                                                   "pc",     "pcr",    "aniso",   "anisor"};
    std::vector<MtlMaterial> materials;
    bool hasD = false;  // d is clearer than Tr, which some programs write the other way round
    std::string_view line;
    for (ObjLines lines(text); lines.next(line);) {
        const std::string key = lower(cutWord(line));
        if (key == "newmtl") {
            materials.emplace_back().name = std::string(trimmed(line));
            hasD = false;
            continue;
        }
        if (materials.empty()) continue;
        MtlMaterial& m = materials.back();
        double number = 0;
        if (key == "kd") m.diffuse = colour(line, m.diffuse, notes);
        else if (key == "ks") m.specular = colour(line, m.specular, notes);
        else if (key == "map_kd") m.colour = readMap(trimmed(line), notes);
        else if (key == "map_d" || key == "map_opacity") m.mask = readMap(trimmed(line), notes);
        else if (key == "ns") cutNumber(line, number), m.shininess = float(number);
        else if (key == "d") {
            if (trimmed(line).starts_with("-halo")) {
                notes.add("d -halo is read as d", m.name);
                cutWord(line);
            }
            if (!cutNumber(line, number) || std::isnan(number)) continue;
            hasD = true;
            m.opacity = float(std::clamp(number, 0.0, 1.0));
        } else if (key == "tr") {
            if (!hasD && cutNumber(line, number) && !std::isnan(number))
                m.opacity = float(std::clamp(1 - number, 0.0, 1.0));
        } else if (!kOfNoUse.contains(key)) notes.add("statements of the material library are ignored", key);
    }
    return materials;
}

}  // namespace dapple::scenegen
