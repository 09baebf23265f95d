#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// What a person knows about a scene file and the file does not say: NAME.toml beside NAME.ext.
///
///     up = "z"                     # axis of the file that points up: x, y or z
///     unit = 0.01                  # metres per unit of the file, > 0
///     textures = ["../textures"]   # further folders to search, relative to the file
///     drop = ["BB_*", "SkyBox"]    # node names (shell patterns) that are left out with all their children
///     receivers = ["ground*"]      # node names whose meshes cast no shadow
///     cell = 128.0                 # metres; edge of the squares into which small static meshes are merged
///     [sun]
///     azimuth = 135.0              # degrees clockwise from north (+y)
///     elevation = 45.0             # degrees
///     [[view]]                     # replace the views of the file, and the chosen ones
///     name = "pit"
///     eye = [1, 2, 3]              # metres, z up, in the file's world
///     target = [1, 20, 3]          # point looked at
///     fov = 60.0                   # vertical, degrees
struct Sidecar {
    std::optional<char> up;
    double unit = 1;
    std::vector<std::filesystem::path> textures;
    std::vector<std::string> drop, receivers;
    double cell = 128;
    std::optional<Sun> sun;
    std::vector<View> views;  ///< eye in the file's world (z up, metres); far = 0: to be chosen
};

/// The sidecar of `file`; defaults when there is none. Throws UsageError: unknown key, wrong type or range.
Sidecar readSidecar(const std::filesystem::path& file);

/// True if `name` matches one of the shell patterns (fnmatch: * ? [...]).
bool matchesAny(const std::string& name, const std::vector<std::string>& patterns);

}  // namespace dapple::scenegen
