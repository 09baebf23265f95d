#include "scenegen/import/gltf_accessors.h"

#include "scenegen/import/gltf_draco.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>

// Khronos, "glTF 2.0 Specification" (2021), section 3.6.2.
namespace dapple::scenegen {
namespace {

template <class T>
T load(const uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
}

/// Numbers of one component type.
struct Component {
    size_t bytes;
    double whole;  ///< divisor of normalised values
    double (*read)(const uint8_t*);
};

Component componentOf(const GltfDocument& document, size_t type) {
    const auto as = []<class T>(T) { return [](const uint8_t* at) { return double(load<T>(at)); }; };
    switch (type) {
        case 5120: return {1, 127, as(int8_t())};
        case 5121: return {1, 255, as(uint8_t())};
        case 5122: return {2, 32767, as(int16_t())};
        case 5123: return {2, 65535, as(uint16_t())};
        case 5125: return {4, 4294967295.0, as(uint32_t())};
        case 5126: return {4, 1, as(float())};
        default: document.fail(fmt::format("is damaged: an accessor has the component type {}, which does not exist", type));
    }
}

size_t componentsOf(const GltfDocument& document, const std::string& type) {
    for (const auto& [name, count] : {std::pair{"SCALAR", 1u}, {"VEC2", 2u}, {"VEC3", 3u}, {"VEC4", 4u}, {"MAT2", 4u}, {"MAT3", 9u}, {"MAT4", 16u}})
        if (type == name) return count;
    document.fail(fmt::format("is damaged: an accessor has the type '{}', which does not exist", type));
}

/// Elements that lie in a buffer view, one after the other.
struct Elements {
    const uint8_t* first = nullptr;
    size_t count = 0, stride = 0, components = 0;
    Component component;

    /// Calls put(element, component, value) for all.
    template <class Put>
    void forEach(const Put& put) const {
        for (size_t i = 0; i < count; ++i)
            for (size_t k = 0; k < components; ++k) put(i, k, component.read(first + i * stride + k * component.bytes));
    }
};

/// `json` names the buffer view. Throws UsageError when the elements do not lie in it.
Elements elementsOf(GltfDocument& document, const Json& json, size_t count, size_t components, size_t type) {
    const size_t view = document.index(json, "bufferView"), offset = document.indexOr(json, "byteOffset", 0);
    const std::span<const uint8_t> bytes = document.view(view);
    Elements e{nullptr, count, 0, components, componentOf(document, type)};
    const size_t size = components * e.component.bytes;
    e.stride = document.indexOr(document.item("bufferViews", view), "byteStride", size);
    if (count == 0) return e;
    if (e.stride < size) document.fail(fmt::format("is damaged: bufferViews[{}] has a byteStride that is shorter than its elements", view));
    if (offset > bytes.size() || size > bytes.size() - offset || count - 1 > (bytes.size() - offset - size) / e.stride)
        document.fail(fmt::format("is damaged: an accessor of {} elements ends beyond bufferViews[{}]", count, view));
    e.first = &bytes[offset];
    return e;
}

/// Calls prepare(count), then put(element, component, value) for all that an accessor holds. What is 0 by default is not put.
template <class Prepare, class Put>
void readAccessor(GltfDocument& document, size_t index, size_t components, const Prepare& prepare, const Put& put) {
    const Json& json = document.item("accessors", index);
    const size_t count = document.index(json, "count"), type = document.index(json, "componentType");
    const std::string shape = member(json, "type").get<std::string>();
    if (componentsOf(document, shape) != components) document.fail(fmt::format("is damaged: accessors[{}] has the type {}, which does not fit its use", index, shape));
    const double whole = valueOf(json, "normalized", false) ? componentOf(document, type).whole : 1;
    const auto scaled = [&](size_t i, size_t k, double value) { put(i, k, std::max(value / whole, whole > 1 ? -1.0 : value)); };
    // Whether the file justifies so many is tested before memory is asked for.
    Elements stored;
    if (json.contains("bufferView")) stored = elementsOf(document, json, count, components, type);
    else document.expand(count > SIZE_MAX / 64 ? SIZE_MAX : count * components * sizeof(float));
    prepare(count);
    stored.forEach(scaled);
    const Json& sparse = member(json, "sparse");
    if (sparse.is_null()) return;
    const size_t changed = document.index(sparse, "count");
    const Elements places = elementsOf(document, member(sparse, "indices"), changed, 1, document.index(member(sparse, "indices"), "componentType"));
    std::vector<size_t> at;
    places.forEach([&](size_t, size_t, double value) {
        if (!(value >= 0 && value < double(count))) document.fail(fmt::format("is damaged: accessors[{}] replaces an element that it does not have", index));
        at.push_back(size_t(value));
    });
    elementsOf(document, member(sparse, "values"), changed, components, type).forEach([&](size_t i, size_t k, double value) { scaled(at[i], k, value); });
}

}  // namespace

std::vector<float> readFloats(GltfDocument& document, size_t accessor, size_t components) {
    std::vector<float> values;
    readAccessor(document, accessor, components, [&](size_t count) { values.assign(count * components, 0.0f); },
                 [&](size_t i, size_t k, double value) { values[i * components + k] = float(value); });
    return values;
}

std::vector<uint32_t> readIndices(GltfDocument& document, size_t accessor) {
    const size_t type = document.index(document.item("accessors", accessor), "componentType");
    if (type != 5121 && type != 5123 && type != 5125) document.fail(fmt::format("is damaged: accessors[{}] holds indices that are not unsigned", accessor));
    std::vector<uint32_t> values;
    readAccessor(document, accessor, 1, [&](size_t count) { values.assign(count, 0); }, [&](size_t i, size_t, double value) { values[i] = uint32_t(value); });
    return values;
}

GltfPrimitive::GltfPrimitive(GltfDocument& document, const Json& primitive) : document_(document), json_(primitive) {
    if (!extension(primitive, "KHR_draco_mesh_compression").is_null()) draco_ = std::make_unique<DracoMesh>(document, primitive);
}

GltfPrimitive::~GltfPrimitive() = default;

bool GltfPrimitive::has(const std::string& attribute) const { return !member(member(json_, "attributes"), attribute.c_str()).is_null(); }

std::vector<float> GltfPrimitive::floats(const std::string& attribute, size_t components) const {
    if (!has(attribute)) document_.fail(fmt::format("is damaged: a primitive has no {}", attribute));
    if (draco_ && draco_->holds(attribute)) return draco_->floats(attribute, components);
    return readFloats(document_, document_.index(member(json_, "attributes"), attribute.c_str()), components);
}

std::vector<uint32_t> GltfPrimitive::triangles(size_t vertices) const {
    const size_t mode = document_.indexOr(json_, "mode", 4);
    if (mode > 6) document_.fail(fmt::format("is damaged: a primitive has the mode {}, which does not exist", mode));
    if (mode < 4) return {};
    std::vector<uint32_t> corners;
    if (draco_) corners = draco_->indices();
    else if (json_.contains("indices")) corners = readIndices(document_, document_.index(json_, "indices"));
    else corners.resize(vertices), std::iota(corners.begin(), corners.end(), 0u);
    for (const uint32_t c : corners)
        if (c >= vertices) document_.fail(fmt::format("is damaged: an index is {}, beyond the last of {} vertices", c, vertices));
    if (mode == 4) {
        if (corners.size() % 3 != 0) document_.notes.add("corners that make no triangle are left out", "", corners.size() % 3);
        corners.resize(corners.size() / 3 * 3);
        return corners;
    }
    std::vector<uint32_t> list;  // section 3.7.2.1
    for (size_t i = 0; i + 2 < corners.size(); ++i) {
        const size_t a = mode == 5 ? i : i + 1, b = mode == 5 ? i + 1 + i % 2 : i + 2, c = mode == 5 ? i + 2 - i % 2 : 0;
        list.insert(list.end(), {corners[a], corners[b], corners[c]});
    }
    return list;
}

}  // namespace dapple::scenegen
