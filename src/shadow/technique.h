#pragma once

#include "frame/frame.h"
#include "shadow/registry.h"
#include "visibility/occlusion_culler.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace dapple::shadow {

/// A light matrix in use, for the JSON beside a picture: anybody can check the picture with it.
struct LightMatrix {
    std::string name;
    glm::dmat4 clipFromRelative;  ///< from metres relative to the eye (or as `name` says) to the map's clip space
    /// What part of the view a map of the scene serves.
    struct Slice {
        int layer = 0;                    ///< of Technique::map()
        double from = 0, to = 0;          ///< metres of eye depth
        double depthStep = 0;             ///< metres along the light
        std::optional<glm::dvec2> texel;  ///< extent along u and v, metres; empty: warped
        glm::dvec3 u{0}, v{0};            ///< unit, across the light
        bool used = false;                ///< some caster can reach it
    };
    std::optional<Slice> slice = {};  ///< empty: a map of one object
};

/// How far maps in use are behind the sun and their objects: 0 where none is.
struct Staleness {
    double meanFrames = 0, worstFrames = 0;    ///< since a map last showed what it is used for
    double meanDegrees = 0, worstDegrees = 0;  ///< of the light's direction
};

/// One technique with its settings on one frame. In: the G-buffer, the scene on the GPU, the sun. Out: the
/// visibility image and its validity channel. Nothing else leaves it.
class Technique {
public:
    virtual ~Technique() = default;
    /// The passes between "depth" and "visibility", those that this scene does not need with their reason.
    /// The last one writes "visibility". They capture this object and the frame.
    virtual std::vector<frame::Pass> passes() = 0;
    /// Stated fallback in force ("lispsm → frustum: …"); empty when the technique runs as named.
    virtual std::string fallback() const { return {}; }
    virtual std::vector<LightMatrix> matrices() const { return {}; }
    /// The shadow map or the array of maps; nullptr where there is none.
    virtual const gl::Texture* map() const { return nullptr; }
    /// Texels of all its maps, and those of them that a look-up can reach now.
    virtual size_t texels() const { return map() ? size_t(map()->width()) * size_t(map()->height()) * size_t(std::max(map()->layers(), 1)) : 0; }
    virtual size_t texelsInUse() const { return texels(); }
    /// Most bytes that its maps may take, known before any of them is allocated. Nothing: it has no such bound.
    virtual std::optional<size_t> plannedMapBytes() const { return std::nullopt; }
    virtual size_t mapBytes() const { return map() ? map()->bytes() : 0; }
    /// Renders what is kept from frame to frame for the frame's present sun and scene, outside of any frame.
    virtual void refresh() {}
    /// How far what is kept was behind them in the frame last rendered; empty where nothing is kept.
    virtual std::optional<Staleness> staleness() const { return std::nullopt; }
    /// Casters that the last frame drew into the maps, in all of them together. Nothing: the technique draws no map of the scene.
    struct Casters {
        size_t instances = 0, triangles = 0;
    };
    virtual std::optional<Casters> castersDrawn() const { return std::nullopt; }
    /// Of the occlusion queries that the last frame asked, by pass; none where it asked none.
    virtual std::vector<std::pair<std::string, visibility::Statistics>> queryStatistics() const { return {}; }
    /// Submits once more the casters that the last frame drew into the map of matrices()[matrix], for pictures. False: see castersDrawn().
    virtual bool redrawCasters(size_t, const gpuscene::Submit&) { return false; }
    /// Where that map's window holds receivers in sight, 1 or 0, rows from the top; empty where nothing asks.
    virtual std::optional<base::ImageF> receiverMask(size_t) const { return std::nullopt; }
    /// Draws the additive fragment count of the technique's own screen-space work into frame.overdrawTarget().
    /// False: it has none.
    virtual bool countOverdraw() { return false; }
    /// Draws, over the frame last rendered, how many of the casters' volumes hold each pixel's receiver, if it faces the sun, into
    /// frame.overdrawTarget(): what is counted are the candidate pixels of Buntin & Stamminger 2007, fig. 4, before any
    /// look-up. False: this technique, with these settings, finds no candidates.
    virtual bool countCandidates() { return false; }
    /// Texels of texelsInUse() that the look-ups of the frame last rendered read, each once. Nothing: it does not tell.
    virtual std::optional<size_t> countTexelsReferenced() { return std::nullopt; }
};

/// Allocates the technique's maps. Throws base::Error(failed) when there is no memory for them.
std::unique_ptr<Technique> makeTechnique(frame::Frame& frame, const TechniqueInfo& info, const Settings& settings);

/// Half-width r of a filter's kernel in texels, so that it reads texel centres up to r + ½ from the receiver:
/// 0 nearest, ½ the hardware's 2×2, 1½ for 3×3 with bilinear weights, which has 4×4 texels.
double kernelRadius(const Settings& settings);
/// #define lines for lib/bias.glsl and lib/filter.glsl.
std::vector<std::string> samplingDefines(const Settings& settings);

}  // namespace dapple::shadow
