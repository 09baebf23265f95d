#include "gl/program.h"

#include "base/expect_error.h"
#include "base/file.h"
#include "gl/context.h"

#include <glm/gtc/type_ptr.hpp>

#include <cstdlib>
#include <filesystem>

namespace dapple::gl {
namespace {
namespace fs = std::filesystem;

/// A shader tree of the test's own.
class ProgramTest : public ::testing::Test {
protected:
    ProgramTest() : context_(Context::headless()) {
        std::string pattern = (fs::path(testing::TempDir()) / "dapple_program_XXXXXX").string();
        folder_ = ::mkdtemp(pattern.data());
        ::setenv("DAPPLE_HOME", folder_.c_str(), 1);
        write("good.vert", "void main() { gl_Position = vec4(0); }\n");
    }
    ~ProgramTest() override {
        ::unsetenv("DAPPLE_HOME");
        fs::remove_all(folder_);
        EXPECT_NO_THROW(checkErrors("test"));
    }
    void write(const std::string& name, const std::string& text) const { base::writeFile(folder_ / "shaders" / name, text); }

    Context context_;
    fs::path folder_;
};

TEST_F(ProgramTest, ErrorsCarryFileAndLine) {
    write("bad.vert", "// one\n// two\nvoid main() {\n    gl_Position = undeclared;\n}\n");
    base::expectHolds(base::errorLine([] { Program("bad.vert", ""); }), "shaders/bad.vert:4: ");

    write("bad.frag", "\nout vec4 c;\nvoid main() { c = vec3(1); }\n");
    base::expectHolds(base::errorLine([] { Program("good.vert", "bad.frag"); }), "shaders/bad.frag:3: ");
}

TEST_F(ProgramTest, LinesHoldInsideAndAfterIncludes) {
    write("lib/a.glsl", "// one\n#include \"lib/b.glsl\"\n// three\nfloat a() { return b() + WRONG_A; }\n");
    write("lib/b.glsl", "// one\n// two\nfloat b() { return WRONG_B; }\n");
    const char* user = "// one\n#include \"lib/a.glsl\"\n#include \"lib/b.glsl\"\n// four\nvoid main() { gl_Position = vec4(a() + WRONG_C); }\n";
    write("user.vert", user);
    const auto error = [](std::vector<std::string> defines) {
        return base::errorLine([&] { Program("user.vert", "", defines); });
    };
    base::expectHolds(error({"WRONG_A 1.0", "WRONG_C 1.0"}), "shaders/lib/b.glsl:3: ");
    base::expectHolds(error({"WRONG_B 1.0", "WRONG_C 1.0"}), "shaders/lib/a.glsl:4: ");  // after a nested include
    base::expectHolds(error({"WRONG_A 1.0", "WRONG_B 1.0"}), "shaders/user.vert:5: ");   // after one that comes twice
    EXPECT_NO_THROW(Program("user.vert", "", {"WRONG_A 1.0", "WRONG_B 1.0", "WRONG_C 1.0"}));
}

TEST_F(ProgramTest, MissingFilesAreNamed) {
    base::expectHolds(base::errorLine([] { Program("none.vert", ""); }), "none.vert");
    write("user.vert", "#include \"lib/none.glsl\"\nvoid main() {}\n");
    base::expectHolds(base::errorLine([] { Program("user.vert", ""); }), "lib/none.glsl");
}

TEST_F(ProgramTest, LinkErrorsNameBothFiles) {
    write("takes.frag", "in vec2 missing;\nout vec4 c;\nvoid main() { c = missing.xyxy; }\n");
    const std::string line = base::errorLine([] { Program("good.vert", "takes.frag"); });
    base::expectHolds(line, "shaders/good.vert");
    base::expectHolds(line, "shaders/takes.frag");
}

TEST_F(ProgramTest, UniformsArriveAndUnknownOnesAreIgnored) {
    write("u.vert", "uniform int i; uniform float f; uniform vec2 v2; uniform vec3 v3; uniform vec4 v4; uniform mat4 m;\n"
                    "uniform mat4 ms[2]; uniform vec4 vs[2];\n"
                    "void main() { gl_Position = m * ms[0] * ms[1] * (v4 + vs[0] + vs[1] + v2.xyxy + v3.xyzz + f + float(i)); }\n");
    const Program program("u.vert", "");
    std::array<glm::mat4, 2> ms{glm::mat4(3), glm::mat4(4)};
    ms[1][3][0] = 7;
    const std::array<glm::vec4, 2> vs{glm::vec4(1, 2, 3, 4), glm::vec4(5, 6, 7, 8)};
    program.set("i", -3);
    program.set("f", 0.5f);
    program.set("v2", glm::vec2(1, 2));
    program.set("v3", glm::vec3(1, 2, 3));
    program.set("v4", glm::vec4(1, 2, 3, 4));
    program.set("m", ms[1]);
    program.set("ms", ms);
    program.set("vs", vs);
    program.set("none", 1.0f);
    const auto get = [&](const char* name) {
        std::array<float, 16> v{};
        glGetUniformfv(program.name(), glGetUniformLocation(program.name(), name), v.data());
        return v;
    };
    GLint i = 0;
    glGetUniformiv(program.name(), glGetUniformLocation(program.name(), "i"), &i);
    EXPECT_EQ(i, -3);
    EXPECT_EQ(get("f")[0], 0.5f);
    EXPECT_EQ(glm::make_vec2(get("v2").data()), glm::vec2(1, 2));
    EXPECT_EQ(glm::make_vec3(get("v3").data()), glm::vec3(1, 2, 3));
    EXPECT_EQ(glm::make_vec4(get("v4").data()), glm::vec4(1, 2, 3, 4));
    EXPECT_EQ(glm::make_mat4(get("m").data()), ms[1]);
    EXPECT_EQ(glm::make_mat4(get("ms[0]").data()), ms[0]);
    EXPECT_EQ(glm::make_mat4(get("ms[1]").data()), ms[1]);
    EXPECT_EQ(glm::make_vec4(get("vs[1]").data()), vs[1]);
}

TEST_F(ProgramTest, TreeHashFollowsEverySource) {
    const uint64_t before = shaderTreeHash();
    EXPECT_EQ(shaderTreeHash(), before);
    write("lib/a.glsl", "// a\n");
    const uint64_t added = shaderTreeHash();
    EXPECT_NE(added, before);
    write("lib/a.glsl", "// b\n");
    EXPECT_NE(shaderTreeHash(), added);
    write("lib/a.glsl", "// a\n");
    EXPECT_EQ(shaderTreeHash(), added);
}

}  // namespace
}  // namespace dapple::gl
