#pragma once

#include "scenegen/import/notes.h"
#include "scenegen/scene.h"

#include <string>
#include <string_view>
#include <vector>

namespace dapple::scenegen {

/// A material of a Wavefront MTL file, as far as a scene has it.
struct MtlMaterial {
    struct Map {
        std::string file;                ///< as written; empty: none
        glm::dvec2 scale{1}, offset{0};  ///< -s and -o: u' = scale · u + offset, v growing upwards
        bool clamp = false;
        char channel = 0;  ///< of -imfchan; 0 when the file does not say

        bool operator==(const Map&) const = default;
    };
    std::string name;
    glm::vec3 diffuse{0.6f};  ///< as written: sRGB, as most programs mean it; the default is Assimp's
    glm::vec3 specular{0};
    float shininess = 0;
    float opacity = 1;  ///< d, or 1 - Tr; [0, 1]
    Map colour, mask;   ///< map_Kd and map_d
};

/// Reads the text of an MTL file. Statements that are not followed are noted.
/// Alias/Wavefront, Advanced Visualizer Manual (1995), appendix B1.
std::vector<MtlMaterial> readMtl(std::string_view text, Notes& notes);

/// Lines of an OBJ or MTL file: without comments, ends of lines and a byte order mark; those that end with \ are
/// joined.
class ObjLines {
public:
    explicit ObjLines(std::string_view text);
    /// False at the end. `line` is valid until the next call.
    bool next(std::string_view& line);

private:
    std::string_view text_;
    std::string joined_;
};

/// Cuts the first word off `line`; empty at its end.
std::string_view cutWord(std::string_view& line);
/// Cuts a number off the line, if its first word is one: "1", "+1.5", "-2e3", "nan".
bool cutNumber(std::string_view& line, double& number);
/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

}  // namespace dapple::scenegen
