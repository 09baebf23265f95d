#pragma once

#include "scenegen/scene.h"

/// The parts of an arcaded court of two storeys. A bay's local x runs along the arcade, -y looks into the court, y = 0
/// is the line of the columns, z = 0 the court's floor. Every mesh is a set of closed solids.
namespace dapple::scenegen::city {

inline constexpr double kArcadeBay = 4.0;    ///< metres from column to column, and from the columns to the wall
inline constexpr double kArcadeFloor = 0.15, kGalleryFloor = 5.1;  ///< metres over the court
inline constexpr double kWallTop = 10.85;
inline constexpr double kEaves = 8.95;       ///< upper side of the roof's deck at its lower end,
inline constexpr double kOverhang = 0.8;     ///< which is so far before the columns
inline constexpr double kRidge = 5.0;        ///< distance of its upper end behind them
inline constexpr double kPitch = 0.42;       ///< rise over run of the roof

Mesh lowerColumn();       ///< round, with base and capital, from the arcade's floor to the arches' springing
Mesh upperColumn();       ///< of half the spacing, on the balustrade's plinth
Mesh lowerArch();         ///< one bay of wall over a round arch, with its mouldings on both sides
Mesh transverseArch();    ///< across the arcade, of the same span
Mesh upperArches();       ///< one bay: two arches
Mesh balustrade();        ///< one bay, plinth and rail; a balustrade has gaps where upper columns stand
Mesh roofTiles();         ///< one bay of barrel tiles, from eaves to ridge
/// Tiles of the quarter beside a bay: x from 0 (the last column) outwards, up to the valley x = y; for the other end of
/// a side `mirrored`, x from 0 to -y.
Mesh cornerTiles(bool mirrored);

Mesh pot();               ///< 0.55 m high, rim radius 0.4 m
Mesh planter();           ///< 1.5 m square, 0.55 m high
Mesh earthOf(double halfSide, double height);  ///< what plants stand in
struct Fountain {
    Mesh stone, water;
};
Fountain fountain();      ///< radius 1.75 m, 2.3 m high, with two bowls
Mesh banner();            ///< hangs from the cornice under the parapet, 1.5 m wide, in folds
Mesh curtain();           ///< hangs between two lower columns, drawn to one side
Mesh curtainRod();

}  // namespace dapple::scenegen::city
