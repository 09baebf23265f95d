#include "scenegen/plants/colonise.h"

#include "base/random.h"
#include "scenegen/plants/lanes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace dapple::scenegen {
namespace {

constexpr uint64_t kAttractorPurpose = 192;
constexpr size_t kMostNodes = 20'000;

/// Attractors with the node nearest to each, sorted into a grid whose cells are as large as the radius of influence, so
/// that what a new node can reach lies in nine rows of three cells.
class Attractors {
public:
    Attractors(const std::vector<glm::dvec3>& points, const ColonisationParameters& p) : p_(p) {
        glm::dvec3 hi = lo_ = points.empty() ? glm::dvec3(0) : points[0];
        for (const glm::dvec3& a : points) lo_ = glm::min(lo_, a), hi = glm::max(hi, a);
        for (int axis = 0; axis < 3; ++axis) count_[axis] = int((hi[axis] - lo_[axis]) / p.influence) + 1;
        first_.resize(size_t(count_.x) * size_t(count_.y) * size_t(count_.z) + 1);
        for (const glm::dvec3& a : points) ++first_[cell(cellOf(a)) + 1];
        std::partial_sum(first_.begin(), first_.end(), first_.begin());
        for (std::vector<double>* column : {&x_, &y_, &z_, &distance2_, &nearest_, &pulledBy_}) column->resize(points.size() + 1, kNone);
        pull_.resize(points.size());
        std::vector<size_t> next = first_;
        for (const glm::dvec3& a : points) {
            const size_t i = next[cell(cellOf(a))]++;
            x_[i] = a.x, y_[i] = a.y, z_[i] = a.z, distance2_[i] = p.influence * p.influence;
        }
    }

    /// Attractors that the new node is nearest to are its own.
    void add(const glm::dvec3& node, int index) {
        const glm::ivec3 at = cellOf(node), from = glm::max(at - 1, glm::ivec3(0)), to = glm::min(at + 1, count_ - 1);
        if (from.x > to.x) return;
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y) addToRow(first_[cell({from.x, y, z})], first_[cell({to.x, y, z}) + 1], node, index);
    }

    /// Of each node, the sum of the unit vectors to its attractors.
    void pulls(const std::vector<CrownNode>& nodes, std::vector<glm::dvec3>& sums) {
        dropReached();
        sums.assign(nodes.size(), glm::dvec3(0));
        for (size_t i = 0; i < first_.back(); ++i) {
            const double node = nearest_[i];
            if (node == kNone) continue;
            if (node != std::exchange(pulledBy_[i], node)) pull_[i] = glm::normalize(at(i) - nodes[size_t(node)].position);
            sums[size_t(node)] += pull_[i];
        }
    }

private:
    static constexpr double kNone = -1;
    glm::dvec3 at(size_t i) const { return {x_[i], y_[i], z_[i]}; }
    glm::ivec3 cellOf(const glm::dvec3& p) const { return glm::ivec3(glm::floor((p - lo_) / p_.influence)); }
    size_t cell(const glm::ivec3& c) const { return (size_t(c.z) * size_t(count_.y) + size_t(c.y)) * size_t(count_.x) + size_t(c.x); }

    /// Looks at one attractor past `end` perhaps, which does no harm.
    void addToRow(size_t begin, size_t end, const glm::dvec3& node, int index) {
        const Pair3 from{Pair{node.x, node.x}, Pair{node.y, node.y}, Pair{node.z, node.z}};
        // No branches: which are nearer cannot be predicted.
        for (size_t i = begin; i < end; i += 2) {
            const Pair3 d = Pair3{loadPair(&x_[i]), loadPair(&y_[i]), loadPair(&z_[i])} - from;
            const Pair old = loadPair(&distance2_[i]), d2 = dot(d, d), before = loadPair(&nearest_[i]);
            storePair(&distance2_[i], d2 < old ? d2 : old);
            storePair(&nearest_[i], d2 < old ? Pair{double(index), double(index)} : before);
        }
    }

    /// The others keep their order, and so do their sums.
    void dropReached() {
        const double reached = p_.kill * p_.kill;
        size_t to = 0;
        for (size_t c = 0, i = 0; c + 1 < first_.size(); ++c) {
            first_[c] = to;
            for (; i < first_[c + 1]; ++i) {
                if (distance2_[i] < reached) continue;
                x_[to] = x_[i], y_[to] = y_[i], z_[to] = z_[i], distance2_[to] = distance2_[i];
                pull_[to] = pull_[i], nearest_[to] = nearest_[i], pulledBy_[to] = pulledBy_[i];
                ++to;
            }
        }
        first_.back() = to;
    }

    const ColonisationParameters& p_;
    glm::dvec3 lo_;
    glm::ivec3 count_;
    std::vector<size_t> first_;        // attractor of each cell
    std::vector<double> x_, y_, z_;    // of the attractors
    std::vector<double> distance2_;    // to the nearest node, at first the radius of influence
    std::vector<double> nearest_;      // that node: whole numbers, for they are compared and kept in pairs with the distances
    std::vector<glm::dvec3> pull_;     // unit, from the node
    std::vector<double> pulledBy_;     // that pull_ was last asked for
};

std::vector<glm::dvec3> scatter(const Species& species, double height, uint64_t seed) {
    const double radius = species.prune.width * height, foot = species.baseSize * height;
    const auto wanted = size_t(species.colonisation->attractors);
    base::Random random(seed, 0, kAttractorPurpose);
    std::vector<glm::dvec3> points, drawn;
    std::vector<double> widest;
    while (points.size() < wanted) {
        // Many at a time: their powers go abreast.
        drawn.clear(), widest.clear();
        for (int i = 0; i < 96; ++i) {
            const glm::dvec3 p{radius * random.next(-1, 1), radius * random.next(-1, 1), foot + (height - foot) * random.next()};  // braces: in this order
            if (p.x * p.x + p.y * p.y >= radius * radius) continue;
            drawn.push_back(p);
            widest.push_back((height - p.z) / (height - foot));
        }
        envelopeRatios(species.prune, widest);
        for (size_t i = 0; i < drawn.size() && points.size() < wanted; ++i) {
            const double w = radius * widest[i];
            if (drawn[i].x * drawn[i].x + drawn[i].y * drawn[i].y < w * w) points.push_back(drawn[i]);
        }
    }
    return points;
}

}  // namespace

std::vector<CrownNode> colonise(const Species& species, double height, double radius, uint64_t seed) {
    const ColonisationParameters& p = *species.colonisation;
    Attractors attractors(scatter(species, height, seed), p);
    std::vector<CrownNode> nodes;
    std::vector<glm::dvec3> pulls, lastPull;  // of each node: one that pulls as before would grow the same twig again
    const auto add = [&](const glm::dvec3& position, int parent) {
        attractors.add(position, int(nodes.size()));
        nodes.push_back({position, parent, 0});
        lastPull.push_back(glm::dvec3(0));
    };
    const int trunk = std::max(1, int(species.baseSize * height / p.step));
    for (int i = 0; i <= trunk; ++i) add({0, 0, i * p.step}, i - 1);

    for (size_t before = 0; before != nodes.size() && nodes.size() < kMostNodes;) {
        before = nodes.size();
        attractors.pulls(nodes, pulls);
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
    const double whole = area[0];
    for (double& a : area) a /= whole;
    powers(area, 1 / p.pipe);
    for (size_t i = 0; i < nodes.size(); ++i) nodes[i].radius = radius * area[i];
    return nodes;
}

}  // namespace dapple::scenegen
