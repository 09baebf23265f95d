#pragma once

#include "gpuscene/hierarchy.h"
#include "visibility/view.h"

#include <deque>
#include <functional>
#include <optional>
#include <queue>

/// Coherent hierarchical culling: CHC (Bittner, Wimmer, Piringer, Purgathofer 2004, "Coherent Hierarchical Culling: Hardware
/// Occlusion Queries Made Useful") and CHC++ (Mattausch, Bittner, Wimmer 2008, "CHC++: Coherent Hierarchical Culling Revisited").
namespace dapple::visibility {

/// Handle of a query that is under way; its device's.
enum class Query : uint32_t {};

/// Asks how many samples of boxes pass the depth test (and the mask) as things are drawn so far.
class QueryDevice {
public:
    virtual ~QueryDevice() = default;
    /// A burst of issue() begins: nothing is drawn between them. end() leaves the state that the renderer draws with.
    virtual void begin() {}
    virtual void end() {}
    /// One query over the boxes of these nodes together.
    virtual Query issue(const gpuscene::Hierarchy& hierarchy, const CullView& view, std::span<const uint32_t> nodes) = 0;
    /// The result if it has arrived: samples that passed, or 1 for "any". Either call that returns it ends the query.
    virtual std::optional<uint64_t> poll(Query query) = 0;
    virtual uint64_t wait(Query query) = 0;  ///< blocks
};

/// Draws leaves of the hierarchy into the view, at once, so that the queries after it see them.
class LeafRenderer {
public:
    virtual ~LeafRenderer() = default;
    virtual void draw(std::span<const uint32_t> leaves) = 0;  ///< nodes, front to back, at least one
};

enum class Algorithm {
    frustum,  ///< no queries: what the planes leave
    chc,
    chcpp,
};

struct CullSettings {
    Algorithm algorithm = Algorithm::chcpp;
    uint64_t threshold = 0;  ///< samples: a box is visible when more pass. 0 is exact, more loses what is seen through gaps
    // CHC++ alone:
    int batch = 50;          ///< b ≥ 1: invisible nodes that gather before multiqueries are issued
    int assumedVisible = 5;  ///< n_av ≥ 0: a visible leaf is asked again that many frames later, at the next frame at the earliest
    int tightDepth = 3;      ///< d_max and
    double tightArea = 1.4;  ///< s_max of Hierarchy::tightBounds
    uint64_t seed = 1;       ///< of the random numbers that spread the queries of visible leaves over the frames
};

/// Of one frame of one view.
struct Statistics {
    uint64_t queries = 0;              ///< issued; the kinds below are among them
    uint64_t multiqueries = 0;         ///< over more than one node
    uint64_t failedMultiqueries = 0;   ///< visible, so that each node had to be asked again
    uint64_t boxes = 0;                ///< drawn for queries, tight bounds counted one by one
    uint64_t wastedBoxes = 0;          ///< of failed multiqueries
    uint64_t bursts = 0;               ///< switches from drawing to asking
    uint64_t stalls = 0, stallNs = 0;  ///< waits with nothing else to do; their wall time
    uint64_t nodesVisited = 0;         ///< taken from the distance queue
    uint64_t nodesVisible = 0;         ///< traversed: inner nodes opened, leaves drawn or drawn already
    uint64_t leavesDrawn = 0, leavesAlreadyDrawn = 0;
    uint64_t trianglesDrawn = 0;       ///< of the leaves drawn

    Statistics& operator+=(const Statistics& other);
};

/// What one view remembers of its last frames, one entry per node: one object for the camera, one for each light's map. It
/// follows one hierarchy, refits included; after a rebuild, reset() it.
class ViewState {
public:
    /// Everything is forgotten: for cuts, when what was visible says nothing. Queries still under way are waited for in the
    /// next frame and their results dropped.
    void reset();
    uint32_t frame() const { return frame_; }  ///< frames culled with it

private:
    friend class OcclusionCuller;
    struct Node {
        uint32_t lastVisited = 0, nextQuery = 0;  // frames
        uint32_t drawn = 0;                       // last frame in which the leaf was drawn or found drawn
        uint32_t invisibleFrames = 0;             // t_inv: consecutive tests that found it invisible
        bool visible = false;
    };
    struct Pending {
        Query query;
        std::vector<uint32_t> nodes;
        uint64_t boxes;
    };
    std::vector<Node> nodes_;
    std::vector<Pending> leftOver_, dropped_;  // queries of visible leaves, issued at the end of the last frame
    uint32_t frame_ = 0;
};

/// Whether somebody else has drawn this leaf into the view in this frame: it counts as visible, is not asked and not drawn.
using AlreadyDrawn = std::function<bool(uint32_t leaf)>;

class OcclusionCuller {
public:
    /// The hierarchy must outlive it.
    OcclusionCuller(const gpuscene::Hierarchy& hierarchy, const CullSettings& settings) : hierarchy_(&hierarchy), settings_(settings) {}

    /// Draws what is visible in one frame of one view. The depth buffer may hold something already; it must have been drawn
    /// in this frame from the same view. Blocks when a result is needed and there is nothing else to do.
    void cull(const CullView& view, ViewState& state, QueryDevice& device, LeafRenderer& renderer, const AlreadyDrawn& alreadyDrawn = {});

    /// Of the last cull(): the leaves drawn, in that order (front to back, but for those that a query brought to light).
    std::span<const uint32_t> leaves() const { return leaves_; }
    const Statistics& statistics() const { return statistics_; }

private:
    struct Entry {
        double key;
        uint32_t node;
        bool operator<(const Entry& other) const { return key != other.key ? key > other.key : node > other.node; }  // nearest on top
    };

    void enqueue(uint32_t node);
    void visit(uint32_t node);
    void traverse(uint32_t node);
    void drawQueued();
    void askInvisible();
    void issue(std::vector<uint32_t> nodes);
    void handle(const ViewState::Pending& pending, uint64_t samples);
    void found(uint32_t node, bool visible);
    void pullUp(uint32_t node);
    ViewState::Node& at(uint32_t node) { return state_->nodes_[node]; }
    uint64_t blockOn(Query query);

    const gpuscene::Hierarchy* hierarchy_;
    CullSettings settings_;
    std::vector<uint32_t> leaves_;
    Statistics statistics_;
    // Of the frame under way.
    const CullView* view_ = nullptr;
    ViewState* state_ = nullptr;
    QueryDevice* device_ = nullptr;
    LeafRenderer* renderer_ = nullptr;
    const AlreadyDrawn* alreadyDrawn_ = nullptr;
    std::priority_queue<Entry> distance_;
    std::deque<ViewState::Pending> queries_;
    std::deque<uint32_t> visibleLeaves_;       // v-queue
    std::vector<uint32_t> invisible_;          // i-queue
    std::vector<uint32_t> toDraw_, boxNodes_;  // render queue; scratch of issue()
    bool asking_ = false;
};

/// Probability that a node that has been invisible in t tests stays so: 0.99 − 0.7 e^−t (CHC++, section 4.2).
double keepProbability(uint32_t invisibleFrames);
/// Length of the prefix of `keep` (descending probabilities of one multiquery's nodes) with the best value V = |M| / C of
/// benefit over cost, C = 1 + p_fail · |M|, p_fail = 1 − Π keep: grown greedily until V falls. ≥ 1 unless empty.
size_t multiqueryLength(std::span<const double> keep);
double multiqueryValue(std::span<const double> keep);  ///< V; `keep` is not empty

}  // namespace dapple::visibility
