#include "frame/frame.h"

#include <algorithm>
#include <cmath>

namespace dapple::frame {
namespace {

using gpuscene::Attributes;
using gpuscene::Bucket;

/// unpackNormal() of lib/gbuffer.glsl.
glm::dvec3 unpackNormal(uint32_t packed) {
    const auto component = [&](int shift) { return double(int32_t(packed << (22 - shift)) >> 22); };
    return glm::normalize(glm::dvec3(component(0), component(10), component(20)));
}

/// Light of the sky: whole while the sun is up, a twentieth from nautical dusk (12 degrees below the horizon) on.
float daylight(double elevation) { return float(std::clamp(1 + elevation / 12, 0.05, 1.0)); }

}  // namespace

std::string ofSun(const std::string& name, size_t sun) { return sun == 0 ? name : name + "." + std::to_string(sun + 1); }

/// Variants of one geometry shader: an untextured scene gets no texture coordinates, a scene without alpha no
/// alpha test.
struct Frame::Programs {
    gl::Program opaque, alpha;
    Attributes opaqueAttributes = Attributes::positionNormal;

    Programs(const gpuscene::GpuScene& scene, const std::string& fragment, std::vector<std::string> defines = {}) {
        if (scene.has(Bucket::opaque)) {
            std::vector<std::string> all = defines;
            if (scene.hasOpaqueTextures()) all.push_back("TEXTURED"), opaqueAttributes = Attributes::all;
            opaque = gl::Program("passes/gbuffer.vert", fragment, all);
        }
        defines.insert(defines.end(), {"TEXTURED", "ALPHA_TEST"});
        if (scene.has(Bucket::alphaTested)) alpha = gl::Program("passes/gbuffer.vert", fragment, defines);
    }
};

Frame::Frame(const gpuscene::GpuScene& scene, const scenegen::View& view, int width, int height)
    : scene_(&scene), camera_(view, width, height),
      surface_(GL_RGBA32UI, width, height), depth_(GL_DEPTH_COMPONENT32F, width, height),
      shaded_(GL_SRGB8_ALPHA8, width, height), noAttributes_(gl::makeVertexArray()),
      nearest_(gl::makeSampler({})) {
    const gl::Texture* geometry[] = {&surface_};
    const gl::Texture* shaded[] = {&shaded_};
    gbufferTarget_ = gl::makeFramebuffer(geometry, &depth_);
    shadedTarget_ = gl::makeFramebuffer(shaded, nullptr);
    bareTarget_ = gl::makeFramebuffer(shaded, &depth_);
    std::vector<scenegen::Sun> suns{scene.scene().sun};
    suns.insert(suns.end(), scene.scene().furtherSuns.begin(), scene.scene().furtherSuns.end());
    for (const scenegen::Sun& sun : suns) {
        SunLight& s = suns_.emplace_back(SunLight{sun, sun.direction(), gl::Texture(GL_RG16F, width, height), {}});
        const gl::Texture* visibility[] = {&s.visibility};
        s.target = gl::makeFramebuffer(visibility, nullptr);
    }
}

base::DBox Frame::relative(const base::Box& box) const {
    return box.empty() ? base::DBox{} : base::DBox{glm::dvec3(box.lo) - camera_.eye, glm::dvec3(box.hi) - camera_.eye};
}

void Frame::setView(const gl::Program& program) const {
    program.set("uRight", glm::vec4(camera_.right * camera_.tanX, camera_.near));
    program.set("uUp", glm::vec4(camera_.up * camera_.tanY, camera_.far));
    program.set("uForward", glm::vec4(camera_.forward, 0));
    program.set("uPixel", glm::vec2(1.0 / camera_.width, 1.0 / camera_.height));
    program.set("uClipFromRelative", glm::mat4(camera_.clipFromRelative));
    program.set("uLight", glm::vec3(light()));
    program.set("uDaylight", daylight(suns_[0].sun.elevation));
}

std::string Frame::sunsDefine() const { return "SUNS " + std::to_string(suns_.size()); }

void Frame::setSuns(const gl::Program& program) const {
    std::vector<glm::vec4> suns;
    for (const SunLight& s : suns_) suns.emplace_back(s.light, s.sun.strength);
    program.set("uSuns[0]", std::span<const glm::vec4>(suns));
}

void Frame::bindGeometry() const {
    glBindTextureUnit(1, surface_.name());
    glBindTextureUnit(2, depth_.name());
    for (const GLuint unit : {1u, 2u}) glBindSampler(unit, nearest_.name());
}

void Frame::drawFullscreen() const {
    glBindVertexArray(noAttributes_.name());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void Frame::setGeometryState() const {
    glViewport(0, 0, camera_.width, camera_.height);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
}

void Frame::setView(const Programs& programs) const {
    for (const gl::Program* program : {&programs.opaque, &programs.alpha})
        if (program->name()) setView(*program), setSuns(*program);
}

void Frame::collectInView() {
    std::vector<uint32_t> inView;
    scene_->hierarchy(gpuscene::Items::kLeafTriangles, false).selectItems([this](const base::Box& box) { return camera_.mayContain(relative(box)); }, inView);
    scene_->items().collect(camera_.eye, inView, visible_);
}

void Frame::drawGeometry(const gpuscene::DrawList& list, const Programs& programs, measure::Ledger& tally, gpuscene::Faces faces) {
    setGeometryState();
    const auto draw = [&](const gl::Program& program, Bucket bucket, Attributes attributes) {
        if (!program.name()) return;
        program.use();
        const gpuscene::DrawCount count = scene_->draw(list, bucket, attributes, program.name(), faces, tally.counters != nullptr);
        tally.drawCalls += count.draws;
        tally.trianglesSubmitted += count.triangles;
    };
    draw(programs.opaque, Bucket::opaque, programs.opaqueAttributes);
    draw(programs.alpha, Bucket::alphaTested, Attributes::all);
}

Pass Frame::gbufferPass(Culling culling, bool asksOcclusion) {
    if (!gbuffer_) gbuffer_ = std::make_shared<Programs>(*scene_, "passes/gbuffer.frag");
    if (!culling)
        culling = [this](const gpuscene::Submit& submit) {
            collectInView();
            submit(visible_);
        };
    return {"gbuffer", {}, {"gbuffer", "depth"}, "colour, normals and depth of what the view sees", "", [this, culling](measure::Ledger& tally) {
                const float zero[4] = {0, 0, 0, 0};
                glBindFramebuffer(GL_FRAMEBUFFER, gbufferTarget_.name());
                // Colour needs no clearing: pixels that no triangle covers are sky by their depth.
                glClearBufferfv(GL_DEPTH, 0, zero);
                setGeometryState();
                setView(*gbuffer_);  // once, however often the culling draws
                drawn_.clear();
                culling([&](const gpuscene::DrawList& list) {
                    drawGeometry(list, *gbuffer_, tally);
                    drawn_.insert(drawn_.end(), list.items.begin(), list.items.end());
                });
            }, asksOcclusion};
}

Pass Frame::barePass() {
    if (!bare_) bare_ = std::make_shared<Programs>(*scene_, "passes/bare.frag", std::vector{sunsDefine()});
    return {"bare", {}, {"shaded"}, "every instance, nothing culled", "", [this](measure::Ledger& tally) {
                // The loop has no visibility of its own, so its instances are listed and uploaded once.
                if (everything_.data.empty()) scene_->collect(camera_.eye, [](uint32_t) { return true; }, everything_);
                const float zero[4] = {0, 0, 0, 0};
                glBindFramebuffer(GL_FRAMEBUFFER, bareTarget_.name());
                glEnable(GL_FRAMEBUFFER_SRGB);
                glClearBufferfv(GL_COLOR, 0, zero);
                glClearBufferfv(GL_DEPTH, 0, zero);
                setView(*bare_);
                drawGeometry(everything_, *bare_, tally, gpuscene::Faces::both);
            }};
}

Pass Frame::shadePass(bool shadowed) {
    gl::Program& program = shadowed ? shade_ : shadeUnshadowed_;
    if (!program.name())
        program = gl::Program("passes/fullscreen.vert", "passes/shade.frag", shadowed ? std::vector<std::string>{sunsDefine(), "SHADOWED"} : std::vector<std::string>{sunsDefine()});
    std::vector<std::string> reads{"gbuffer", "depth"};
    for (size_t i = 0; shadowed && i < suns_.size(); ++i) reads.push_back(ofSun("visibility", i));
    return {"shade", reads, {"shaded"}, "ambient, diffuse and specular light; shadow dims the second and removes the third", "",
            [this, &program, shadowed](measure::Ledger& tally) {
                glBindFramebuffer(GL_FRAMEBUFFER, shadedTarget_.name());
                glViewport(0, 0, camera_.width, camera_.height);
                glEnable(GL_FRAMEBUFFER_SRGB);
                setView(program);
                setSuns(program);
                program.use();
                bindGeometry();
                for (size_t i = 0; shadowed && i < suns_.size(); ++i) {
                    glBindTextureUnit(GLuint(3 + i), suns_[i].visibility.name());
                    glBindSampler(GLuint(3 + i), nearest_.name());
                }
                drawFullscreen();
                ++tally.drawCalls;
            }};
}

const gl::Texture& Frame::overdraw() {
    overdrawTarget();
    return overdraw_;
}

gl::Framebuffer& Frame::overdrawTarget() {
    if (!overdrawTarget_) {
        overdraw_ = gl::Texture(GL_R32F, camera_.width, camera_.height);
        const gl::Texture* colours[] = {&overdraw_};
        overdrawTarget_ = gl::makeFramebuffer(colours, nullptr);
        countTarget_ = gl::makeFramebuffer(colours, &depth_);
    }
    return overdrawTarget_;
}

void Frame::countGeometry() {
    overdrawTarget();
    if (!count_) count_ = std::make_shared<Programs>(*scene_, "passes/count.frag");
    collectInView();
    const float zero[4] = {0, 0, 0, 0};
    gl::resetState();
    glBindFramebuffer(GL_FRAMEBUFFER, countTarget_.name());
    glClearBufferfv(GL_COLOR, 0, zero);
    glClearBufferfv(GL_DEPTH, 0, zero);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    measure::Ledger ignored;
    setView(*count_);
    drawGeometry(visible_, *count_, ignored);
    gl::resetState();
}

base::ImageF Frame::readChannel(const gl::Texture& texture, int layer) const {
    const bool isDepth = texture.format() == GL_DEPTH_COMPONENT32F || texture.format() == GL_DEPTH32F_STENCIL8;
    base::ImageF image{texture.width(), texture.height(), 1, std::vector<float>(size_t(texture.width()) * size_t(texture.height()))};
    std::vector<float> rows(image.texels.size());
    glGetTextureSubImage(texture.name(), 0, 0, 0, layer, texture.width(), texture.height(), 1, isDepth ? GL_DEPTH_COMPONENT : GL_RED,
                         GL_FLOAT, GLsizei(rows.size() * sizeof(float)), rows.data());
    const auto width = size_t(image.width), height = size_t(image.height);
    for (size_t y = 0; y < height; ++y) std::copy_n(&rows[(height - 1 - y) * width], width, &image.texels[y * width]);
    return image;
}

truth::Receivers Frame::readReceivers() const {
    const auto w = size_t(camera_.width), h = size_t(camera_.height);
    truth::Receivers receivers{camera_.width, camera_.height, std::vector<glm::vec3>(w * h), std::vector<glm::vec3>(w * h),
                               std::vector<uint8_t>(w * h)};
    const base::ImageF depth = readChannel(depth_);
    std::vector<glm::uvec4> surface(w * h);
    glGetTextureImage(surface_.name(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, GLsizei(surface.size() * sizeof(glm::uvec4)), surface.data());
    for (size_t row = 0; row < h; ++row)
        for (size_t x = 0; x < w; ++x) {
            const size_t i = row * w + x, glRow = h - 1 - row;
            if (depth.texels[i] == 0) continue;
            receivers.present[i] = 1;
            receivers.position[i] = glm::vec3(camera_.relativePoint(int(x), int(glRow), depth.texels[i]));
            receivers.normal[i] = glm::vec3(unpackNormal(surface[glRow * w + x].z));
        }
    return receivers;
}

std::vector<float> Frame::readVisibility() const { return readChannel(visibility()).texels; }

std::vector<uint8_t> Frame::readValidity() const {
    const auto w = size_t(camera_.width), h = size_t(camera_.height);
    std::vector<float> pairs(w * h * 2);
    glGetTextureImage(visibility().name(), 0, GL_RG, GL_FLOAT, GLsizei(pairs.size() * sizeof(float)), pairs.data());
    std::vector<uint8_t> valid(w * h);
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) valid[y * w + x] = pairs[((h - 1 - y) * w + x) * 2 + 1] > 0.5f;
    return valid;
}

base::Image8 Frame::readShaded() const {
    const auto w = size_t(camera_.width), h = size_t(camera_.height);
    std::vector<uint8_t> rows(w * h * 4);
    glGetTextureImage(shaded_.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(rows.size()), rows.data());
    base::Image8 image{camera_.width, camera_.height, 3, std::vector<uint8_t>(w * h * 3)};
    for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x) std::copy_n(&rows[((h - 1 - y) * w + x) * 4], 3, image.at(int(x), int(y)));
    return image;
}

}  // namespace dapple::frame
