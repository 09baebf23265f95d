#pragma once

#include "scenegen/scene.h"

#include <cstdint>
#include <vector>

namespace dapple::scenegen {

/// Heights on a regular grid about the origin.
struct HeightField {
    int columns = 0, rows = 0;   ///< samples along x and y, at least 2 each
    double spacing = 1;          ///< metres between neighbours
    std::vector<float> heights;  ///< metres; rows · columns, from the south-west corner, x fastest

    float at(int i, int j) const { return heights[size_t(j) * size_t(columns) + size_t(i)]; }
    float& at(int i, int j) { return heights[size_t(j) * size_t(columns) + size_t(i)]; }
    double x(int i) const { return (i - 0.5 * (columns - 1)) * spacing; }
    double y(int j) const { return (j - 0.5 * (rows - 1)) * spacing; }
    /// On the triangles that terrainTile() draws at full detail; beyond the border as at the border.
    double height(double x, double y) const;
    /// Of the surface at a sample, from central differences; unit, upwards.
    glm::vec3 normal(int i, int j) const;
    /// Rise over run, across one cell about (x, y).
    double slope(double x, double y) const;
    /// Stretches the heights to run from 0 to `relief` metres.
    void stretch(double relief);
};

struct FbmOptions {
    double wavelength = 400;  ///< metres, of the first octave
    int octaves = 7;
    double gain = 0.5;        ///< amplitude of an octave over that of the one before
    double lacunarity = 2;    ///< and of their frequencies
    uint64_t seed = 1;
};

/// Fractional Brownian motion: octaves of gradient noise (Perlin 2002) over hashed lattice points; adds about ±1 times
/// the sum of the octaves' amplitudes, the first of which is 1.
void addFbm(HeightField& field, const FbmOptions& options);

/// Drops of rain run down, take soil where they speed up and leave it where they slow down (Beyer, "Implementation of a
/// method for hydraulic erosion", 2015). Heights must be metres. One drop after the other, so that the result is one.
void erode(HeightField& field, size_t droplets, uint64_t seed);

/// Samples [i0, i1] × [j0, j1] as a closed body: the surface at every `step`-th sample, walls and a floor `skirt`
/// metres below its lowest point, so that neighbours of another step show no gap. x and y are relative to the tile's
/// centre, which `centre` returns. (i1 − i0) and (j1 − j0) are multiples of `step`.
Mesh terrainTile(const HeightField& field, int i0, int j0, int i1, int j1, int step, double skirt, glm::dvec2& centre);

}  // namespace dapple::scenegen
