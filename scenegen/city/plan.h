#pragma once

#include "scenegen/city/region.h"

#include <cstdint>

namespace dapple::scenegen::city {

enum class Style { vienna, manhattan };

struct Street {
    glm::dvec2 a, b;   ///< ends of the centre line
    double width = 0;  ///< metres between the kerbs
};

/// Land within the kerbs. `lot` is what the pavement leaves; its edge labels are its own edge indices.
struct Block {
    Region kerb;  ///< edge labels: index into Plan::streets
    Region lot;
    bool park = false;
};

struct Plan {
    std::vector<Street> streets;
    std::vector<Block> blocks;
    Region ground;  ///< everything, the outermost streets included
};

/// Bays of Manhattan's lots and buildings, metres: all parcels are multiples, so that buildings can be shared.
inline constexpr double kBay = 3.6;

/// Streets and blocks about the origin on `area` square metres.
/// vienna: a ring and radial boulevards where there is room for them, and within them cells halved again and again
///   along a cross field (radial frame blended with local grids) until blocks remain: streamlines of a tensor field as
///   in Chen et al. 2008 (Interactive Procedural Street Modeling, section 4), made straight from crossing to crossing,
///   so that every block is convex and every cut is a street.
/// manhattan: blocks of 267 × 80 m between avenues of 30 m and streets of 18 m.
Plan layOut(Style style, double area, uint64_t seed);

/// The recursive subdivision by oriented boxes of Vanegas et al. 2012 (Procedural Generation of Parcels in Urban
/// Modeling, section 4).
struct ParcelOptions {
    double areaMin = 0, areaMax = 0;  ///< square metres; each parcel draws its own bound between them
    double widthMin = 0;              ///< metres, of a parcel and of its frontage
    double irregularity = 0;          ///< 0 … 1: how far a cut may lie from the middle
    double snap = 0;                  ///< cuts at multiples of this from the box's side; 0: anywhere
};

/// Convex parcels that cover `lot`, each with a frontage: an edge with a label ≥ 0 is that edge of the lot, -1 is a
/// border between parcels.
std::vector<Region> subdivide(const Region& lot, const ParcelOptions& options, uint64_t seed);

}  // namespace dapple::scenegen::city
