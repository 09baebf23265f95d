#include "gl/objects.h"

#include "base/error.h"
#include "gl/address_space.h"
#include "gl/context.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace dapple::gl {

void deleteBuffer(GLuint name) { if (!leaveObjects()) glDeleteBuffers(1, &name); }
void deleteTexture(GLuint name) { if (!leaveObjects()) glDeleteTextures(1, &name); }
void deleteFramebuffer(GLuint name) { if (!leaveObjects()) glDeleteFramebuffers(1, &name); }
void deleteVertexArray(GLuint name) { if (!leaveObjects()) glDeleteVertexArrays(1, &name); }
void deleteSampler(GLuint name) { if (!leaveObjects()) glDeleteSamplers(1, &name); }

VertexArray makeVertexArray() {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    return VertexArray(name);
}

Buffer::Buffer(size_t bytes, const void* data, bool dynamic) : bytes_(std::max<size_t>(bytes, 16)) {
    GLuint name = 0;
    glCreateBuffers(1, &name);
    handle_ = Handle<deleteBuffer>(name);
    // GL forbids empty buffers; sixteen bytes stand in for none.
    const void* initial = bytes >= 16 ? data : nullptr;
    glNamedBufferStorage(name, GLsizeiptr(bytes_), initial, GL_DYNAMIC_STORAGE_BIT * unsigned(dynamic || !initial));
    if (bytes > 0 && !initial && data) glNamedBufferSubData(name, 0, GLsizeiptr(bytes), data);
}

void Buffer::update(size_t bytes, const void* data) {
    if (bytes > bytes_ || !handle_) *this = Buffer(std::max(bytes, bytes_ * 2), nullptr, true);
    if (bytes > 0 && data) glNamedBufferSubData(handle_.name(), 0, GLsizeiptr(bytes), data);
}

size_t bytesPerTexel(GLenum format) {
    switch (format) {
        case GL_R8: case GL_R8UI: return 1;
        case GL_RG8: case GL_DEPTH_COMPONENT16: case GL_R16F: return 2;
        case GL_RGBA8: case GL_SRGB8_ALPHA8: case GL_R32F: case GL_RG16F: case GL_RG16: case GL_R32UI:
        case GL_DEPTH_COMPONENT24: case GL_DEPTH_COMPONENT32F: return 4;
        case GL_RGBA16: case GL_RGBA16F: case GL_RG32F: case GL_DEPTH32F_STENCIL8: return 8;
        case GL_RGBA32F: case GL_RGBA32UI: return 16;
        default: throw base::Error(base::ExitCode::failed, fmt::format("no texel size known for format 0x{:x}", format));
    }
}

Texture::Texture(GLenum internalFormat, int width, int height, int layers, int levels)
    : format_(internalFormat), width_(width), height_(height), layers_(layers), levels_(levels) {
    const GLenum target = layers > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    GLuint name = 0;
    glCreateTextures(target, 1, &name);
    handle_ = Handle<deleteTexture>(name);
    checkErrors("the work before a texture was made");
    if (layers > 0) glTextureStorage3D(name, levels, internalFormat, width, height, layers);
    else glTextureStorage2D(name, levels, internalFormat, width, height);
    checkErrors(fmt::format("a texture of {}×{}×{} texels, {} MiB", width, height, std::max(layers, 1), bytes() >> 20).c_str());
}

Texture Texture::view(int layer) const {
    Texture view;
    GLuint name = 0;
    glGenTextures(1, &name);  // a view must not have a target yet
    view.handle_ = Handle<deleteTexture>(name);
    view.format_ = format_, view.width_ = width_, view.height_ = height_, view.levels_ = levels_;
    glTextureView(name, GL_TEXTURE_2D, handle_.name(), format_, 0, GLuint(levels_), GLuint(layer), 1);
    checkErrors("a view of one layer");
    return view;
}

size_t Texture::bytes() const {
    size_t texels = 0;
    for (int level = 0; level < levels_; ++level) texels += size_t(std::max(width_ >> level, 1)) * size_t(std::max(height_ >> level, 1));
    return texels == 0 ? 0 : texels * size_t(std::max(layers_, 1)) * bytesPerTexel(format_);
}

Sampler makeSampler(const SamplerDesc& desc) {
    GLuint name = 0;
    glCreateSamplers(1, &name);
    const GLenum minify = desc.mipmaps ? GL_LINEAR_MIPMAP_LINEAR : desc.filter;
    glSamplerParameteri(name, GL_TEXTURE_MIN_FILTER, GLint(minify));
    glSamplerParameteri(name, GL_TEXTURE_MAG_FILTER, GLint(desc.filter));
    glSamplerParameteri(name, GL_TEXTURE_WRAP_S, GLint(desc.wrap));
    glSamplerParameteri(name, GL_TEXTURE_WRAP_T, GLint(desc.wrapT == GL_NONE ? desc.wrap : desc.wrapT));
    const std::array<float, 4> border{desc.border, desc.border, desc.border, desc.border};
    glSamplerParameterfv(name, GL_TEXTURE_BORDER_COLOR, border.data());
    if (desc.compare) {
        glSamplerParameteri(name, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glSamplerParameteri(name, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    }
    return Sampler(name);
}

Framebuffer makeFramebuffer(std::span<const Texture* const> colours, const Texture* depth, int depthLayer) {
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    Framebuffer framebuffer(name);
    std::array<GLenum, 8> buffers{};
    for (size_t i = 0; i < colours.size(); ++i) {
        buffers[i] = GLenum(GL_COLOR_ATTACHMENT0 + i);
        glNamedFramebufferTexture(name, buffers[i], colours[i]->name(), 0);
    }
    const GLenum point = depth && depth->format() == GL_DEPTH32F_STENCIL8 ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT;
    if (depth && depthLayer >= 0) glNamedFramebufferTextureLayer(name, point, depth->name(), 0, depthLayer);
    else if (depth) glNamedFramebufferTexture(name, point, depth->name(), 0);
    if (colours.empty()) glNamedFramebufferDrawBuffer(name, GL_NONE);
    else glNamedFramebufferDrawBuffers(name, GLsizei(colours.size()), buffers.data());
    const GLenum status = glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
        throw base::Error(base::ExitCode::failed, fmt::format("the driver refuses a framebuffer (0x{:x})", status));
    return framebuffer;
}

void finishTriangles() {
    const GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
    glWaitSync(fence, 0, GL_TIMEOUT_IGNORED);
    glDeleteSync(fence);
}

void resetState() {
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glUseProgram(0);
    glBindVertexArray(0);
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 0, ~0u);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    glDisable(GL_CULL_FACE);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_FRAMEBUFFER_SRGB);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glDepthFunc(GL_LESS);
    glDepthMask(GL_TRUE);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ZERO);
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
}

}  // namespace dapple::gl
