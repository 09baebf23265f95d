#include "scenegen/plants/colonise.h"

#include "base/random.h"
#include "scenegen/plants/lanes.h"

#include <algorithm>
#include <cmath>
#include <utility>

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
        for (int axis = 0; axis < 3; ++axis) count_[axis] = int((hi[axis] - lo_[axis]) / p.influence) + 1;
        cells_.resize(size_t(count_.x) * size_t(count_.y) * size_t(count_.z));
        for (const glm::dvec3& a : points) ++cell(cellOf(a)).end;
        size_t size = 0;
        for (Cell& c : cells_) {
            c.begin = size;
            size += (std::exchange(c.end, size) + kStride - 1) / kStride * kStride;
        }
        for (std::vector<double>* column : {&x_, &y_, &z_, &distance2_}) column->resize(size);
        pull_.resize(size);
        nearest_.resize(size, -1);
        for (const glm::dvec3& a : points) {
            const size_t i = cell(cellOf(a)).end++;
            x_[i] = a.x, y_[i] = a.y, z_[i] = a.z, distance2_[i] = p.influence * p.influence;
        }
    }

    /// Attractors that the new node is nearest to are its own.
    void add(const glm::dvec3& node, int index) {
        const glm::ivec3 at = cellOf(node), from = glm::max(at - 1, glm::ivec3(0)), to = glm::min(at + 1, count_ - 1);
        for (int z = from.z; z <= to.z; ++z)
            for (int y = from.y; y <= to.y; ++y)
                for (int x = from.x; x <= to.x; ++x) add(cell({x, y, z}), node, index);
    }

    /// Of each node, the sum of the unit vectors to its attractors.
    void pulls(std::vector<glm::dvec3>& sums) const {
        std::fill(sums.begin(), sums.end(), glm::dvec3(0));
        for (const Cell& c : cells_)
            for (size_t i = c.begin; i < c.end; ++i)
                if (nearest_[i] >= 0) sums[size_t(nearest_[i])] += pull_[i];
    }

private:
    static constexpr size_t kStride = 4;
    struct Cell {
        size_t begin = 0, end = 0;  // the next begins at a multiple of kStride
    };
    glm::ivec3 cellOf(const glm::dvec3& p) const { return glm::ivec3(glm::floor((p - lo_) / p_.influence)); }
    Cell& cell(const glm::ivec3& c) { return cells_[(size_t(c.z) * size_t(count_.y) + size_t(c.y)) * size_t(count_.x) + size_t(c.x)]; }

    void add(Cell& cell, const glm::dvec3& node, int index) {
        const Pair3 from{Pair{node.x, node.x}, Pair{node.y, node.y}, Pair{node.z, node.z}};
        const auto distance2 = [&](size_t i) {
            const Pair3 d = Pair3{loadPair(&x_[i]), loadPair(&y_[i]), loadPair(&z_[i])} - from;
            return dot(d, d);
        };
        bool reached = false;
        for (size_t i = cell.begin; i < cell.end; i += kStride) {
            const Pair d[2] = {distance2(i), distance2(i + 2)};
            const auto nearer = (d[0] < loadPair(&distance2_[i])) | (d[1] < loadPair(&distance2_[i + 2]));
            if ((nearer[0] | nearer[1]) == 0) continue;  // of most
            for (size_t k = i; k < std::min(i + kStride, cell.end); ++k) {
                const double d2 = d[(k - i) / 2][(k - i) % 2];
                if (d2 >= distance2_[k]) continue;
                distance2_[k] = d2;
                nearest_[k] = index;
                pull_[k] = glm::normalize(glm::dvec3(x_[k], y_[k], z_[k]) - node);
                reached |= d2 < p_.kill * p_.kill;
            }
        }
        if (!reached) return;
        size_t left = cell.begin;
        for (size_t i = cell.begin; i < cell.end; ++i) {
            if (distance2_[i] < p_.kill * p_.kill) continue;
            x_[left] = x_[i], y_[left] = y_[i], z_[left] = z_[i], distance2_[left] = distance2_[i], pull_[left] = pull_[i], nearest_[left] = nearest_[i];
            ++left;
        }
        cell.end = left;
    }

    const ColonisationParameters& p_;
    glm::dvec3 lo_;
    glm::ivec3 count_;
    std::vector<Cell> cells_;
    std::vector<double> x_, y_, z_;    // of the attractors, cell by cell
    std::vector<double> distance2_;    // to the nearest node, at first the radius of influence
    std::vector<glm::dvec3> pull_;     // unit, from that node
    std::vector<int> nearest_;
};

std::vector<glm::dvec3> scatter(const Species& species, double height, uint64_t seed) {
    const double radius = species.prune.width * height, foot = species.baseSize * height;
    base::Random random(seed, 0, kAttractorPurpose);
    std::vector<glm::dvec3> points;
    while (points.size() < size_t(species.colonisation->attractors)) {
        const glm::dvec3 p{radius * random.next(-1, 1), radius * random.next(-1, 1), foot + (height - foot) * random.next()};  // braces: in this order
        const double across2 = p.x * p.x + p.y * p.y;
        if (across2 >= radius * radius) continue;  // a power takes long
        const double widest = radius * envelopeRatio(species.prune, (height - p.z) / (height - foot));
        if (across2 < widest * widest) points.push_back(p);
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
        pulls.resize(before);
        attractors.pulls(pulls);
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
