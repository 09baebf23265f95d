#include "scenegen/terrain/terrain.h"

#include "scenegen/lod/connectivity.h"
#include "scenegen/primitives.h"
#include "scenegen/require_memory.h"
#include "scenegen/terrain/height_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr int kCoarsest = 8;  // samples per step at the lowest level of detail
constexpr size_t kBytesPerCell = 120;  // a height, twice, a vertex, two triangles, and the copy that the GPU is handed
constexpr int64_t kMostDroplets = 100'000'000;

/// The middle of the field, so large that every tile has a multiple of kCoarsest cells.
HeightField cropped(const HeightField& field, int tiles) {
    const int unit = tiles * kCoarsest, columns = (field.columns - 1) / unit * unit + 1, rows = (field.rows - 1) / unit * unit + 1;
    const int left = (field.columns - columns) / 2, below = (field.rows - rows) / 2;
    HeightField result{columns, rows, field.spacing, std::vector<float>(size_t(columns) * size_t(rows))};
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) result.at(i, j) = field.at(left + i, below + j);
    return result;
}

HeightField grow(base::ConfigTable& t, int tiles, uint64_t seed, double area) {
    const double side = std::sqrt(area), size = t.number("size", 1000, 1, 1e6) * side, relief = t.number("relief", 60, 0, 1e5);
    const int asked = int(t.integer("cells", 256, kCoarsest, 16384));
    // A recipe that is well at its own size stays so however small it is scaled.
    const int cells = std::max(int(std::lround(asked * side)), std::min(asked, tiles * kCoarsest));
    FbmOptions fbm;
    fbm.wavelength = t.number("wavelength", 400, 1e-3, 1e6);
    fbm.octaves = int(t.integer("octaves", fbm.octaves, 1, 16));
    fbm.gain = t.number("gain", fbm.gain, 0, 1);
    fbm.lacunarity = t.number("lacunarity", fbm.lacunarity, 1, 8);
    fbm.seed = seed;
    const double all = double(cells) * cells;
    requireMemory(t, "cells", fmt::format("{0} × {0} cells of terrain", cells), all, kBytesPerCell);
    const double droplets = double(t.integer("droplets", 0, 0, kMostDroplets)) * area;
    if (droplets > kMostDroplets)
        t.fail("droplets", fmt::format("{:.0f} droplets, times scale, are too many: at most {} fall", droplets,
                                       kMostDroplets));
    HeightField field{cells + 1, cells + 1, size / cells, std::vector<float>(size_t(cells + 1) * size_t(cells + 1))};
    addFbm(field, fbm);
    field.stretch(relief);
    erode(field, size_t(droplets), seed);
    field.stretch(relief);
    return field;
}

}  // namespace

Terrain readTerrain(base::ConfigTable& t, uint64_t seed, double area) {
    Terrain terrain;
    terrain.tiles = int(t.integer("tiles", terrain.tiles, 1, 256));
    terrain.detail = t.number("detail", terrain.detail, 0, 1e9);
    terrain.skirt = t.number("skirt", terrain.skirt, 1e-3, 1e5);
    terrain.albedo = readAlbedo(t, terrain.albedo);
    HeightField field;
    std::filesystem::path file;
    if (t.has("file")) {
        const double spacing = t.number("spacing", 1, 1e-6, 1e6), vertical = t.number("vertical", 1, -1e6, 1e6);
        file = t.path("file");
        field = readHeights(file, spacing, vertical, terrain.notes);
        const double samples = double(field.columns) * field.rows;
        requireMemory(t, "file", fmt::format("{} × {} samples", field.columns, field.rows), samples, kBytesPerCell);
    } else {
        field = grow(t, terrain.tiles, seed, area);
    }
    t.finish();
    if (std::min(field.columns, field.rows) - 1 < terrain.tiles * kCoarsest)
        t.fail("tiles", fmt::format("{} × {} samples are too few for {} tiles of at least {} cells a side", field.columns, field.rows, terrain.tiles, kCoarsest));
    terrain.field = cropped(field, terrain.tiles);
    const int columns = field.columns - terrain.field.columns, rows = field.rows - terrain.field.rows;
    if (!file.empty() && columns + rows > 0)
        terrain.notes.add(fmt::format("{} columns and {} rows at the border are left out, so that each of {} × {} tiles "
                                      "has a multiple of {} cells a side",
                                      columns, rows, terrain.tiles, terrain.tiles, kCoarsest),
                          file.filename().string());
    return terrain;
}

void addTerrain(Scene& scene, const Terrain& terrain) {
    const HeightField& field = terrain.field;
    const auto material = uint32_t(scene.materials.size());
    scene.materials.push_back({.name = "terrain", .albedo = terrain.albedo, .doubleSided = false});
    const int wide = (field.columns - 1) / terrain.tiles, deep = (field.rows - 1) / terrain.tiles;
    for (int row = 0; row < terrain.tiles; ++row)
        for (int column = 0; column < terrain.tiles; ++column) {
            const int i0 = column * wide, j0 = row * deep;
            const glm::dvec2 lo(field.x(i0), field.y(j0)), hi(field.x(i0 + wide), field.y(j0 + deep));
            double distance = 1e300;
            for (const View& view : scene.views) {
                const glm::dvec2 eye(view.eye);
                distance = std::min(distance, glm::distance(eye, glm::clamp(eye, lo, hi)));
            }
            int step = 1;
            for (double reach = terrain.detail; reach > 0 && distance > reach && step < kCoarsest; reach *= 2) step *= 2;
            glm::dvec2 centre(0);
            Mesh mesh = terrainTile(field, i0, j0, i0 + wide, j0 + deep, step, terrain.skirt, centre);
            mesh.material = material;
            Prototype prototype{fmt::format("terrain {} {}", column, row), {std::move(mesh)}, true, false};
            prototype.closed = isClosed(prototype);
            scene.prototypes.push_back(std::move(prototype));
            scene.instances.push_back({.translation = glm::vec3(centre, 0), .prototype = uint32_t(scene.prototypes.size() - 1)});
        }
}

}  // namespace dapple::scenegen
