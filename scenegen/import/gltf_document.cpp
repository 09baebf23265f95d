#include "scenegen/import/gltf_document.h"

#include "base/error.h"
#include "base/file.h"
#include "scenegen/import/file_access.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr size_t kDeepest = 200;  ///< levels of JSON; glTF itself needs 9, the rest is for `extras`

/// What the reader does. Extensions named KHR_materials_… only change shading.
constexpr std::array kRead{"EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression",
                           "KHR_lights_punctual", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_specular", "KHR_mesh_quantization",
                           "KHR_texture_transform"};

bool isRead(const std::string& name) { return std::ranges::find(kRead, name) != kRead.end(); }
bool isShading(const std::string& name) { return name.starts_with("KHR_materials_"); }

/// Without recursion, and before anything that could recurse sees the text.
size_t depthOf(std::string_view json) {
    size_t depth = 0, deepest = 0;
    bool inText = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (inText && c == '\\') ++i;
        else if (c == '"') inText = !inText;
        else if (!inText && (c == '{' || c == '[')) deepest = std::max(deepest, ++depth);
        else if (!inText && (c == '}' || c == ']') && depth > 0) --depth;
    }
    return deepest;
}

/// RFC 3986, section 2.1.
std::string percentDecoded(const std::string& uri) {
    std::string text;
    const auto digit = [](char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1; };
    for (size_t i = 0; i < uri.size(); ++i) {
        const bool coded = uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0;
        text += coded ? char(16 * digit(uri[i + 1]) + digit(uri[i + 2])) : uri[i];
        if (coded) i += 2;
    }
    return text;
}

/// RFC 4648, section 4; anything else ends the data.
std::string base64Decoded(std::string_view text) {
    std::string bytes;
    uint32_t word = 0;
    int bits = 0;
    for (const char c : text) {
        const int value = c >= 'A' && c <= 'Z' ? c - 'A' : c >= 'a' && c <= 'z' ? c - 'a' + 26 : c >= '0' && c <= '9' ? c - '0' + 52 : c == '+' ? 62 : c == '/' ? 63 : -1;
        if (value < 0) break;
        word = word << 6 | uint32_t(value);
        bits += 6;
        if (bits < 8) continue;
        bits -= 8;
        bytes += char(word >> bits & 0xff);
    }
    return bytes;
}

size_t asIndex(const GltfDocument& document, const Json& value, const char* key) {
    if (!value.is_number_unsigned()) document.fail(fmt::format("is damaged: '{}' is missing or not a whole number that is at least 0", key));
    return value.get<size_t>();
}

std::span<const uint8_t> asBytes(std::string_view text) { return {reinterpret_cast<const uint8_t*>(text.data()), text.size()}; }

}  // namespace

const Json& member(const Json& object, const char* key) {
    static const Json none;
    const auto it = object.find(key);
    return it == object.end() ? none : *it;
}

const Json& extension(const Json& object, const char* name) { return member(member(object, "extensions"), name); }

std::string reasonOf(const Json::exception& error) {
    const std::string why = error.what();
    const size_t end = why.find("] ");
    return end == std::string::npos ? why : why.substr(end + 2);
}

GltfDocument::GltfDocument(const fs::path& file) : budget(file), file_(file) {
    bytes_ = base::readFile(file);
    uint32_t header[5] = {};  // magic, version, length; length and type of the JSON chunk
    std::memcpy(header, bytes_.data(), std::min(sizeof header, bytes_.size()));
    if (header[0] != kMagic) {
        parse(bytes_);
    } else {
        const size_t json = sizeof header + header[3];
        if (header[1] != 2) fail(fmt::format("is binary glTF of version {}; version 2 is read", header[1]));
        if (header[2] > bytes_.size() || json > header[2] || header[4] != kJsonChunk) fail("cannot be read as a scene: a truncated or damaged .glb");
        uint32_t chunk[2] = {};
        if (header[2] >= json + sizeof chunk) std::memcpy(chunk, bytes_.data() + json, sizeof chunk);
        if (chunk[1] == kBinaryChunk && chunk[0] > header[2] - json - sizeof chunk) fail("cannot be read as a scene: a truncated or damaged .glb");
        hasBinary_ = chunk[1] == kBinaryChunk;
        if (hasBinary_) binary_ = std::string_view(bytes_).substr(json + sizeof chunk, chunk[0]);
        parse(std::string_view(bytes_).substr(sizeof header, header[3]));
    }
    checkExtensions();
}

fs::path GltfDocument::folder() const { return file_.parent_path().empty() ? fs::path(".") : file_.parent_path(); }

void GltfDocument::fail(const std::string& why) const { throw base::UsageError(fmt::format("{}: {}", file_.string(), printable(why))); }

void GltfDocument::parse(std::string_view json) {
    if (depthOf(json) > kDeepest) fail(fmt::format("its JSON is nested deeper than {} levels", kDeepest));
    try {
        root_ = Json::parse(json.begin(), json.end());
    } catch (const Json::parse_error& error) {
        fail("cannot be read as a scene: " + reasonOf(error));
    }
    const Json& version = member(member(root_, "asset"), "version");
    if (!version.is_string()) fail("cannot be read as a scene: its JSON names no asset.version, so it is not glTF");
    if (!version.get_ref<const std::string&>().starts_with("2.")) fail(fmt::format("is glTF {}; version 2 is read", version.get<std::string>()));
}

void GltfDocument::checkExtensions() {
    const auto names = [&](const char* list) {
        std::vector<std::string> result;
        for (const Json& name : member(root_, list)) {
            if (!name.is_string()) fail(fmt::format("is damaged: '{}' holds something that is no name", list));
            result.push_back(name.get<std::string>());
        }
        return result;
    };
    for (const std::string& name : names("extensionsRequired"))
        if (!isRead(name) && !isShading(name)) fail(fmt::format("requires the extension {}, which is not read", name));
    for (const std::string& name : names("extensionsUsed"))
        if (!isRead(name)) notes.add(isShading(name) ? "extensions that only change shading are ignored" : "optional extensions are ignored", name);
}

size_t GltfDocument::count(const char* array) const {
    const Json& items = member(root_, array);
    if (!items.is_null() && !items.is_array()) fail(fmt::format("is damaged: '{}' is not a list", array));
    return items.size();
}

const Json& GltfDocument::item(const char* array, size_t index) const {
    if (index >= count(array)) fail(fmt::format("is damaged: asks for {}[{}], which does not exist", array, index));
    const Json& found = root_.at(array)[index];
    if (!found.is_object()) fail(fmt::format("is damaged: {}[{}] is not an object", array, index));
    return found;
}

size_t GltfDocument::index(const Json& object, const char* key) const {
    return asIndex(*this, member(object, key), key);
}

std::vector<size_t> GltfDocument::indices(const Json& object, const char* key) const {
    std::vector<size_t> result;
    for (const Json& value : member(object, key)) result.push_back(asIndex(*this, value, key));
    return result;
}

size_t GltfDocument::indexOr(const Json& object, const char* key, size_t fallback) const { return member(object, key).is_null() ? fallback : index(object, key); }

std::string GltfDocument::fileName(const std::string& uri) { return percentDecoded(uri); }

std::string GltfDocument::fetch(const std::string& uri) {
    if (uri.starts_with("data:")) {
        const size_t comma = uri.find(',');
        if (comma == std::string::npos) fail("is damaged: a data URI without data");
        const bool coded = std::string_view(uri).substr(0, comma).ends_with(";base64");
        return coded ? base64Decoded(std::string_view(uri).substr(comma + 1)) : percentDecoded(uri.substr(comma + 1));
    }
    // Programs that write a path where a URI is meant do not code it.
    for (const std::string& name : {percentDecoded(uri), uri}) {
        const fs::path path = folder() / name;
        std::error_code error;
        if (name.find('\0') != std::string::npos) continue;
        requireInside(file_, path);
        if (!fs::is_regular_file(path, error)) continue;
        budget.bytes(fs::file_size(path, error));
        return base::readFile(path);
    }
    fail(fmt::format("asks for '{}', which is not there", uri));
}

void GltfDocument::expand(size_t bytes) {
    constexpr size_t kAlways = size_t(256) << 20, kPerByte = 100;  // meshoptimizer and Draco pack plain shapes 1:60 at most
    budget.bytes(bytes);
    expanded_ += bytes;
    if (expanded_ > kAlways + kPerByte * bytes_.size())
        fail(fmt::format("asks for {} bytes of decompressed data, which is more than a file of its {} bytes may", expanded_, bytes_.size()));
}

std::span<const uint8_t> GltfDocument::buffer(size_t index) {
    const Json& json = item("buffers", index);
    const size_t length = this->index(json, "byteLength");
    std::span<const uint8_t> data;
    if (const Json& uri = member(json, "uri"); !uri.is_null()) {
        const auto [it, isNew] = buffers_.try_emplace(index);
        if (isNew) it->second = fetch(uri.get<std::string>());
        data = asBytes(it->second);
    } else if (index == 0 && hasBinary_) {
        data = asBytes(binary_);
    } else {
        fail(fmt::format("is damaged: buffers[{}] has neither a uri nor data", index));
    }
    if (data.size() < length) fail(fmt::format("is damaged: buffers[{}] has {} bytes, where it should have {}", index, data.size(), length));
    return data.first(length);
}

std::span<const uint8_t> GltfDocument::view(size_t index) {
    const Json& json = item("bufferViews", index);
    const Json& compression = extension(json, "EXT_meshopt_compression");
    if (!compression.is_null()) return decompressed(index, compression);
    const std::span<const uint8_t> data = buffer(this->index(json, "buffer"));
    const size_t offset = indexOr(json, "byteOffset", 0), length = this->index(json, "byteLength");
    if (offset > data.size() || length > data.size() - offset) fail(fmt::format("is damaged: bufferViews[{}] ends beyond its buffer", index));
    return data.subspan(offset, length);
}

/// EXT_meshopt_compression, "Decoding process".
std::span<const uint8_t> GltfDocument::decompressed(size_t index, const Json& json) {
    const auto [it, isNew] = decompressed_.try_emplace(index);
    std::vector<uint8_t>& out = it->second;
    if (!isNew) return out;
    const auto damaged = [&] { fail(fmt::format("is damaged: bufferViews[{}] cannot be decompressed", index)); };
    const std::span<const uint8_t> data = buffer(this->index(json, "buffer"));
    const size_t offset = indexOr(json, "byteOffset", 0), length = this->index(json, "byteLength");
    const size_t stride = this->index(json, "byteStride"), count = this->index(json, "count");
    if (offset > data.size() || length > data.size() - offset || stride == 0 || stride > 256 || count > std::numeric_limits<uint32_t>::max()) damaged();
    const std::string mode = json.at("mode").get<std::string>(), filter = valueOf<std::string>(json, "filter", "NONE");
    const bool vertices = mode == "ATTRIBUTES";
    if (vertices ? stride % 4 != 0 : stride != 2 && stride != 4) damaged();
    expand(stride * count);
    out.resize(stride * count);
    const uint8_t* in = data.data() + offset;
    int error = 1;
    if (vertices) error = meshopt_decodeVertexBuffer(out.data(), count, stride, in, length);
    else if (mode == "TRIANGLES" && count % 3 == 0) error = meshopt_decodeIndexBuffer(out.data(), count, stride, in, length);
    else if (mode == "INDICES") error = meshopt_decodeIndexSequence(out.data(), count, stride, in, length);
    if (error != 0) damaged();
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) meshopt_decodeFilterOct(out.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8) meshopt_decodeFilterQuat(out.data(), count, stride);
    else if (filter == "EXPONENTIAL" && stride % 4 == 0) meshopt_decodeFilterExp(out.data(), count, stride);
    else if (filter != "NONE") damaged();
    return out;
}

}  // namespace dapple::scenegen
