#include "visibility/occlusion_culler.h"

#include "base/random.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace dapple::visibility {

double keepProbability(uint32_t invisibleFrames) { return 0.99 - 0.7 * std::exp(-double(invisibleFrames)); }

double multiqueryValue(std::span<const double> keep) {
    double allKeep = 1;
    for (const double p : keep) allKeep *= p;
    return double(keep.size()) / (1 + (1 - allKeep) * double(keep.size()));
}

size_t multiqueryLength(std::span<const double> keep) {
    size_t length = std::min<size_t>(keep.size(), 1);
    double allKeep = length ? keep[0] : 1, best = 1;  // a single query's value is 1 whatever its chances
    for (; length < keep.size(); ++length) {
        const double size = double(length) + 1;
        allKeep *= keep[length];
        const double value = size / (1 + (1 - allKeep) * size);
        if (value < best) break;
        best = value;
    }
    return length;
}

Statistics& Statistics::operator+=(const Statistics& o) {
    for (uint64_t Statistics::*field : {&Statistics::queries, &Statistics::multiqueries, &Statistics::failedMultiqueries, &Statistics::boxes,
                                        &Statistics::wastedBoxes, &Statistics::bursts, &Statistics::stalls, &Statistics::stallNs,
                                        &Statistics::nodesVisited, &Statistics::nodesVisible, &Statistics::leavesDrawn,
                                        &Statistics::leavesAlreadyDrawn, &Statistics::trianglesDrawn})
        this->*field += o.*field;
    return *this;
}

void ViewState::reset() {
    nodes_.clear();
    dropped_.insert(dropped_.end(), leftOver_.begin(), leftOver_.end());
    leftOver_.clear();
}

void OcclusionCuller::cull(const CullView& view, ViewState& state, QueryDevice& device, LeafRenderer& renderer, const AlreadyDrawn& alreadyDrawn) {
    view_ = &view;
    state_ = &state;
    device_ = &device;
    renderer_ = &renderer;
    alreadyDrawn_ = &alreadyDrawn;
    leaves_.clear();
    statistics_ = {};
    if (state.nodes_.size() != hierarchy_->nodes().size()) state.reset();
    state.nodes_.resize(hierarchy_->nodes().size());
    for (const ViewState::Pending& pending : state.dropped_) blockOn(pending.query);
    state.dropped_.clear();
    // Still as of the frame that asked them: what was pulled up then is what this frame finds.
    for (const ViewState::Pending& pending : state.leftOver_) handle(pending, blockOn(pending.query));
    state.leftOver_.clear();
    ++state.frame_;

    if (!hierarchy_->nodes().empty()) enqueue(0);
    while (!distance_.empty() || !queries_.empty()) {
        while (!queries_.empty()) {
            std::optional<uint64_t> samples = device.poll(queries_.front().query);
            if (!samples) {
                if (!visibleLeaves_.empty()) {  // fills the wait
                    issue({visibleLeaves_.front()});
                    visibleLeaves_.pop_front();
                    continue;
                }
                if (!distance_.empty()) break;
                drawQueued();
                samples = blockOn(queries_.front().query);
            }
            const ViewState::Pending pending = std::move(queries_.front());
            queries_.pop_front();
            handle(pending, *samples);
        }
        if (!distance_.empty()) {
            const uint32_t nearest = distance_.top().node;
            distance_.pop();
            visit(nearest);
        }
        if (distance_.empty()) askInvisible();
    }
    drawQueued();
    for (const uint32_t leaf : visibleLeaves_) issue({leaf});
    visibleLeaves_.clear();
    state.leftOver_.assign(queries_.begin(), queries_.end());
    queries_.clear();
    if (asking_) device.end();
    asking_ = false;
}

void OcclusionCuller::enqueue(uint32_t node) { distance_.push({view_->key(view_->relative(hierarchy_->nodes()[node].box)), node}); }

void OcclusionCuller::visit(uint32_t n) {
    ++statistics_.nodesVisited;
    const gpuscene::Hierarchy::Node& node = hierarchy_->nodes()[n];
    const base::DBox box = view_->relative(node.box);
    if (!view_->mayContain(box)) return;
    ViewState::Node& memory = at(n);
    const bool wasVisible = memory.visible && memory.lastVisited + 1 == state_->frame_;
    memory.lastVisited = state_->frame_;
    memory.visible = false;  // until something pulls it up in this frame
    if (node.leaf() && *alreadyDrawn_ && (*alreadyDrawn_)(n)) {
        memory.drawn = state_->frame_;
        ++statistics_.nodesVisible;
        ++statistics_.leavesAlreadyDrawn;
        pullUp(n);
    } else if (settings_.algorithm == Algorithm::frustum || view_->certainlyVisible(box)) {
        pullUp(n);
        traverse(n);
    } else if (!wasVisible) {
        if (settings_.algorithm == Algorithm::chc) {
            issue({n});
        } else {
            invisible_.push_back(n);
            if (invisible_.size() >= size_t(std::max(settings_.batch, 1))) askInvisible();
        }
    } else {
        if (node.leaf()) {
            if (settings_.algorithm == Algorithm::chc) issue({n});
            else if (state_->frame_ >= memory.nextQuery) visibleLeaves_.push_back(n);
            else pullUp(n);
        }
        traverse(n);
    }
}

void OcclusionCuller::traverse(uint32_t n) {
    ++statistics_.nodesVisible;
    const gpuscene::Hierarchy::Node& node = hierarchy_->nodes()[n];
    if (!node.leaf()) {
        enqueue(n + 1);
        enqueue(node.right);
        return;
    }
    at(n).drawn = state_->frame_;
    ++statistics_.leavesDrawn;
    statistics_.trianglesDrawn += node.triangles;
    leaves_.push_back(n);
    toDraw_.push_back(n);
    if (settings_.algorithm == Algorithm::chc) drawQueued();
}

void OcclusionCuller::drawQueued() {
    if (toDraw_.empty()) return;
    if (asking_) device_->end();
    asking_ = false;
    renderer_->draw(toDraw_);
    toDraw_.clear();
}

void OcclusionCuller::askInvisible() {
    if (invisible_.empty()) return;
    drawQueued();  // the queries must see it
    std::stable_sort(invisible_.begin(), invisible_.end(), [&](uint32_t a, uint32_t b) { return at(a).invisibleFrames > at(b).invisibleFrames; });
    std::vector<double> keep;
    for (const uint32_t n : invisible_) keep.push_back(keepProbability(at(n).invisibleFrames));
    for (size_t begin = 0; begin < keep.size();) {
        const size_t length = multiqueryLength(std::span(keep).subspan(begin));
        issue({invisible_.begin() + ptrdiff_t(begin), invisible_.begin() + ptrdiff_t(begin + length)});
        begin += length;
    }
    invisible_.clear();
}

void OcclusionCuller::issue(std::vector<uint32_t> nodes) {
    if (!asking_) {
        device_->begin();
        ++statistics_.bursts;
    }
    asking_ = true;
    boxNodes_.clear();
    const int depth = settings_.algorithm == Algorithm::chc ? 0 : settings_.tightDepth;
    for (const uint32_t n : nodes) hierarchy_->tightBounds(n, depth, settings_.tightArea, boxNodes_);
    ++statistics_.queries;
    statistics_.multiqueries += nodes.size() > 1;
    statistics_.boxes += boxNodes_.size();
    const Query query = device_->issue(*hierarchy_, *view_, boxNodes_);
    queries_.push_back({query, std::move(nodes), boxNodes_.size()});
}

void OcclusionCuller::handle(const ViewState::Pending& pending, uint64_t samples) {
    const bool visible = samples > settings_.threshold;
    if (visible && pending.nodes.size() > 1) {
        ++statistics_.failedMultiqueries;
        statistics_.wastedBoxes += pending.boxes;
        for (const uint32_t n : pending.nodes) issue({n});
    } else {
        for (const uint32_t n : pending.nodes) found(n, visible);
    }
}

void OcclusionCuller::found(uint32_t n, bool visible) {
    ViewState::Node& memory = at(n);
    if (!visible) {
        ++memory.invisibleFrames;
        return;
    }
    memory.invisibleFrames = 0;
    pullUp(n);
    const bool drawn = memory.drawn == state_->frame_;  // a leaf that was visible; no other is
    const uint64_t assumed = uint64_t(std::max(settings_.assumedVisible, 0));
    const uint64_t spread = base::Random(settings_.seed, n, 0).bits(state_->frame_) % (assumed + 1);
    memory.nextQuery = state_->frame_ + uint32_t(drawn ? assumed : spread);
    if (!drawn) traverse(n);
}

void OcclusionCuller::pullUp(uint32_t n) {
    // Whatever is above was visited in this frame, so that its flag is of this frame too.
    for (; n != gpuscene::Hierarchy::kNone && !at(n).visible; n = hierarchy_->nodes()[n].parent) at(n).visible = true;
}

uint64_t OcclusionCuller::blockOn(Query query) {
    if (const std::optional<uint64_t> samples = device_->poll(query)) return *samples;
    const auto start = std::chrono::steady_clock::now();
    const uint64_t samples = device_->wait(query);
    ++statistics_.stalls;
    statistics_.stallNs += uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
    return samples;
}

}  // namespace dapple::visibility
