#pragma once

#include "scenegen/scene.h"

namespace dapple::scenegen {

/// Moves the vertices of a mesh onto a grid of at most 65,536 steps a side, the step a power of two, so that three 16-bit
/// numbers hold a position exactly (gpuscene/pack.h). Renderer and reference see the same moved vertices. A mesh stays as
/// it is if the step would be more than 1/256 m, or if a triangle would turn by more than 60° (a twig's tip).
/// Equal positions stay equal, so what was closed stays closed.
void snapToGrid(Mesh& mesh);

/// Whether the triangles are (0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7) …: leaves, boxes. They need no indices of their own.
bool isQuadList(const Mesh& mesh);

}  // namespace dapple::scenegen
