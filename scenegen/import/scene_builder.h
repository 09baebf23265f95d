#pragma once

#include "scenegen/import/file_scene.h"

#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace dapple::scenegen {

/// How a file's coordinates become ours: x ↦ metresPerUnit · axes · x.
struct FileSpace {
    glm::dmat3 axes{1};  ///< entries 0 and ±1; may mirror
    double metresPerUnit = 1;

    /// Axis that points up: "x", "y", "z", "-x", "-y" or "-z".
    FileSpace(const std::string& up);
    FileSpace(char up) : FileSpace(std::string(1, up)) {}
    FileSpace(const glm::dmat3& fileAxes, double unit) : axes(fileAxes), metresPerUnit(unit) {}
};

/// Puts together a FileScene. All that does not depend on the format is here: axes and unit, the sidecar's rules, and equal
/// meshes found again. Everything handed in is in the file's own axes and units unless it says otherwise.
class SceneBuilder {
public:
    /// `space`: what the file or its format says; the sidecar's axis and unit replace it. Both references are kept.
    SceneBuilder(const std::filesystem::path& file, const Sidecar& sidecar, const FileSpace& space);

    /// In our axes; positions in metres.
    glm::dvec3 position(const glm::dvec3& p) const { return space_.metresPerUnit * (space_.axes * p); }
    glm::dvec3 direction(const glm::dvec3& d) const { return space_.axes * d; }
    double metresPerUnit() const { return space_.metresPerUnit; }

    /// Index into FileScene::materials of one that is equal but for its name.
    uint32_t addMaterial(const Material& material);

    /// Index into FileScene::meshes of `mesh`, which is in our axes already, its triangles wound as in the file. An equal mesh is not added again: some formats and
    /// readers copy a mesh for every node.
    uint32_t addMesh(Mesh mesh);

    /// A node on the way down from the root. A default one is the parent of the roots.
    struct Node {
        std::string name;
        glm::dmat4 worldFromNode{1};
        bool castsShadow = true;
    };
    /// A child of `parent`. The sidecar's receivers are told apart here.
    Node child(const Node& parent, const std::string& name, const glm::dmat4& parentFromNode);

    /// The node's meshes, by index into FileScene::meshes, as one object. The sidecar's copies and drops are applied here.
    /// Coordinates too large for float are noted.
    void addObject(const Node& node, std::vector<uint32_t> meshes);

    /// Notes a distance from the origin, in metres, if float holds it in steps of more than a millimetre.
    void noteCoarse(const std::string& name, double farthest);

    /// A camera, its vectors in the node's space. Of `lens`, fovY counts (degrees), and near and far in units of the file (far = 0: to
    /// be chosen); what cannot be is left at its default. One without a direction is left out; names are made unique, with a note.
    void addView(const Node& node, const std::string& name, const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up, const View& lens);

    /// The sun of a directional light that shines along `direction` in the node's space; nothing if it does not shine downwards.
    std::optional<Sun> sunOf(const Node& node, const glm::dvec3& direction) const;

    /// Throws UsageError when the sidecar copies a node that has not come by.
    FileScene finish();

    /// Textures, materials and notes are filled in by the reader.
    FileScene scene;

    /// Throws UsageError that names the file.
    [[noreturn]] void fail(const std::string& why) const;

private:
    glm::dmat4 conjugate(const glm::dmat4& m) const;

    const std::filesystem::path& file_;
    const Sidecar& sidecar_;
    FileSpace space_;
    using MaterialKey = std::tuple<float, float, float, float, float, int, bool, float>;
    std::map<MaterialKey, uint32_t> materials_;
    std::map<uint64_t, std::vector<uint32_t>> meshesByHash_;
    std::vector<double> farthest_;  ///< position from the mesh's origin, metres, per mesh
    std::vector<bool> copyFound_;  ///< per copy of the sidecar
};

}  // namespace dapple::scenegen
