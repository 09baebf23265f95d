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
///     opens = "walk1"              # view that comes first, and so is used where none is named
///     origin = [0, 0, 0]           # metres, Scene::origin
///     trees = 105                  # over all species; required with [[species]]
///     spacing = 1.0                # crown radii that a tree keeps to its neighbours, where there is room
///     scale = 1                    # multiplies the area of ground or city, and the number of trees
///     time = 0                     # seconds: when wind and traffic are seen
///     selfThinning = false         # true: trees stand where they were sown, and the smaller of two that meet dies
///     [sun]         azimuth, elevation (degrees)
///     [[further_sun]] azimuth, elevation, strength (of its light, the sun's being 1): each casts shadows of its own
///     [ground]      size (m), undulation (m), cells, albedo; no table: no ground
///     [terrain]     size (m), cells, relief (m), wavelength (m), octaves, gain, lacunarity, droplets (of erosion), or
///                   file (.png, .exr, .npz), spacing (m), vertical (m per unit); tiles, detail (m), skirt (m), albedo
///     [[clearing]]  centre = [x, y], radius: no tree stands there
///     [[species]]   name, share, individuals, leaves = "polygon" | "card" | "solid", scale = [lo, hi],
///                   triangles (budget; solid leaves count as polygons), lod = 0 | 1 | 2 (sets the species' own budget),
///                   keep (share that decimation leaves), altitude = [lo, hi] (m) and slope (degrees) where it grows,
///                   position = [x, y] (one tree, which is not scattered), transmittance (of its shadow, 0 ≤ t < 1)
///     [wind]        strength (0 … 1), direction (degrees clockwise from north, where it comes from); with it
///                   the trees of one individual stand alike, so that all bend the same way
///     [[primitive]] kind = "box" | "sphere" | "slab" | "slivers" (triangles without area), position (centre), size or
///                   radius (sphere), albedo, transmittance (of its shadow, 0 ≤ t < 1); copies, scatter (m to each side), turned (random yaw)
///     [city]        style = "vienna" | "manhattan", trees (triangles each), traffic (moving cars per km of lane), night
///                   (lamps shine, the sun has set), nearDetail (metres from every view beyond which houses and street
///                   trees are plainer; 0: nowhere), views, fovY; or footprints = "FILE.geojson", projected, views, fovY
///     [courtyard]   bays (along the court, times scale), across, plants (triangles each), fovY
///     [path]        views, width, eyeHeight, fovY, near, far: walk0 … along a way that trees keep clear of
///     [[view]]      name, eye, target, fovY, near, far
///
/// Files count from the recipe's own folder. Throws UsageError with file, line and key for anything else. `settings`: see base::ConfigTable::set.
Scene readRecipe(const std::filesystem::path& path, const std::vector<std::string>& settings);

/// The city of a GeoJSON file, as a recipe with `[city] footprints` alone makes it; `settings` are those of a recipe.
Scene readFootprintScene(const std::filesystem::path& geojson, const std::vector<std::string>& settings);

/// The recipe's first key. Throws UsageError if it is missing.
std::string recipeDescription(const std::filesystem::path& path);

}  // namespace dapple::scenegen
