#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace dapple::scenegen::city {

/// Sign of the turn a → b → c, exact for all finite doubles whose products neither overflow nor underflow: positive
/// counter-clockwise, 0 on one line.
double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c);

/// Constrained Delaunay triangulation of points in the plane. Half-edge e belongs to triangle e / 3.
class Delaunay {
public:
    static constexpr uint32_t kNone = UINT32_MAX;

    /// The points are finite, distinct and not all equal. Three more points around them follow as the last.
    explicit Delaunay(std::vector<glm::dvec2> points);

    /// Makes the segment an edge, split at the points on it, and counts it as a wall once more. A point within `snap`
    /// of it counts as on it, and one within `tolerance` where this keeps two walls from crossing. False if they cross.
    bool addWall(uint32_t a, uint32_t b, double tolerance, double snap = 0);

    /// Swaps edges that are no walls until all circles are empty: triangles then are as fat as the walls allow.
    void refine();

    /// Corners of every triangle that an odd number of walls separates from the surrounding points.
    std::vector<uint32_t> insideOddWalls() const;

    /// Rings about these triangles: outlines counter-clockwise, holes clockwise. Where more than two edges meet, each
    /// ring keeps to one side: rings may touch themselves and each other, but never cross.
    std::vector<std::vector<uint32_t>> outlines() const;

private:
    static uint32_t next(uint32_t e) { return e % 3 == 2 ? e - 2 : e + 1; }
    static uint32_t prev(uint32_t e) { return e % 3 == 0 ? e + 2 : e - 1; }
    const glm::dvec2& at(uint32_t e) const { return points_[origin_[e]]; }

    void insert(uint32_t point);
    uint32_t locate(const glm::dvec2& p);
    void link(uint32_t e, uint32_t twin);
    bool isConvex(uint32_t e) const;
    bool isIllegal(uint32_t e) const;
    void flip(uint32_t e);
    void mark(uint32_t e, uint8_t odd);
    bool add(uint32_t a, uint32_t b, uint8_t odd, int depth);
    bool isNear(uint32_t point, uint32_t a, uint32_t b) const;
    struct Step {
        uint32_t to;
        bool isStraight;
    };
    Step advance(uint32_t a, uint32_t b, std::vector<uint32_t>& crossed) const;
    uint32_t detour(uint32_t a, uint32_t b, uint32_t wall, int depth);
    void flipAway(uint32_t a, uint32_t b, std::vector<uint32_t>& crossed);
    std::vector<bool> isInside() const;
    uint32_t edgeBetween(uint32_t a, uint32_t b) const;
    uint64_t random() { return state_ = state_ * 6364136223846793005u + 1442695040888963407u, state_ >> 33; }

    std::vector<glm::dvec2> points_;
    std::vector<uint32_t> origin_, twin_;  // per half-edge
    std::vector<uint8_t> wall_;            // per half-edge: 0 none, 2 an even number of walls, 3 an odd one
    std::vector<uint32_t> leaving_;        // per point: a half-edge that leaves it
    double tolerance_ = 0, snap_ = 0;      // of the wall that is being added
    uint32_t last_ = 0;
    uint64_t state_ = 1;
};

}  // namespace dapple::scenegen::city
