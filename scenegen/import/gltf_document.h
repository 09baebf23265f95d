#pragma once

#include "scenegen/import/budget.h"
#include "scenegen/import/notes.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace dapple::scenegen {

using Json = nlohmann::json;

/// The member `key` of `object`; an empty JSON value when there is none.
const Json& member(const Json& object, const char* key);
/// `object.extensions.name`; an empty JSON value when there is none.
const Json& extension(const Json& object, const char* name);

/// The member `key`, `fallback` where there is none. Throws Json::exception when it is of another type.
template <class T>
T valueOf(const Json& object, const char* key, const T& fallback) {
    const Json& value = member(object, key);
    return value.is_null() ? fallback : value.get<T>();
}

/// What the JSON library says is wrong, without its number.
std::string reasonOf(const Json::exception& error);

/// A vector of numbers, `fallback` when `array` is empty. Throws Json::exception when it is something else.
template <class Vec>
Vec vectorOf(const Json& array, const Vec& fallback) {
    if (array.is_null()) return fallback;
    Vec v;
    for (int i = 0; i < Vec::length(); ++i) v[i] = array.at(size_t(i)).get<typename Vec::value_type>();
    return v;
}

/// A glTF 2.0 file, .gltf or .glb: its JSON, and its bytes as they are asked for. A request for what does not exist, or for bytes
/// beyond an end, is one UsageError that names the file and the request. (Khronos, "glTF 2.0 Specification", sections 3.6 and 4.4.)
class GltfDocument {
public:
    /// Throws UsageError: not there, not glTF 2.0, nested too deep, or with a required extension that is not read.
    explicit GltfDocument(const std::filesystem::path& file);

    const Json& root() const { return root_; }
    const std::filesystem::path& file() const { return file_; }
    std::filesystem::path folder() const;

    size_t count(const char* array) const;
    /// The item `index` of a top-level array such as "meshes".
    const Json& item(const char* array, size_t index) const;
    /// An index that `object` names under `key`. indexOr: `fallback` where there is none.
    size_t index(const Json& object, const char* key) const;
    size_t indexOr(const Json& object, const char* key, size_t fallback) const;
    std::vector<size_t> indices(const Json& object, const char* key) const;

    /// Bytes of a buffer view, decompressed (EXT_meshopt_compression). They live as long as the document.
    std::span<const uint8_t> view(size_t index);
    /// Bytes that a URI names: data in the URI itself, or a file in the scene's folder. Throws UsageError: not there, or not inside.
    std::string fetch(const std::string& uri);
    /// The name of a file that a URI stands for.
    static std::string fileName(const std::string& uri);
    /// Books `bytes` of memory for which the file holds no byte of its own. Throws UsageError beyond what its size justifies.
    void expand(size_t bytes);

    [[noreturn]] void fail(const std::string& why) const;

    Budget budget;
    Notes notes;

private:
    void parse(std::string_view json);
    void checkExtensions();
    std::span<const uint8_t> buffer(size_t index);
    std::span<const uint8_t> decompressed(size_t index, const Json& compression);

    std::filesystem::path file_;
    std::string bytes_;            ///< the whole file
    std::string_view binary_;      ///< the BIN chunk of a .glb
    bool hasBinary_ = false;
    Json root_;
    std::map<size_t, std::string> buffers_;  ///< by index, from elsewhere
    std::map<size_t, std::vector<uint8_t>> decompressed_;  ///< by buffer view
    size_t expanded_ = 0;
};

}  // namespace dapple::scenegen
