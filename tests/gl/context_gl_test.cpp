#include "gl/context.h"

#include "base/expect_error.h"

#include <epoxy/gl.h>

#include <cstdio>

namespace dapple::gl {
namespace {

TEST(Context, IsOpenGl45CoreOrLater) {
    const Context context = Context::headless();
    const Identity id = identify();
    int major = 0, minor = 0;
    ASSERT_EQ(std::sscanf(id.version.c_str(), "%d.%d", &major, &minor), 2) << id.version;
    EXPECT_GE(major * 10 + minor, 45);
    GLint profile = 0;
    glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
    EXPECT_TRUE(profile & GL_CONTEXT_CORE_PROFILE_BIT);
    EXPECT_FALSE(id.vendor.empty());
    EXPECT_FALSE(id.renderer.empty());
    EXPECT_FALSE(id.glsl.empty());
    // Minima that OpenGL 4.5 guarantees (table 23.62 and following).
    EXPECT_GE(id.maxTextureSize, 16384);
    EXPECT_GE(id.maxArrayLayers, 2048);
    EXPECT_GE(id.maxSamples, 4);
    EXPECT_TRUE(id.software || id.renderer.find("llvmpipe") == std::string::npos);
    EXPECT_EQ(context.platform().substr(0, 3), "EGL");
    EXPECT_EQ(context.handle(), nullptr);
}

TEST(Context, ListedDevicesAreNumberedAndOthersRefused) {
    const std::vector<DeviceInfo> devices = listDevices();
    for (size_t i = 0; i < devices.size(); ++i) {
        EXPECT_EQ(devices[i].index, int(i));
        EXPECT_FALSE(devices[i].description.empty());
    }
    for (const int device : {int(devices.size()), int(devices.size()) + 7, 1'000'000}) {
        const std::string line = base::errorLine([&] { Context::headless(device); });
        base::expectHolds(line, "no EGL device " + std::to_string(device));
        base::expectHolds(line, "there are " + std::to_string(devices.size()));
    }
}

TEST(Context, MovesAndEndsWithItsOwner) {
    {
        Context first = Context::headless();
        const Context second = std::move(first);
        EXPECT_NE(glGetString(GL_VERSION), nullptr);
    }
    const Context again = Context::headless();
    EXPECT_NE(glGetString(GL_VERSION), nullptr);
}

TEST(CheckErrors, ThrowsOnceForWhatWasPending) {
    const Context context = Context::headless();
    EXPECT_NO_THROW(checkErrors("a quiet place"));
    glEnable(GL_TEXTURE_2D);  // no such capability in the core profile
    const std::string line = base::errorLine([] { checkErrors("the test"); }, base::ExitCode::failed);
    base::expectHolds(line, "0x500");
    base::expectHolds(line, "the test");
    EXPECT_NO_THROW(checkErrors("a quiet place"));
}

TEST(HasExtension, KnowsNoInventedOne) {
    const Context context = Context::headless();
    GLint count = 0;
    glGetIntegerv(GL_NUM_EXTENSIONS, &count);
    ASSERT_GT(count, 0);
    EXPECT_TRUE(hasExtension(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, GLuint(count - 1)))));
    EXPECT_FALSE(hasExtension("GL_DAPPLE_no_such_extension"));
}

}  // namespace
}  // namespace dapple::gl
