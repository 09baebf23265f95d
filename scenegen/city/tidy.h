#pragma once

#include "scenegen/city/rings.h"

namespace dapple::scenegen::city {

/// A polygon of a file as bodies can be built on it, plan metres.
struct Tidied {
    /// Each an outline, counter-clockwise, and its holes, clockwise. Rings do not cross, but may touch themselves:
    /// where an outline and a hole touch at a point they are one ring that comes there twice.
    std::vector<std::vector<Ring>> polygons;
    size_t smallParts = 0;   ///< outlines of less than a square metre, left out
    size_t smallHoles = 0;   ///< holes of less than a square metre, filled
    size_t badHoles = 0;     ///< holes that cross another ring or lie outside the outline, filled
    bool crosses = false;    ///< the outline crosses itself: there is no polygon
};

/// `rings`: an outline and its holes, either way round, closed with or without a repeated corner. Corners within 2 cm
/// of each other are one, corners within 1 cm of an edge lie on it, and those within a millimetre of a straight line
/// go. About n log n steps.
Tidied tidied(const std::vector<Ring>& rings);

}  // namespace dapple::scenegen::city
