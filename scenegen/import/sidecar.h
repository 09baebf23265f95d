#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// What a person knows about a scene file and the file does not say: NAME.toml beside NAME.ext.
///
///     up = "z"                     # axis of the file that points up: x, y, z, -x, -y or -z
///     unit = 0.01                  # metres per unit of the file, > 0
///     textures = ["textures"]      # further folders to search, relative to the file and below its folder (file_access.h)
///     drop = ["BB_*", "SkyBox"]    # node names (shell patterns) whose meshes are left out; children stay
///     receivers = ["ground*"]      # node names whose meshes, and their children's, cast no shadow
///     cell = 128.0                 # metres; edge of the squares into which small static meshes are merged
///     [[copy]]                     # one more instance of a node's meshes, dropped or not: for instancing that
///     node = "floor1010"           # Assimp does not read, such as Blender's groups
///     to = [45.9, -48.7, 1.8]      # metres, z up: replaces the node's place
///     yaw = 2.5                    # degrees about the vertical, counter-clockwise, beside its own rotation
///     [sun]
///     azimuth = 135.0              # degrees clockwise from north (+y)
///     elevation = 45.0             # degrees
///     [[view]]                     # replace the views of the file, and the chosen ones
///     name = "pit"
///     eye = [1, 2, 3]              # metres, z up, in the file's world
///     target = [1, 20, 3]          # point looked at
///     fov = 60.0                   # vertical, degrees
struct Sidecar {
    struct Copy {
        std::string node;
        glm::dvec3 to{0};
        double yaw = 0;
    };
    std::optional<std::string> up;
    std::optional<double> unit;
    std::vector<std::filesystem::path> textures;
    std::vector<std::string> drop, receivers;
    double cell = 128;
    std::vector<Copy> copies;
    std::optional<Sun> sun;
    std::vector<View> views;  ///< eye in the file's world (z up, metres); far = 0: to be chosen
};

/// The sidecar of `file`; defaults when there is none. Throws UsageError: unknown key, wrong type or range.
Sidecar readSidecar(const std::filesystem::path& file);

/// True if `name` matches one of the shell patterns (fnmatch: * ? [...]).
bool matchesAny(const std::string& name, const std::vector<std::string>& patterns);

}  // namespace dapple::scenegen
