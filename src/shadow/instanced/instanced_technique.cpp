// Instanced shadow maps (Buntin & Stamminger 2007): per caster type, maps of the object rotated about the vertical in
// equal steps; per instance, the bounding shadow volume of its box says which pixels look one up.
#include "base/error.h"
#include "shadow/families.h"

#include "shadow/instanced/caster_list.h"
#include "shadow/instanced/far_field.h"
#include "shadow/instanced/resolution.h"
#include "shadow/instanced/volume.h"
#include "shadow/lit_start.h"
#include "shadow/volume/silhouette_volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace dapple::shadow {
namespace {

constexpr int kReceiverTile = 64;  ///< pixels, a multiple of 16; 16 spares at most 2.8 % more fragments (sweep mask-bound)
constexpr size_t kSurvivorBytes = 12;  ///< of lib/survivor.glsl
constexpr int kTile = 16;          ///< of instanced_tiled.comp

class InstancedTechnique final : public Technique {
public:
    InstancedTechnique(frame::Frame& frame, const Settings& settings)
        : frame_(frame), settings_(settings), maps_(frame, settings), casters_(frame, maps_),
          stencil_(is("accumulate", "stencil") || !is("exact-casters", "0")),
          spares_((is("cull", "receivers") || masked()) && is("exact-casters", "0")),
          start_(frame, stencil_ ? LitStart::Depth::withStencil : spares_ ? LitStart::Depth::tested : LitStart::Depth::readable,
                 spares_) {
        makePrograms();
        if (!is("exact-casters", "0"))
            exact_.emplace(frame, [this](const scenegen::Prototype& p) { return castsExactly(frame_.scene().scene(), p, settings_); },
                           SilhouetteVolumes::Count::stencil, true, start_.depth());
        planFarField();
        const gl::Texture* visibility[] = {&frame_.visibility()};
        volumeTarget_ = gl::makeFramebuffer(visibility, &testedDepth());
        refresh();
    }

    void refresh() override {
        if (maps_.types().empty()) return;
        measure::Ledger ignored;
        if (is("resolution", "estimate")) {
            // The first frame has sizes that were measured, too, and no others; this is not yet a frame and may wait.
            const int most = std::stoi(settings_.at("size"));
            chooser_.emplace(most);
            demand_.emplace(frame_, lookUpDefines(), most);
            frame::PassObserver silent;
            const std::vector<frame::Pass> gbuffer{frame_.gbufferPass()};
            frame::execute(gbuffer, silent);
            estimate(ignored);
            maps_.resize(chooser_->update(*demand_->result(true)));
        }
        if (is("update", "regenerate")) return;  // every frame does
        gl::resetState();
        maps_.renderAll(ignored);
        gl::resetState();
    }

    std::vector<frame::Pass> passes() override {
        using measure::Ledger;
        choose();
        planFarField();
        std::string mapsLeftOut, leftOut, farLeftOut;
        const bool exact = exact_ && !exact_->empty();
        if (maps_.types().empty()) mapsLeftOut = leftOut = withoutMaps(exact);
        else if (!maps_.outdated() && !chooser_) mapsLeftOut = "cached: neither the sun nor a caster's shape has changed";
        std::vector<frame::Pass> passes;
        if (far_) {
            casters_.collect(&*far_);
            if (!far_->any()) farLeftOut = !leftOut.empty() ? leftOut : is("far-field", "auto") || is("far-field", "each") ? "every caster is cheaper as a volume" : "no caster is so far";
            splits_ = farLeftOut.empty();
            passes.push_back({"far", {}, {}, "which casters are drawn into maps instead of having volumes", farLeftOut, [this](Ledger&) { casters_.collect(&*far_); }});
        }
        if (std::ranges::none_of(maps_.types(), &CasterType::ring) && !is("rotations", "1"))
            passes.push_back({"maps.rotated", {}, {}, "maps of rotated casters, in equal steps",
                              maps_.maps().size() == maps_.types().size() ? "no caster is rotated against another of its type: one map per type serves"
                                                                          : "the casters of a type have few yaws: a map for each is exact", {}});
        if (chooser_)
            passes.push_back({"estimate", {"gbuffer", "depth"}, {"demand"}, "texels that each map is asked for", leftOut, [this](Ledger& tally) { estimate(tally); }});
        passes.push_back({"maps", {}, {"maps"}, fmt::format("{} maps of {} caster types", maps_.maps().size(), maps_.types().size()), mapsLeftOut,
                          [this](Ledger& tally) {
                              if (maps_.plan().byView) followSun();
                              const auto demands = chooser_ ? demand_->result() : std::nullopt;
                              if (demands && demands->size() == maps_.maps().size()) maps_.resize(chooser_->update(*demands));
                              maps_.render(casters_.uses(), tally);
                          }});
        if (is("apply", "tiled") && leftOut.empty()) {
            passes.push_back({"tiles", {"gbuffer", "depth", "maps"}, {"visibility"}, "each tile of the screen finds its casters, each pixel asks them", "",
                              [this](Ledger& tally) { resolveTiles(tally); }});
        } else if (is("apply", "all") && leftOut.empty()) {
            passes.push_back({"all", {"gbuffer", "depth", "maps"}, {"visibility"}, "each pixel asks every caster", "", [this](Ledger& tally) { resolveAll(tally); }});
        } else {
            passes.push_back({"begin", {"gbuffer", "depth"}, {"visibility", "depth-copy"}, "lit where the surface faces the sun; depth to read", "",
                              [this](Ledger& tally) { start_.record(tally); }});
            if (far_)
                for (frame::Pass& pass : far_->technique().passes()) {
                    pass.name = "far." + pass.name;
                    if (!farLeftOut.empty()) pass.leftOut = farLeftOut;
                    passes.push_back(std::move(pass));
                }
            if (exact_) {
                const std::string none = exact ? "" : "no caster is closed and has so few triangles";
                passes.push_back({"exact.count", {"depth-copy"}, {"count"}, "shadow volumes of the exact casters that begin and end behind each pixel", none,
                                  [this](Ledger& tally) { exact_->count(tally); }});
                passes.push_back({"exact.dark", {"visibility", "count"}, {"visibility"}, "dark where one of them holds the pixel", none,
                                  [this](Ledger& tally) { exact_->darken(tally); }});
            }
            if (exact_ && is("cull", "receivers"))
                passes.push_back({"begin.receivers", {}, {}, "no fragments where no light can arrive", "exact casters are counted against the depth of every pixel", {}});
            if (masked())
                passes.push_back({"mask", {"gbuffer", "depth"}, {"survivors"}, "which instances' shadow volumes meet a visible receiver", leftOut,
                                  [this](Ledger& tally) { mask(tally); }});
            passes.push_back({"volumes", {"visibility", "depth-copy"}, {"visibility"}, "look-ups inside each instance's bounding shadow volume", leftOut,
                              [this](Ledger& tally) { renderVolumes(tally); }});
        }
        return passes;
    }

    std::string fallback() const override { return maps_.plan().note; }
    std::optional<size_t> plannedMapBytes() const override { return maps_.plannedBytes(); }

    std::vector<LightMatrix> matrices() const override {
        std::vector<LightMatrix> all = maps_.matrices();
        if (splits_)
            for (const LightMatrix& m : far_->technique().matrices()) all.push_back({"far." + m.name, m.clipFromRelative});
        return all;
    }
    std::optional<Staleness> staleness() const override { return maps_.staleness(casters_.mapsInUse()); }
    const gl::Texture* map() const override { return maps_.types().empty() ? nullptr : &maps_.atlas().texture(); }

    size_t texels() const override { return Technique::texels() + (far_ ? far_->technique().texels() : 0); }
    size_t texelsInUse() const override { return maps_.atlas().texelsInUse() + (splits_ ? far_->technique().texelsInUse() : 0); }
    size_t mapBytes() const override { return Technique::mapBytes() + (far_ ? far_->technique().mapBytes() : 0); }

    bool countOverdraw() override { return countVolumes(count_, &testedDepth()); }
    // Each volume is convex, so without a depth test it has one fragment per pixel, and membership alone decides.
    bool countCandidates() override { return countVolumes(candidates_, nullptr); }

    std::optional<size_t> countTexelsReferenced() override {
        const gl::Texture* atlas = map();
        if (!atlas) return 0;
        const gl::Texture marks(GL_R8UI, atlas->width(), atlas->height(), atlas->layers());
        const GLuint none = 0;
        glClearTexImage(marks.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
        glBindImageTexture(0, marks.name(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
        std::vector<std::string> defines = volumeDefines();
        defines.push_back("MARK_TEXELS");
        if (!countVolumes(gl::Program("shadow/instanced.vert", "shadow/instanced.frag", defines), &frame_.depth())) return std::nullopt;
        glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        std::vector<uint8_t> texels(size_t(marks.width()) * size_t(marks.height()) * size_t(marks.layers()));
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glGetTextureImage(marks.name(), 0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, GLsizei(texels.size()), texels.data());
        return size_t(std::ranges::count(texels, uint8_t(1)));
    }

private:
    bool is(const char* axisName, const char* value) const { return settings_.at(axisName) == value; }
    bool masked() const { return is("cull", "mask"); }
    /// What the volumes are tested against; they read the other of the two depths.
    const gl::Texture& testedDepth() const { return stencil_ || spares_ ? start_.depth() : frame_.depth(); }
    /// The casters that have volumes; with a far field the frame's first pass has chosen them.
    void collect() {
        if (splits_) casters_.update();
        else casters_.collect();
    }
    /// Casters, first in the list, whose front faces do.
    size_t notAboutEye() const { return is("apply", "zpass") ? casters_.notAboutEye() : 0; }

    /// Returns whether the maps are others.
    bool choose() {
        const bool others = maps_.choose();
        if (others) casters_.clear();
        if (others && chooser_) chooser_.emplace(std::stoi(settings_.at("size")));  // of the maps that were
        return others;
    }
    std::string withoutMaps(bool exact) const {
        if (std::ranges::any_of(maps_.plan().cascaded, std::identity())) return "every caster in reach is the far field's";
        if (exact) return "every caster casts exactly";
        return maps_.plan().byView ? "no caster's shadow reaches this view" : "the scene has no caster";
    }
    /// It has the casters that axis `far-field` gives it, and those that the maps' plan does.
    void planFarField() {
        if (!far_ && (!is("far-field", "none") || std::ranges::any_of(maps_.plan().cascaded, std::identity()))) far_.emplace(frame_, maps_, settings_);
    }
    /// A sun or casters that have moved since the passes were planned may bring casters into reach that have no map yet.
    void followSun() {
        if (!choose()) return;
        if (!splits_ && std::ranges::any_of(maps_.plan().cascaded, std::identity()))
            throw base::Error(base::ExitCode::failed, "casters have come into reach whose maps do not fit axis memory, in the middle of a motion: more memory");
        casters_.collect(splits_ ? &*far_ : nullptr);
    }

    bool countVolumes(const gl::Program& program, const gl::Texture* depth) {
        if (is("apply", "tiled") || is("apply", "all")) return false;
        const gl::Texture* colours[] = {&frame_.overdraw()};
        const gl::Framebuffer target = gl::makeFramebuffer(colours, depth);
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, target.name());
        const float zero[4] = {0, 0, 0, 0};
        glClearBufferfv(GL_COLOR, 0, zero);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        measure::Ledger ignored;
        if (exact_ && &program == &count_) exact_->addOverdraw();  // first: without the depth test of the others
        if (!maps_.types().empty()) submitVolumes(program, ignored);
        gl::resetState();
        return true;
    }

    std::vector<std::string> lookUpDefines() const {
        std::vector<std::string> look = samplingDefines(settings_);
        look.push_back(fmt::format("MODE {}", is("mode", "blend") ? 1 : is("mode", "depth") ? 2 : 0));
        look.push_back(fmt::format("SAMPLE_FRAME {}", is("sample-frame", "A") ? 0 : is("sample-frame", "B") ? 1 : is("sample-frame", "E") ? 2 : 3));
        return look;
    }

    std::vector<std::string> volumeDefines() const {
        std::vector<std::string> volume = lookUpDefines();
        if (is("apply", "skip")) volume.push_back("SKIP_TEST");
        if (masked()) volume.push_back("MASKED");
        if (frame_.scene().facts().translucent) volume.push_back("TRANSLUCENT");
        return volume;
    }

    void makePrograms() {
        const std::vector<std::string> look = lookUpDefines(), volume = volumeDefines();
        if (is("apply", "tiled")) {
            resolve_ = gl::Program::compute("shadow/instanced_tiled.comp", look);
        } else if (is("apply", "all")) {
            resolve_ = gl::Program("passes/fullscreen.vert", "shadow/instanced_all.frag", look);
        } else {
            resolve_ = gl::Program("shadow/instanced.vert", "shadow/instanced.frag", volume);
            count_ = gl::Program("shadow/instanced.vert", "passes/count.frag", volume);
            std::vector<std::string> candidates = volume;
            std::erase(candidates, "SKIP_TEST");
            candidates.push_back("COUNT_CANDIDATES");
            candidates_ = gl::Program("shadow/instanced.vert", "shadow/instanced.frag", candidates);
        }
        if (masked()) {
            receiverTiles_ = gl::Program::compute("shadow/receiver_tiles.comp", {fmt::format("TILE {}", kReceiverTile)});
            mask_ = gl::Program::compute("shadow/instanced_mask.comp");
        }
        corners_ = gl::Buffer::of<uint32_t>(boxShadowVolume());
        array_ = gl::makeVertexArray();
        glVertexArrayElementBuffer(array_.name(), corners_.name());
        const bool linear = !is("filter", "nearest");
        sampler_ = gl::makeSampler({GLenum(linear ? GL_LINEAR : GL_NEAREST), false, GL_CLAMP_TO_BORDER, !is("mode", "depth")});
    }

    /// Everything that a look-up reads.
    void bind(const gl::Program& program) {
        frame_.setView(program);
        const double heading = sunAngles(frame_.light()).heading;
        program.set("uHeading", glm::vec2(std::cos(heading), std::sin(heading)));
        program.set("uBiasScale", std::stof(settings_.at("bias-scale")));
        program.set("uCasters", int(casters_.size()));
        frame_.bindGeometry();
        glBindTextureUnit(3, maps_.atlas().texture().name());
        glBindSampler(3, sampler_.name());
        casters_.bind();
        program.use();
    }

    void estimate(measure::Ledger& tally) {
        gl::finishTriangles();
        collect();
        demand_->record(maps_.maps().size(), [this](const gl::Program& program) {
            program.set("uPadTexels", float(maps_.padTexels()));
            bind(program);
        }, tally);
    }

    void resolveTiles(measure::Ledger& tally) {
        gl::finishTriangles();
        const auto& camera = frame_.camera();
        casters_.collect();
        bind(resolve_);
        glBindImageTexture(0, frame_.visibility().name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG16F);
        glDispatchCompute(GLuint(camera.width + kTile - 1) / kTile, GLuint(camera.height + kTile - 1) / kTile, 1);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
        ++tally.drawCalls;
    }

    void resolveAll(measure::Ledger& tally) {
        casters_.collect();
        glBindFramebuffer(GL_FRAMEBUFFER, volumeTarget_.name());
        glViewport(0, 0, frame_.camera().width, frame_.camera().height);
        bind(resolve_);
        frame_.drawFullscreen();
        ++tally.drawCalls;
    }

    void mask(measure::Ledger& tally) {
        gl::finishTriangles();
        const auto& camera = frame_.camera();
        collect();
        const auto across = GLuint(camera.width + kReceiverTile - 1) / kReceiverTile, down = GLuint(camera.height + kReceiverTile - 1) / kReceiverTile;
        const GLuint commands[10] = {72, 0, 0, 0, 0, 72, 0, 0, 0, 0};
        commands_.update(sizeof commands, commands);
        tiles_.update(size_t(across) * down * 2 * sizeof(glm::vec4), nullptr);
        survivors_.update(2 * casters_.size() * kSurvivorBytes, nullptr);
        bind(receiverTiles_);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, survivors_.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, tiles_.name());
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, commands_.name());
        glDispatchCompute(across, down, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
        frame_.setView(mask_);
        mask_.set("uCasters", int(casters_.size()));
        mask_.set("uTiles", int(across * down));
        mask_.set("uNotAboutEye", int(notAboutEye()));
        mask_.use();
        glDispatchCompute(GLuint(casters_.size() + 63) / 64, 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
        tally.drawCalls += 2;
    }

    void renderVolumes(measure::Ledger& tally) {
        glBindFramebuffer(GL_FRAMEBUFFER, volumeTarget_.name());
        glColorMask(GL_TRUE, GL_FALSE, GL_FALSE, GL_FALSE);  // validity stays
        if (is("accumulate", "stencil")) {
            // The first caster that darkens a pixel marks it; later fragments die before they look anything up.
            glEnable(GL_STENCIL_TEST);
            glStencilFunc(GL_NOTEQUAL, 1, 0xFF);
            glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
        } else {
            glEnable(GL_BLEND);
            glBlendEquation(is("accumulate", "min") ? GL_MIN : GL_FUNC_ADD);
            glBlendFunc(GL_ZERO, GL_SRC_COLOR);
        }
        submitVolumes(resolve_, tally);
    }

    void submitVolumes(const gl::Program& program, measure::Ledger& tally) {
        if (!masked()) collect();  // else the mask has, and its survivors index that list
        glViewport(0, 0, frame_.camera().width, frame_.camera().height);
        glEnable(GL_DEPTH_TEST);
        glDepthMask(GL_FALSE);
        glEnable(GL_DEPTH_CLAMP);
        glEnable(GL_CULL_FACE);
        program.set("uExtrusion", float(casters_.extrusion().most));
        program.set("uFloor", float(casters_.extrusion().floor));
        if (masked()) {
            glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, survivors_.name());
            glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
        }
        const auto draw = [&](bool zPass, size_t first, size_t count) {
            if (count == 0) return;
            start_.setUnlit(zPass ? 1.0f : 0.0f, tally);
            bind(program);
            if (&testedDepth() == &frame_.depth()) glBindTextureUnit(2, start_.depth().name());
            glBindVertexArray(array_.name());
            // z-fail: back faces that lie behind the scene (smaller depth, as z is reversed), whatever side the eye is on;
            // z-pass: front faces before it.
            glDepthFunc(zPass ? GL_GREATER : GL_LESS);
            glCullFace(zPass ? GL_BACK : GL_FRONT);
            // Those about the eye that survive stand in the second half of the list, and have a command of their own.
            program.set("uFirstCaster", int(masked() && !zPass ? casters_.size() : first));
            if (masked()) glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, reinterpret_cast<const void*>(size_t(zPass ? 0 : 20)));
            else glDrawElementsInstanced(GL_TRIANGLES, 72, GL_UNSIGNED_INT, nullptr, GLsizei(count));
            ++tally.drawCalls;
            GLuint instances = GLuint(count);
            if (masked() && tally.counters) {
                glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
                glGetNamedBufferSubData(commands_.name(), zPass ? 4 : 24, sizeof instances, &instances);
            }
            tally.trianglesSubmitted += 24 * instances;
        };
        draw(true, 0, notAboutEye());
        draw(false, notAboutEye(), casters_.size() - notAboutEye());
    }

    frame::Frame& frame_;
    Settings settings_;
    CasterMaps maps_;
    CasterList casters_;
    std::optional<SizeChooser> chooser_;      ///< with `resolution` estimate
    std::optional<DemandEstimate> demand_;
    std::optional<FarField> far_;             ///< with `far-field`
    bool splits_ = false;                     ///< some casters are far, as planned
    bool stencil_;  ///< volumes are tested against a copy of the depth that has a stencil
    bool spares_;   ///< volumes have no fragments at the sky and at surfaces that face away from the sun: the copy's depth there fails their test
    LitStart start_;
    std::optional<SilhouetteVolumes> exact_;  ///< with `exact-casters`
    gl::Framebuffer volumeTarget_;
    gl::Sampler sampler_;
    gl::VertexArray array_;
    gl::Buffer corners_, survivors_, tiles_, commands_;
    gl::Program resolve_, count_, candidates_, receiverTiles_, mask_;
};

}  // namespace

std::unique_ptr<Technique> makeInstanced(frame::Frame& frame, const Settings& settings) {
    return std::make_unique<InstancedTechnique>(frame, settings);
}

}  // namespace dapple::shadow
