#pragma once

#include "scenegen/import/gltf_document.h"

#include <memory>
#include <string>
#include <vector>

namespace dapple::scenegen {

class DracoMesh;

/// `components` floats per element (3 for VEC3, 16 for MAT4) of an accessor of any component type: normalised integers become
/// fractions, sparse ones are filled in. Throws UsageError: another shape, or beyond its buffer view.
std::vector<float> readFloats(GltfDocument& document, size_t accessor, size_t components);

/// A SCALAR accessor of unsigned integers.
std::vector<uint32_t> readIndices(GltfDocument& document, size_t accessor);

template <class Vec>
std::vector<Vec> asVectors(const std::vector<float>& values) {
    std::vector<Vec> vectors(values.size() / size_t(Vec::length()));
    for (size_t i = 0; i < values.size(); ++i) vectors[i / size_t(Vec::length())][int(i % size_t(Vec::length()))] = values[i];
    return vectors;
}

/// The attributes and indices of a primitive, whether compressed or not.
class GltfPrimitive {
public:
    GltfPrimitive(GltfDocument& document, const Json& primitive);
    ~GltfPrimitive();

    bool has(const std::string& attribute) const;
    /// One per vertex. Throws UsageError when the primitive has no such attribute.
    template <class Vec>
    std::vector<Vec> vectors(const std::string& attribute) const {
        return asVectors<Vec>(floats(attribute, size_t(Vec::length())));
    }
    /// Three per triangle, of lists, strips and fans, with or without indices; empty for points and lines.
    std::vector<uint32_t> triangles(size_t vertices) const;

private:
    std::vector<float> floats(const std::string& attribute, size_t components) const;

    GltfDocument& document_;
    const Json& json_;
    std::unique_ptr<DracoMesh> draco_;
};

}  // namespace dapple::scenegen
