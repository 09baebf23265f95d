#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <span>
#include <utility>

namespace dapple::gl {

/// Owner of one GL object name. Move-only; the destructor deletes.
template <void (*Delete)(GLuint)>
class Handle {
public:
    Handle() = default;
    explicit Handle(GLuint name) : name_(name) {}
    Handle(Handle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    ~Handle() {
        if (name_) Delete(name_);
    }
    GLuint name() const { return name_; }
    explicit operator bool() const { return name_ != 0; }

private:
    GLuint name_ = 0;
};

void deleteBuffer(GLuint name);
void deleteTexture(GLuint name);
void deleteFramebuffer(GLuint name);
void deleteVertexArray(GLuint name);
void deleteSampler(GLuint name);

using VertexArray = Handle<deleteVertexArray>;
VertexArray makeVertexArray();

/// Immutable or dynamic storage of bytes on the GPU.
class Buffer {
public:
    Buffer() = default;
    /// `bytes` of storage, filled from `data` if not null. `dynamic`: contents may be replaced by update().
    Buffer(size_t bytes, const void* data, bool dynamic = false);
    template <class T>
    static Buffer of(std::span<const T> items) { return Buffer(items.size_bytes(), items.data()); }
    /// Replaces the first `bytes` (data null: leaves them undefined); grows the storage (new name) when it is too small.
    void update(size_t bytes, const void* data);
    GLuint name() const { return handle_.name(); }
    explicit operator bool() const { return bool(handle_); }
    size_t bytes() const { return bytes_; }

private:
    Handle<deleteBuffer> handle_;
    size_t bytes_ = 0;
};

/// A 2D texture or 2D array (layers > 0) with immutable storage.
class Texture {
public:
    Texture() = default;
    /// Throws base::Error(failed) when the driver has no memory for it.
    Texture(GLenum internalFormat, int width, int height, int layers = 0, int levels = 1);
    /// One layer of an array, as a 2D texture that shares its texels; they live as long as either.
    Texture view(int layer) const;
    GLuint name() const { return handle_.name(); }
    int width() const { return width_; }
    int height() const { return height_; }
    int layers() const { return layers_; }
    GLenum format() const { return format_; }
    /// Format × extent × layers × levels.
    size_t bytes() const;

private:
    Handle<deleteTexture> handle_;
    GLenum format_ = 0;
    int width_ = 0, height_ = 0, layers_ = 0, levels_ = 0;
};

using Sampler = Handle<deleteSampler>;
struct SamplerDesc {
    GLenum filter = GL_NEAREST;      ///< GL_NEAREST or GL_LINEAR, for magnification and minification
    bool mipmaps = false;
    GLenum wrap = GL_CLAMP_TO_EDGE;  ///< along s
    bool compare = false;            ///< GL_LEQUAL against the reference
    float border = 1;                ///< with GL_CLAMP_TO_BORDER: 1 = the map's far plane, hence lit
    GLenum wrapT = GL_NONE;          ///< along t; GL_NONE: as along s
};
Sampler makeSampler(const SamplerDesc& desc);

using Framebuffer = Handle<deleteFramebuffer>;
/// Complete framebuffer. `depthLayer` ≥ 0 attaches that layer of an array. Throws base::Error(failed) otherwise.
Framebuffer makeFramebuffer(std::span<const Texture* const> colours, const Texture* depth, int depthLayer = -1);

size_t bytesPerTexel(GLenum internalFormat);

/// Before a compute shader reads what triangles have drawn. GL orders the two by itself, and a server that does has nothing to
/// wait for; llvmpipe (Mesa 22.3) starts the shader while its threads still rasterise.
void finishTriangles();

/// The GL state that every pass starts from and leaves behind; applied by the executor around each pass.
void resetState();

}  // namespace dapple::gl
