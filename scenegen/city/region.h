#pragma once

#include <glm/glm.hpp>

#include <vector>

/// Convex plane regions with labelled edges. Everything in a city's plan is one: cells between streets, blocks,
/// parcels, wings of buildings. Cutting a convex region by a line gives two convex regions, so that no later stage has
/// to cope with crossing outlines. Space: plan, metres.
namespace dapple::scenegen::city {

/// Points p with distance(p) > 0 lie to the left.
struct Line {
    glm::dvec2 point{0}, direction{1, 0};  ///< direction is unit

    double distance(const glm::dvec2& p) const { return direction.x * (p.y - point.y) - direction.y * (p.x - point.x); }
    double along(const glm::dvec2& p) const { return glm::dot(p - point, direction); }
    glm::dvec2 left() const { return {-direction.y, direction.x}; }
    Line moved(double toTheLeft) const { return {point + toTheLeft * left(), direction}; }
    Line reversed() const { return {point, -direction}; }
};

/// Counter-clockwise. labels[i] belongs to the edge from corners[i] to corners[i + 1].
struct Region {
    std::vector<glm::dvec2> corners;
    std::vector<int> labels;

    size_t size() const { return corners.size(); }
    bool empty() const { return corners.empty(); }
    const glm::dvec2& next(size_t i) const { return corners[i + 1 < size() ? i + 1 : 0]; }
    Line edge(size_t i) const;
    double length(size_t i) const { return glm::distance(corners[i], next(i)); }
    double area() const;
    glm::dvec2 centroid() const;
    bool contains(const glm::dvec2& p, double margin = 0) const;  ///< at least `margin` inside every edge
    double frontage() const;                                      ///< length of all edges with a label ≥ 0
};

/// The rectangle with opposite corners lo and hi, every edge labelled `label`.
Region rectangle(const glm::dvec2& lo, const glm::dvec2& hi, int label);

/// The part of `region` to the left of `line`; the new edge carries `label`. Corners nearer than a millimetre become
/// one; empty if less than a square centimetre remains.
Region clip(const Region& region, const Line& line, int label);

/// Extent along a direction and across it.
struct Extent {
    glm::dvec2 direction;  ///< unit, of the longer side
    double alongLo, alongHi, acrossLo, acrossHi;  ///< of dot(p, direction) and dot(p, left of direction)
    double length() const { return alongHi - alongLo; }
    double width() const { return acrossHi - acrossLo; }
};
/// The enclosing rectangle of least area: one side lies on an edge (Freeman & Shapira 1975).
Extent orientedBox(const Region& region);

/// Angle of a unit direction in (-π, π], counter-clockwise from +x, the same bits from every compiler.
double angleOf(const glm::dvec2& direction);

}  // namespace dapple::scenegen::city
