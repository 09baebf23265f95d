#pragma once

#include "shadow/technique.h"

/// What the families share, and their makers. A new family adds its maker here and in technique.cpp.
namespace dapple::shadow {

/// `casts`: which instances the maps show, by index, asked in every frame; all that cast unless given. Such maps are culled by
/// the CPU (cull none or frustum).
std::unique_ptr<Technique> makeMap(frame::Frame& frame, const Settings& settings, const std::function<bool(uint32_t)>& casts = {});
std::unique_ptr<Technique> makeInstanced(frame::Frame& frame, const Settings& settings);
/// Throws UsageError when a casting prototype is not closed.
std::unique_ptr<Technique> makeVolume(frame::Frame& frame, const Settings& settings);

/// Draws a list's casters, opaque then alpha-tested, with the light's matrix. `alpha` may be empty where the
/// scene has no alpha-tested mesh, `opaque` where it has nothing else.
void drawCasters(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const glm::dmat4& lightClip,
                 const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally);
/// The same in two steps, for lists that come one after the other: the matrix is set once.
void setCasterClip(const glm::dmat4& lightClip, const gl::Program& opaque, const gl::Program& alpha);
void drawCasters(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally);

/// In a frame that counts: adds the fragments of a list that has been drawn into a map, by drawing it again into the same target with
/// the same programs. Leaves the map as it is.
void countMapFragments(const gpuscene::GpuScene& scene, const gpuscene::DrawList& list, const gl::Program& opaque, const gl::Program& alpha, measure::Ledger& tally);
/// In a frame that counts: adds the texels of a finished map that hold a caster. The map is a square of a layer.
void countMapTexels(const gl::Texture& map, int layer, int x, int y, int side, measure::Ledger& tally);

}  // namespace dapple::shadow
