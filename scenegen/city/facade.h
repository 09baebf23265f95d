#pragma once

#include "scenegen/city/solid.h"

namespace dapple::scenegen::city {

/// A window or door within one cell of a wall: metres from the cell's left and lower edge and below its upper one.
struct Opening {
    double side = 0, sill = 0, head = 0;  ///< wall left standing beside (either side), below and above
    double depth = 0;                     ///< of the reveal; 0: no opening

    bool exists() const { return depth > 0; }
};

/// Meshes of one building or module, by what they are made of.
struct Parts {
    Mesh wall, trim, glass, roof;
};

/// How a window is fitted out.
struct Fittings {
    bool cross = false;  ///< mullion and transom
    bool sill = false;   ///< protruding sill
    bool hood = false;   ///< protruding lintel
    bool flush = false;  ///< instead of all that, and of a reveal: a pane that stands 2 cm out of the wall
};

/// What is made of a building. All have the same walls, setbacks and roofs.
enum class Detail {
    massing,  ///< no windows at all
    far,      ///< panes flush with the wall in place of reveals, bars, sills and hoods; no ledges, railings and doors
    near,
};

/// A row of equal storeys' openings of a wall.
struct Row {
    double floor, ceiling;  ///< heights
    Opening opening;
    Fittings fittings;
};

/// Appends the face of a wall from `a` to `b` (its outside to the right of that direction), `columns` cells wide, one row
/// per entry of `rows` (each ceiling is the next floor): dented at the openings, with panes, bars, sills and hoods that
/// are closed solids of their own. The face alone is open: its outline has one corner per row and column.
void addWall(Parts& parts, const glm::dvec2& a, const glm::dvec2& b, int columns, std::span<const Row> rows);

/// Appends what closes one to four walls: floor and ceiling of an upright tower whose outline is `outline` with
/// `columns[i]` cells on its edge i.
void addLids(Mesh& mesh, std::span<const glm::dvec2> outline, std::span<const int> columns, double floor, double ceiling);

}  // namespace dapple::scenegen::city
