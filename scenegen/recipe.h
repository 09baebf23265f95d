#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// Everything that determines a procedural scene, as TOML:
///
///     description = "…"            # required: one line, for `list scenes`
///     seed = 1
///     origin = [0, 0, 0]           # metres, Scene::origin
///     trees = 105                  # over all species; required with [[species]]
///     spacing = 1.0                # crown radii that a tree keeps to its neighbours, where there is room
///     [sun]         azimuth, elevation (degrees)
///     [ground]      size (m), undulation (m), cells, albedo; no table: no ground
///     [[species]]   name, share, individuals, leaves = "polygon" | "card" | "solid", scale = [lo, hi],
///                   triangles (budget; solid leaves count as polygons), lod = 0 | 1 | 2 (sets the species' own budget),
///                   keep (share that decimation leaves), position = [x, y] (one tree, which is not scattered)
///     [wind]        strength (0 … 1), direction (degrees clockwise from north, where it comes from), time (s); with it
///                   the trees of one individual stand alike, so that all bend the same way
///     [[primitive]] kind = "box" | "sphere" | "slab", position (centre), size (box, slab) or radius (sphere), albedo
///     [path]        views, width, eyeHeight, fovY, near, far: walk0 … along a way that trees keep clear of
///     [[view]]      name, eye, target, fovY, near, far
///
/// Throws UsageError with file, line and key for anything else. `settings`: see base::ConfigTable::set.
Scene readRecipe(const std::filesystem::path& path, const std::vector<std::string>& settings);

/// The recipe's first key. Throws UsageError if it is missing.
std::string recipeDescription(const std::filesystem::path& path);

}  // namespace dapple::scenegen
