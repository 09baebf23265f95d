#include "scenegen/plants/colonise.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

constexpr uint64_t kAttractorPurpose = 192;
constexpr size_t kMostNodes = 20'000;

/// Attractors with the node nearest to each, in a grid whose cells are as large as the radius of influence, so that
/// what a new node can reach lies in 27 cells. Those that a node has reached are gone.
class Attractors {
public:
    Attractors(const std::vector<glm::dvec3>& points, const ColonisationParameters& p) : p_(p) {
        glm::dvec3 hi = lo_ = points.empty() ? glm::dvec3(0) : points[0];
        for (const glm::dvec3& a : points) lo_ = glm::min(lo_, a), hi = glm::max(hi, a);
        for (int axis = 0; axis < 3; ++axis) cells_[axis] = int((hi[axis] - lo_[axis]) / p.influence) + 1;
        grid_.resize(size_t(cells_.x) * size_t(cells_.y) * size_t(cells_.z));
        for (const glm::dvec3& a : points) grid_[cell(glm::ivec3(glm::floor((a - lo_) / p.influence)))].push_back({a, p.influence * p.influence, -1});
    }

    /// Attractors that the new node is nearest to are its own.
    void add(const glm::dvec3& node, int index) {
        const glm::ivec3 at(glm::floor((node - lo_) / p_.influence));
        const glm::ivec3 from = glm::max(at - 1, glm::ivec3(0)), to = glm::min(at + 1, cells_ - 1);
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) {
                    std::vector<Attractor>& near = grid_[cell({x, y, z})];
                    size_t left = 0;
                    for (Attractor& a : near) {
                        const glm::dvec3 d = a.position - node;
                        const double d2 = glm::dot(d, d);
                        if (d2 < a.distance2) a.distance2 = d2, a.nearest = index;
                        if (d2 >= p_.kill * p_.kill) near[left++] = a;
                    }
                    near.resize(left);
                }
    }

    /// Of each node, the sum of the unit vectors to its attractors.
    std::vector<glm::dvec3> pulls(const std::vector<CrownNode>& nodes) const {
        std::vector<glm::dvec3> sums(nodes.size(), glm::dvec3(0));
        for (const std::vector<Attractor>& near : grid_)
            for (const Attractor& a : near)
                if (a.nearest >= 0) sums[size_t(a.nearest)] += glm::normalize(a.position - nodes[size_t(a.nearest)].position);
        return sums;
    }

private:
    struct Attractor {
        glm::dvec3 position;
        double distance2 = 0;  // to the nearest node, at first the radius of influence
        int nearest = -1;
    };
    size_t cell(const glm::ivec3& c) const { return (size_t(c.z) * size_t(cells_.y) + size_t(c.y)) * size_t(cells_.x) + size_t(c.x); }

    const ColonisationParameters& p_;
    glm::dvec3 lo_;
    glm::ivec3 cells_;
    std::vector<std::vector<Attractor>> grid_;
};

std::vector<glm::dvec3> scatter(const Species& species, double height, uint64_t seed) {
    const double radius = species.prune.width * height, foot = species.baseSize * height;
    base::Random random(seed, 0, kAttractorPurpose);
    std::vector<glm::dvec3> points;
    while (points.size() < size_t(species.colonisation->attractors)) {
        const glm::dvec3 p{radius * random.next(-1, 1), radius * random.next(-1, 1), foot + (height - foot) * random.next()};  // braces: in this order
        const double widest = radius * envelopeRatio(species.prune, (height - p.z) / (height - foot));
        if (p.x * p.x + p.y * p.y < widest * widest) points.push_back(p);
    }
    return points;
}

}  // namespace

std::vector<CrownNode> colonise(const Species& species, double height, double radius, uint64_t seed) {
    const ColonisationParameters& p = *species.colonisation;
    Attractors attractors(scatter(species, height, seed), p);
    std::vector<CrownNode> nodes;
    std::vector<glm::dvec3> lastPull;  // of each node: one that pulls as before would grow the same twig again
    const auto add = [&](const glm::dvec3& position, int parent) {
        attractors.add(position, int(nodes.size()));
        nodes.push_back({position, parent, 0});
        lastPull.push_back(glm::dvec3(0));
    };
    const int trunk = std::max(1, int(species.baseSize * height / p.step));
    for (int i = 0; i <= trunk; ++i) add({0, 0, i * p.step}, i - 1);

    for (size_t before = 0; before != nodes.size() && nodes.size() < kMostNodes;) {
        before = nodes.size();
        const std::vector<glm::dvec3> pulls = attractors.pulls(nodes);
        for (size_t i = 0; i < before; ++i) {
            if (pulls[i] == lastPull[i]) continue;
            lastPull[i] = pulls[i];
            const glm::dvec3 direction = pulls[i] + glm::dvec3(0, 0, p.tropism);
            if (glm::length(direction) > 0.05) add(nodes[i].position + glm::normalize(direction) * p.step, int(i));
        }
    }

    // The pipe model, tips of radius 1 first: children stand behind their parents.
    std::vector<double> area(nodes.size(), 0);
    for (size_t i = nodes.size(); i-- > 0;) {
        if (area[i] == 0) area[i] = 1;
        if (nodes[i].parent >= 0) area[size_t(nodes[i].parent)] += area[i];
    }
    for (size_t i = 0; i < nodes.size(); ++i) nodes[i].radius = radius * base::det::pow(area[i] / area[0], 1 / p.pipe);
    return nodes;
}

}  // namespace dapple::scenegen
