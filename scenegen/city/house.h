#pragma once

#include "scenegen/city/facade.h"

#include <cstdint>

/// Houses of closed perimeter blocks (Gründerzeit, vienna): wings along the streets round a courtyard, 4 to 6 storeys,
/// pitched roofs. Heights in metres over the roadway.
namespace dapple::scenegen::city {

inline constexpr double kPavement = 0.15;      ///< height of the kerb
inline constexpr double kWingDepth = 12.5;     ///< from the street's facade to the courtyard's
inline constexpr double kJoint = 0.002;        ///< what a house keeps to a party wall: no two houses share a corner

/// Labels of a wing's edges: the lot's edge for the street's facade, or one of these.
enum WingEdge { kParty = -1, kMitre = -2, kCourt = -3 };

/// One wing: where the parcel is nearer to lot edge `street` than to any other edge, down to kWingDepth: adjacent wings
/// meet on the bisector, where their roofs have the same height.
struct Wing {
    Region outline;
    Line street;  ///< the lot's edge: eaves are at distance 0
    int label = 0;
};
std::vector<Wing> wingsOf(const Region& parcel, const Region& lot);

/// What one house's facade looks like.
struct House {
    int floors = 5;
    int style = 0;  ///< 0 … kHouseStyles - 1
    uint64_t seed = 0;

    double eaves() const;  ///< height at which the roof meets the wall
    double groundFloor() const;
    double bay() const;    ///< width of a window axis
};
inline constexpr int kHouseStyles = 4;

enum class BayKind { street, shop, door, court };
/// A module of a facade to be placed: local x along the wall, -y outwards, z = 0 the roadway.
struct Placed {
    enum What { bay, balcony, dormer } what;
    BayKind kind;
    glm::dvec3 position;
    glm::dvec2 direction;  ///< of local x
};

/// The closed solids of a house, without what is instanced. With `modules`, facades are left open to them, 0.25 m deep,
/// and where they go is appended; without, this is massing: plain walls and roofs.
void addHouse(Parts& parts, const Region& parcel, const Region& lot, const House& house, std::vector<Placed>* modules);

/// The modules: one window axis from the ground to the eaves; a balcony on brackets (far: its slab); a dormer.
Parts bayModule(const House& house, BayKind kind, Detail detail = Detail::near);
Parts balconyModule(Detail detail = Detail::near);
Parts dormerModule();

}  // namespace dapple::scenegen::city
