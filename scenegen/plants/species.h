#pragma once

#include "base/config.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// Stems of one level. The names and meanings are those of Weber and Penn, "Creation and Rendering of
/// Realistic Trees" (SIGGRAPH 1995), appendix; angles in degrees, `…V` is the largest deviation from its value.
struct LevelParameters {
    double length = 1, lengthV = 0;  ///< share of the parent's length (level 0: of the tree's scale)
    double taper = 1;                ///< 0 cylinder, 1 cone, 2 round end, 3 beads
    int curveRes = 3;                ///< segments
    double curve = 0, curveBack = 0;
    double curveV = 0;               ///< < 0: the stem is a helix, declined from its axis by the magnitude
    double segSplits = 0, splitAngle = 0, splitAngleV = 0;  ///< clones per segment
    double downAngle = 0, downAngleV = 0;  ///< V < 0: varies with the height on the parent instead of by chance
    double rotate = 140, rotateV = 0;      ///< < 0: two rows, left and right of the parent, not a helix
    double branches = 0;                   ///< most children of one parent
    int whorl = 1;                         ///< children that spring from one height (firs); not in the paper
    int sides = 4;                         ///< of the cage's rings; even, so that its caps are quads
    int refine = 0;                        ///< levels of Catmull-Clark subdivision
};

inline constexpr int kLods = 3;

/// The outlines that the paper names in section 4.9, and the diamond: two triangles, for leaves by the ten thousand.
enum class LeafShape { diamond, oval, triangle, oak3, maple3, maple5, three };
inline constexpr std::array kLeafShapes = {"diamond", "oval", "triangle", "oak3", "maple3", "maple5", "three"};

struct LeafParameters {
    double count = 20;              ///< most leaves of one twig; < 0: as many in a fan at its end
    LeafShape shape = LeafShape::diamond;  ///< at the finest level of detail, of polygons and solids
    double scale = 0.15;            ///< length, metres
    double scaleX = 0.6;            ///< width / length
    double downAngle = 50, downAngleV = 10, rotate = 140, rotateV = 20;  ///< degrees, against the twig
    double flat = 0.5;              ///< 0: the blade's side is random; 1: it faces the sky
    double bend = 0;                ///< 0…1: how far the blade turns to the light, away from the trunk (section 4.9)
    double tipScale = 1;            ///< size of a twig's last leaf over that of its first (a fern's frond)
    double cardScale = 0.6;         ///< length of a card, metres; it stands for cardLeaves leaves
    double cardScaleX = 0.8;        ///< width / length of a card
    double cardLeaves = 8;
    /// Of cards at the coarser levels, times the size that keeps their area: cards that lie over one another along a twig hide more
    /// when they are fewer and larger, and a budget of many cards makes the finest level's no smaller than half.
    std::array<double, kLods - 1> cardFar{1, 1};
    double cardDownAngle = 50;      ///< degrees, against the twig
    bool needles = false;           ///< the card shows a spray of needles, else a cluster of leaves
    glm::vec3 albedo{0.1f, 0.2f, 0.05f};  ///< linear
};

/// Section 4.6: stems that leave the envelope are shortened. Powers and widths as in the paper's Prune… parameters.
struct PruneParameters {
    double ratio = 0;            ///< 0: no pruning; 1: nothing reaches beyond the envelope
    double width = 0.5;          ///< largest radius of the envelope / height of the tree
    double widthPeak = 0.5;      ///< height of that radius, as a share of the crown from its foot
    double powerLow = 0.5, powerHigh = 0.5;  ///< curvature below and above the peak; 1: a cone
};

/// Trunk and limbs by space colonisation instead: see colonise.h. Lengths in metres.
struct ColonisationParameters {
    int attractors = 1000;
    double influence = 2.5;  ///< radius within which an attractor draws its nearest node
    double kill = 0.8;       ///< distance at which it is reached
    double step = 0.4;       ///< between nodes
    double tropism = 0;      ///< added to the unit vectors that draw a node; > 0: upwards
    double pipe = 2.4;       ///< exponent of the pipe model: 2 keeps the area of the wood, more makes limbs thicker
};

struct Species {
    std::string name;
    std::array<size_t, kLods> triangles{};  ///< budgets of the levels of detail, finest first
    int shape = 0;  ///< crown: 0 conical … 7 tend flame, 8 the pruning envelope
    double baseSize = 0.2, scale = 10, scaleV = 0;  ///< metres
    double zScale = 1, zScaleV = 0;  ///< stretches the grown tree's height alone
    double ratio = 0.02, ratioPower = 1.2, flare = 0;
    double radiusScale = 1, radiusScaleV = 0;  ///< of the trunk only: the paper's 0Scale and 0ScaleV
    int lobes = 0, baseSplits = 0;
    double lobeDepth = 0, attractionUp = 0;
    double barkShare = 0.45;  ///< largest share of a triangle budget that stems may use
    glm::vec3 barkAlbedo{0.2f};  ///< linear
    PruneParameters prune;
    /// With it, `prune` is the envelope of the attractors, stems of the first two levels come from them, and twigs
    /// have lengths and numbers as shares of the tree's height: `branches` on a stem as long as the tree.
    std::optional<ColonisationParameters> colonisation;
    std::vector<LevelParameters> levels;  ///< 2 to 4; leaves grow on the last
    LeafParameters leaves;
};

/// Every key is checked. Throws UsageError with file and line.
Species readSpecies(base::ConfigTable& table);

/// Species of that name in scenegen/plants/species. Throws UsageError with the nearest known name.
Species loadSpecies(const std::string& name);

/// All of them, sorted by name.
std::vector<std::string> listSpecies();

/// Ratio of lengths at `ratio` of the crown (0 = its top, 1 = its base): Weber and Penn, section 4.3.
double shapeRatio(int shape, double ratio);

/// The same for the pruning envelope (shape 8), in shares of its width; 0 outside 0 ≤ ratio ≤ 1.
double envelopeRatio(const PruneParameters& prune, double ratio);

/// The same of many, in place.
void envelopeRatios(const PruneParameters& prune, std::span<double> ratios);

}  // namespace dapple::scenegen
