#include "scenegen/import/scene_bytes.h"

#include <type_traits>

namespace dapple::scenegen {
namespace {

template <class T, class Of>
concept MaybeConst = std::is_same_v<std::remove_const_t<T>, Of>;

template <class T>
constexpr bool kPlain = std::is_trivially_copyable_v<T>;

/// Structures name all of their fields here: a new one does not compile until it is added.
template <class A>
void each(A& archive, MaybeConst<base::Image8> auto& image) {
    auto& [width, height, channels, texels] = image;
    archive(width, height, channels, texels);
}
template <class A>
void each(A& archive, MaybeConst<Texture> auto& texture) {
    auto& [name, image, wrapU, wrapV] = texture;
    archive(name, image, wrapU, wrapV);
}
template <class A>
void each(A& archive, MaybeConst<Material> auto& material) {
    auto& [name, albedo, specular, shininess, texture, alphaTested, alphaCutoff, doubleSided] = material;
    archive(name, albedo, specular, shininess, texture, alphaTested, alphaCutoff, doubleSided);
}
template <class A>
void each(A& archive, MaybeConst<Mesh> auto& mesh) {
    auto& [positions, normals, uvs, indices, material] = mesh;
    archive(positions, normals, uvs, indices, material);
}
template <class A>
void each(A& archive, MaybeConst<Prototype> auto& prototype) {
    auto& [name, meshes, castsShadow, closed, moving, transmittance] = prototype;
    archive(name, meshes, castsShadow, closed, moving, transmittance);
}
template <class A>
void each(A& archive, MaybeConst<View> auto& view) {
    auto& [name, eye, forward, up, fovY, near, far] = view;
    archive(name, eye, forward, up, fovY, near, far);
}
template <class A>
void each(A& archive, MaybeConst<Scene> auto& scene) {
    auto& [name, source, origin, textures, materials, prototypes, instances, views, sun, furtherSuns, lights, motions, time, dropped, notes] = scene;
    archive(name, source, origin, textures, materials, prototypes, instances, views, sun, furtherSuns, lights, motions, time, dropped, notes);
}

struct Writer {
    base::Child::Output& out;

    void operator()(const auto&... values) { (one(values), ...); }

    template <class T>
    void one(const T& value) {
        if constexpr (kPlain<T>) {
            out.put(&value, sizeof value);
        } else if constexpr (requires { value.size(); }) {
            one(value.size());
            if constexpr (kPlain<typename T::value_type>) out.put(value.data(), value.size() * sizeof(typename T::value_type));
            else
                for (const auto& item : value) one(item);
        } else {
            each(*this, value);
        }
    }
};

struct Reader {
    base::Child& in;

    void operator()(auto&... values) { (one(values), ...); }

    template <class T>
    void one(T& value) {
        if constexpr (kPlain<T>) {
            in.get(&value, sizeof value);
        } else if constexpr (requires { value.size(); }) {
            size_t size = 0;
            one(size);
            value.resize(size);
            if constexpr (kPlain<typename T::value_type>) in.get(value.data(), size * sizeof(typename T::value_type));
            else
                for (auto& item : value) one(item);
        } else {
            each(*this, value);
        }
    }
};

}  // namespace

void put(base::Child::Output& out, const Scene& scene) { Writer{out}.one(scene); }

Scene getScene(base::Child& child) {
    Scene scene;
    Reader{child}.one(scene);
    return scene;
}

void put(base::Child::Output& out, const std::vector<std::string>& files) { Writer{out}.one(files); }

std::vector<std::string> getFiles(base::Child& child) {
    std::vector<std::string> files;
    Reader{child}.one(files);
    return files;
}

}  // namespace dapple::scenegen
