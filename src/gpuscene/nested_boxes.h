#pragma once

#include "gpuscene/items.h"

namespace dapple::gpuscene {

/// One of the boxes about a part's triangles, which lie in one another and hold their triangles ever more tightly: asked from the
/// outside in, few suffice to tell that a large part, which is hollow or angled, is not where its box is. Depth first.
struct NestedBox {
    glm::vec3 lo;   ///< prototype space
    uint32_t next;  ///< place of the first after those within it, which follow it
    glm::vec3 hi;
    uint32_t padding;
};
static_assert(sizeof(NestedBox) == 32);

/// The first holds all triangles; those with none within them hold one or two, or about a thousandth of all. A cluster has only the first.
std::vector<NestedBox> nestedBoxes(const scenegen::Scene& scene, const Part& part);

}  // namespace dapple::gpuscene
