#include "gl/objects.h"

#include "base/expect_error.h"
#include "gl/context.h"

#include <array>
#include <numeric>
#include <vector>

namespace dapple::gl {
namespace {

class ObjectsTest : public ::testing::Test {
protected:
    ObjectsTest() : context_(Context::headless()) {}
    ~ObjectsTest() override { EXPECT_NO_THROW(checkErrors("test")); }
    Context context_;
};

std::vector<uint8_t> contents(const Buffer& buffer, size_t bytes) {
    std::vector<uint8_t> data(bytes);
    glGetNamedBufferSubData(buffer.name(), 0, GLsizeiptr(bytes), data.data());
    return data;
}
std::vector<uint8_t> ramp(size_t bytes, int start) {
    std::vector<uint8_t> data(bytes);
    std::iota(data.begin(), data.end(), uint8_t(start));
    return data;
}

TEST_F(ObjectsTest, HandlesOwnTheirNames) {
    Buffer a(64, nullptr);
    const GLuint name = a.name();
    Buffer b = std::move(a);
    EXPECT_EQ(b.name(), name);
    EXPECT_TRUE(glIsBuffer(name));
    b = Buffer();
    EXPECT_EQ(b.name(), 0u);
    EXPECT_FALSE(glIsBuffer(name));
}

TEST_F(ObjectsTest, BufferHoldsWhatItWasGiven) {
    for (const size_t bytes : {size_t{1}, size_t{15}, size_t{16}, size_t{1000}}) {
        const Buffer buffer = Buffer::of<uint8_t>(ramp(bytes, 3));
        EXPECT_EQ(contents(buffer, bytes), ramp(bytes, 3));
        EXPECT_GE(buffer.bytes(), bytes);
        GLint64 size = 0;
        glGetNamedBufferParameteri64v(buffer.name(), GL_BUFFER_SIZE, &size);
        EXPECT_EQ(size_t(size), buffer.bytes());
    }
    EXPECT_NE(Buffer::of<uint8_t>({}).name(), 0u);
}

TEST_F(ObjectsTest, BufferUpdateKeepsTheRestAndGrows) {
    Buffer buffer(100, ramp(100, 0).data(), true);
    const GLuint first = buffer.name();
    buffer.update(10, ramp(10, 200).data());
    EXPECT_EQ(buffer.name(), first);
    std::vector<uint8_t> expected = ramp(100, 0);
    const std::vector<uint8_t> head = ramp(10, 200);
    std::copy(head.begin(), head.end(), expected.begin());
    EXPECT_EQ(contents(buffer, 100), expected);

    buffer.update(5000, ramp(5000, 7).data());
    EXPECT_GE(buffer.bytes(), 5000u);
    EXPECT_EQ(contents(buffer, 5000), ramp(5000, 7));
    EXPECT_TRUE(!glIsBuffer(first) || buffer.name() == first);  // the old storage is gone

    const GLuint grown = buffer.name();
    buffer.update(0, nullptr);
    EXPECT_EQ(buffer.name(), grown);
    EXPECT_EQ(contents(buffer, 5000), ramp(5000, 7));

    Buffer none;
    none.update(0, nullptr);
    EXPECT_NE(none.name(), 0u);
    none.update(3, ramp(3, 1).data());
    EXPECT_EQ(contents(none, 3), ramp(3, 1));
}

TEST_F(ObjectsTest, TextureBytesAreFormatTimesExtentTimesLayersTimesMips) {
    EXPECT_EQ(Texture(GL_RGBA8, 10, 7).bytes(), 10u * 7 * 4);
    EXPECT_EQ(Texture(GL_DEPTH_COMPONENT32F, 64, 64, 3).bytes(), 64u * 64 * 3 * 4);
    EXPECT_EQ(Texture(GL_DEPTH_COMPONENT16, 64, 32, 1).bytes(), 64u * 32 * 2);
    EXPECT_EQ(Texture(GL_SRGB8_ALPHA8, 8, 4, 0, 4).bytes(), (32u + 8 + 2 + 1) * 4);      // 8×4, 4×2, 2×1, 1×1
    EXPECT_EQ(Texture(GL_RGBA16F, 5, 3, 2, 3).bytes(), (15u + 2 + 1) * 2 * 8);           // 5×3, 2×1, 1×1
    EXPECT_EQ(Texture().bytes(), 0u);
}

// Oracle: the sizes of the components as the driver itself reports them.
TEST_F(ObjectsTest, BytesPerTexelMatchesTheDriver) {
    for (const GLenum format : {GL_R8, GL_RG8, GL_RGBA8, GL_SRGB8_ALPHA8, GL_R16F, GL_RG16F, GL_RGBA16F, GL_R32F, GL_RG32F,
                                GL_RGBA32F, GL_RG16, GL_RGBA16, GL_R32UI, GL_DEPTH_COMPONENT16, GL_DEPTH_COMPONENT32F}) {
        const Texture texture(format, 4, 4);
        GLint bits = 0;
        for (const GLenum size : {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE, GL_TEXTURE_ALPHA_SIZE, GL_TEXTURE_DEPTH_SIZE}) {
            GLint n = 0;
            glGetTextureLevelParameteriv(texture.name(), 0, size, &n);
            bits += n;
        }
        EXPECT_EQ(int(bytesPerTexel(format)) * 8, bits) << std::hex << format;
    }
    base::errorLine([] { bytesPerTexel(GL_COMPRESSED_RGBA_BPTC_UNORM); }, base::ExitCode::failed);
}

TEST_F(ObjectsTest, ImpossibleTexturesAreErrors) {
    base::errorLine([] { Texture(GL_RGBA8, 0, 4); }, base::ExitCode::failed);
    base::errorLine([] { Texture(GL_RGBA8, 1 << 20, 4); }, base::ExitCode::failed);
    base::errorLine([] { Texture(GL_RGBA8, 4, 4, 0, 9); }, base::ExitCode::failed);
}

TEST_F(ObjectsTest, FramebuffersDrawIntoTheirLayer) {
    const Texture colour(GL_RGBA8, 8, 8), depth(GL_DEPTH_COMPONENT32F, 8, 8, 3);
    const Texture* colours[] = {&colour};
    for (int layer = 0; layer < 3; ++layer) {
        const Framebuffer framebuffer = makeFramebuffer(colours, &depth, layer);
        const float value = 0.25f * float(layer + 1);
        glClearNamedFramebufferfv(framebuffer.name(), GL_DEPTH, 0, &value);
    }
    std::vector<float> texels(8 * 8 * 3);
    glGetTextureImage(depth.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, GLsizei(texels.size() * 4), texels.data());
    for (size_t i = 0; i < texels.size(); ++i) EXPECT_EQ(texels[i], 0.25f * float(i / 64 + 1));
    EXPECT_NO_THROW(makeFramebuffer({}, &depth, 0));
    const Texture* wrong[] = {&depth};
    base::errorLine([&] { makeFramebuffer(wrong, nullptr); }, base::ExitCode::failed);
}

TEST_F(ObjectsTest, SamplersDoWhatTheySay) {
    const Sampler sampler = makeSampler({GL_LINEAR, true, GL_CLAMP_TO_BORDER, true, 0.5f});
    const auto get = [&](GLenum name) {
        GLint v = 0;
        glGetSamplerParameteriv(sampler.name(), name, &v);
        return GLenum(v);
    };
    EXPECT_EQ(get(GL_TEXTURE_MIN_FILTER), GLenum(GL_LINEAR_MIPMAP_LINEAR));
    EXPECT_EQ(get(GL_TEXTURE_MAG_FILTER), GLenum(GL_LINEAR));
    EXPECT_EQ(get(GL_TEXTURE_WRAP_S), GLenum(GL_CLAMP_TO_BORDER));
    EXPECT_EQ(get(GL_TEXTURE_WRAP_T), GLenum(GL_CLAMP_TO_BORDER));
    EXPECT_EQ(get(GL_TEXTURE_COMPARE_MODE), GLenum(GL_COMPARE_REF_TO_TEXTURE));
    EXPECT_EQ(get(GL_TEXTURE_COMPARE_FUNC), GLenum(GL_LEQUAL));
    std::array<float, 4> border{};
    glGetSamplerParameterfv(sampler.name(), GL_TEXTURE_BORDER_COLOR, border.data());
    EXPECT_EQ(border, (std::array<float, 4>{0.5f, 0.5f, 0.5f, 0.5f}));
}

TEST_F(ObjectsTest, ResetStateUndoesEveryState) {
    const Texture colour(GL_RGBA8, 8, 8);
    const Texture* colours[] = {&colour};
    const Framebuffer framebuffer = makeFramebuffer(colours, nullptr);
    const VertexArray vertexArray = makeVertexArray();
    const char* source = "#version 450 core\nvoid main() { gl_Position = vec4(0); }";
    const GLuint program = glCreateShaderProgramv(GL_VERTEX_SHADER, 1, &source);
    const std::array<GLenum, 6> capabilities{GL_DEPTH_TEST, GL_DEPTH_CLAMP, GL_CULL_FACE, GL_BLEND, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB};
    const auto integer = [](GLenum name) {
        GLint v[4] = {};
        glGetIntegerv(name, v);
        return GLenum(v[0]);
    };

    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glUseProgram(program);
    glBindVertexArray(vertexArray.name());
    for (const GLenum capability : capabilities) glEnable(capability);
    glCullFace(GL_FRONT);
    glFrontFace(GL_CW);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_FALSE);
    glBlendEquation(GL_MAX);
    glBlendFuncSeparate(GL_DST_COLOR, GL_ONE, GL_SRC_ALPHA, GL_DST_ALPHA);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    ASSERT_EQ(integer(GL_CURRENT_PROGRAM), program);
    ASSERT_EQ(integer(GL_DEPTH_FUNC), GLenum(GL_GREATER));
    ASSERT_NO_THROW(checkErrors("setting states"));

    resetState();
    EXPECT_EQ(integer(GL_DRAW_FRAMEBUFFER_BINDING), 0u);
    EXPECT_EQ(integer(GL_READ_FRAMEBUFFER_BINDING), 0u);
    EXPECT_EQ(integer(GL_CURRENT_PROGRAM), 0u);
    EXPECT_EQ(integer(GL_VERTEX_ARRAY_BINDING), 0u);
    for (const GLenum capability : capabilities) EXPECT_FALSE(glIsEnabled(capability)) << std::hex << capability;
    EXPECT_EQ(integer(GL_CULL_FACE_MODE), GLenum(GL_BACK));
    EXPECT_EQ(integer(GL_FRONT_FACE), GLenum(GL_CCW));
    EXPECT_EQ(integer(GL_DEPTH_FUNC), GLenum(GL_LESS));
    EXPECT_EQ(integer(GL_DEPTH_WRITEMASK), 1u);
    std::array<GLboolean, 4> mask{};
    glGetBooleanv(GL_COLOR_WRITEMASK, mask.data());
    EXPECT_EQ(mask, (std::array<GLboolean, 4>{1, 1, 1, 1}));
    EXPECT_EQ(integer(GL_BLEND_EQUATION_RGB), GLenum(GL_FUNC_ADD));
    EXPECT_EQ(integer(GL_BLEND_EQUATION_ALPHA), GLenum(GL_FUNC_ADD));
    EXPECT_EQ(integer(GL_BLEND_SRC_RGB), GLenum(GL_ONE));
    EXPECT_EQ(integer(GL_BLEND_SRC_ALPHA), GLenum(GL_ONE));
    EXPECT_EQ(integer(GL_BLEND_DST_RGB), GLenum(GL_ZERO));
    EXPECT_EQ(integer(GL_BLEND_DST_ALPHA), GLenum(GL_ZERO));
    EXPECT_EQ(integer(GL_CLIP_ORIGIN), GLenum(GL_LOWER_LEFT));
    EXPECT_EQ(integer(GL_CLIP_DEPTH_MODE), GLenum(GL_ZERO_TO_ONE));
    glDeleteProgram(program);
}

}  // namespace
}  // namespace dapple::gl
