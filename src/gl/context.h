#pragma once

#include <memory>
#include <string>
#include <vector>

struct GLFWwindow;

namespace dapple::gl {

/// An EGL device as `doctor` lists it and `--device N` names it.
struct DeviceInfo {
    int index = 0;
    std::string description;  ///< DRM node or vendor's name
    bool software = false;
};
std::vector<DeviceInfo> listDevices();  ///< throws UsageError where EGL or GL is not installed

/// An OpenGL 4.5 core context, current on the calling thread for its life. Movable, not copyable.
class Context {
public:
    /// Headless through EGL. `device` ≥ 0: that EGL device. −1: the first hardware device that gives a
    /// context, else Mesa's surfaceless platform, else the default display.
    /// Throws UsageError that says what was tried and what to install.
    static Context headless(int device = -1);
    /// A visible GLFW window.
    static Context window(int width, int height, const std::string& title);

    Context(Context&&) noexcept;
    Context& operator=(Context&&) = delete;
    ~Context();

    const std::string& platform() const { return platform_; }  ///< "EGL device 0", "EGL surfaceless", "GLFW"
    GLFWwindow* handle() const { return window_; }             ///< nullptr when headless

private:
    Context() = default;
    std::string platform_;
    void* display_ = nullptr;
    void* context_ = nullptr;
    GLFWwindow* window_ = nullptr;
};

/// What the current context says of itself.
struct Identity {
    std::string vendor, renderer, version, glsl;
    bool software = false;  ///< llvmpipe, softpipe or swrast: its times are a CPU's
    int maxTextureSize = 0, maxArrayLayers = 0, maxSamples = 0;
};
Identity identify();
bool hasExtension(const char* name);

/// Throws base::Error(failed) naming `where` if GL has an error pending.
void checkErrors(const char* where);

}  // namespace dapple::gl
