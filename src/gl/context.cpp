#include "gl/context.h"

#include "base/error.h"
#include "gl/address_space.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cstring>
#include <utility>

namespace dapple::gl {
namespace {

/// libepoxy opens these on first use, and ends the process where it finds none: so we look first.
void requireLibraries(bool egl) {
    const auto found = [](const char* library) {
        return ::dlopen(library, RTLD_LAZY | RTLD_LOCAL) != nullptr;
    };  // epoxy needs it anyway
    std::vector<std::string> missing, packages;
    if (egl && !found("libEGL.so.1")) {
        missing.push_back("libEGL.so.1");
        packages.push_back("libegl1");
    }
    if (!found("libOpenGL.so.0") && !found("libGL.so.1")) {
        missing.push_back("libOpenGL.so.0");
        packages.push_back("libopengl0");
    }
    if (missing.empty()) return;
    throw base::UsageError(
        fmt::format("{} cannot be loaded, so nothing can be drawn here: install the Debian packages {}, and a driver: "
                    "libegl-mesa0 and "
                    "libgl1-mesa-dri for software rendering, or the GPU vendor's",
                    fmt::join(missing, " and "), fmt::join(packages, " ")));
}

bool clientExtension(const char* name) { return epoxy_has_egl_extension(EGL_NO_DISPLAY, name); }

std::vector<EGLDeviceEXT> eglDevices() {
    if (!clientExtension("EGL_EXT_device_enumeration") && !clientExtension("EGL_EXT_device_base")) return {};
    EGLint count = 0;
    if (!eglQueryDevicesEXT(0, nullptr, &count) || count <= 0) return {};
    std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count));
    eglQueryDevicesEXT(count, devices.data(), &count);
    return devices;
}

DeviceInfo describe(EGLDeviceEXT device, int index) {
    DeviceInfo info{index, "unnamed device", false};
    const char* extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
    const std::string list = extensions ? extensions : "";
    info.software = list.find("EGL_MESA_device_software") != std::string::npos;
    if (info.software) info.description = "Mesa software rasteriser";
    if (list.find("EGL_EXT_device_drm") != std::string::npos)
        if (const char* node = eglQueryDeviceStringEXT(device, EGL_DRM_DEVICE_FILE_EXT)) info.description = node;
    if (list.find("EGL_NV_device_cuda") != std::string::npos) info.description += " (NVIDIA)";
    return info;
}

/// A context on this display, current; or the reason why not.
std::string makeCurrent(EGLDisplay display, EGLContext& context) {
    if (display == EGL_NO_DISPLAY) return "no display";
    if (!eglInitialize(display, nullptr, nullptr)) return fmt::format("eglInitialize failed (0x{:x})", eglGetError());
    if (!eglBindAPI(EGL_OPENGL_API)) return "no desktop OpenGL";
    // Only off-screen framebuffers are drawn to: no config and no surface where the driver allows it.
    const bool noConfig = epoxy_has_egl_extension(display, "EGL_KHR_no_config_context");
    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!noConfig) {
        const EGLint want[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_NONE};
        EGLint count = 0;
        if (!eglChooseConfig(display, want, &config, 1, &count) || count == 0) return "no EGL config for OpenGL";
    }
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT) return fmt::format("no OpenGL 4.5 core context (0x{:x})", eglGetError());
    if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        eglDestroyContext(display, context);
        return fmt::format("no surfaceless context (0x{:x})", eglGetError());
    }
    return {};
}

constexpr const char* kInstallHint =
    "install a GL 4.5 driver: libegl-mesa0 and libgl1-mesa-dri for software rendering, or the GPU vendor's";

}  // namespace

std::vector<DeviceInfo> listDevices() {
    requireLibraries(true);
    std::vector<DeviceInfo> result;
    for (EGLDeviceEXT device : eglDevices()) result.push_back(describe(device, static_cast<int>(result.size())));
    return result;
}

Context Context::headless(int device) {
    requireLibraries(true);
    guardAddressSpace();
    const std::vector<EGLDeviceEXT> devices = eglDevices();
    std::vector<std::string> tried;
    Context result;
    // eglGetPlatformDisplayEXT and not eglGetPlatformDisplay: libepoxy can resolve the former before any
    // display is current.
    const auto attempt = [&](const std::string& name, EGLDisplay display) {
        EGLContext context = EGL_NO_CONTEXT;
        const std::string reason = makeCurrent(display, context);
        if (!reason.empty()) {
            tried.push_back(name + ": " + reason);
            return false;
        }
        result.platform_ = name;
        result.display_ = display;
        result.context_ = context;
        return true;
    };
    const auto attemptDevice = [&](size_t i) {
        return attempt(fmt::format("EGL device {}", i), eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
    };

    if (device >= 0) {
        if (size_t(device) >= devices.size())
            throw base::UsageError(fmt::format("no EGL device {}: there are {}; `dapple doctor` lists them", device, devices.size()));
        if (attemptDevice(size_t(device))) return result;
    } else {
        for (size_t i = 0; i < devices.size(); ++i)
            if (!describe(devices[i], int(i)).software && attemptDevice(i)) return result;
        if (clientExtension("EGL_MESA_platform_surfaceless") &&
            attempt("EGL surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)))
            return result;
        if (attempt("EGL default display", eglGetDisplay(EGL_DEFAULT_DISPLAY))) return result;
    }
    throw base::UsageError(fmt::format("no OpenGL 4.5 context (tried {}); {}", fmt::join(tried, "; "), kInstallHint));
}

Context Context::window(int width, int height, const std::string& title) {
    guardAddressSpace();
    const auto fail = [](const std::string& what) -> base::UsageError {
        const char* reason = nullptr;
        glfwGetError(&reason);
        return base::UsageError(fmt::format("{}: {}; a window needs a display (DISPLAY or WAYLAND_DISPLAY), `dapple render` does not",
                                            what, reason ? reason : "no reason given"));
    };
    requireLibraries(false);
    if (!glfwInit()) throw fail("GLFW does not start");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    Context result;
    result.window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (!result.window_) throw fail("no OpenGL 4.5 window");
    glfwMakeContextCurrent(result.window_);
    result.platform_ = "GLFW";
    return result;
}

Context::Context(Context&& other) noexcept
    : platform_(std::move(other.platform_)), display_(std::exchange(other.display_, nullptr)),
      context_(std::exchange(other.context_, nullptr)), window_(std::exchange(other.window_, nullptr)) {}

Context::~Context() {
    if (leaveObjects()) return;
    if (context_) {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(display_, context_);
    }
    if (window_) {
        glfwDestroyWindow(window_);
        glfwTerminate();
    }
}

Identity identify() {
    const auto text = [](GLenum name) {
        const auto* s = reinterpret_cast<const char*>(glGetString(name));
        return std::string(s ? s : "");
    };
    Identity id{text(GL_VENDOR), text(GL_RENDERER), text(GL_VERSION), text(GL_SHADING_LANGUAGE_VERSION), false, 0, 0, 0};
    for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software Rasterizer"})
        id.software |= id.renderer.find(name) != std::string::npos;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &id.maxTextureSize);
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &id.maxArrayLayers);
    glGetIntegerv(GL_MAX_SAMPLES, &id.maxSamples);
    return id;
}

bool hasExtension(const char* name) { return epoxy_has_gl_extension(name); }

void checkErrors(const char* where) {
    std::vector<std::string> errors;
    for (GLenum e = glGetError(); e != GL_NO_ERROR && errors.size() < 8; e = glGetError())
        errors.push_back(e == GL_OUT_OF_MEMORY ? "out of memory" : fmt::format("0x{:x}", e));
    if (!errors.empty())
        throw base::Error(base::ExitCode::failed, fmt::format("GL error {} in {}", fmt::join(errors, ", "), where));
}

}  // namespace dapple::gl
