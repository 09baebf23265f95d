#pragma once

#include "scenegen/import/budget.h"
#include "scenegen/import/notes.h"
#include "scenegen/import/sidecar.h"
#include "scenegen/scene.h"

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dapple::scenegen {

/// The regular file that `name`, as written in a scene file, means: in one of the folders the path as it is, then its
/// file name alone, both at last without regard to case. Backslashes are slashes. Empty when there is none. A file
/// outside the folder that it is looked for in (file_access.h) counts as none, and is noted.
std::filesystem::path findFile(const std::vector<std::filesystem::path>& folders, std::string name, Notes& notes);

/// Textures of a scene file, each read once. One that cannot be had is noted by name.
class TextureFiles {
public:
    /// Textures are looked for beside `file` and in the sidecar's folders.
    TextureFiles(const std::filesystem::path& file, const Sidecar& sidecar);

    struct Request {
        std::string colour;   ///< file name; empty: white
        std::string opacity;  ///< file name of a mask; empty: the colour's own alpha
        char channel = 0;     ///< of the mask: r, g, b, m (alpha), l (grey); 0: alpha if that has holes, else grey
        Wrap wrapU = Wrap::repeat, wrapV = Wrap::repeat;
        std::filesystem::path folder;  ///< searched first; empty: none
    };
    /// Index into `textures`; -1 when there is no such file or it cannot be decoded. Throws UsageError when all
    /// textures together are larger than a scene file may ask for.
    int load(const Request& request);

    /// Pictures that the scene file itself holds; asked first.
    std::function<std::optional<base::Image8>(const std::string& name)> embedded;
    std::vector<Texture> textures;
    Notes notes;

private:
    std::optional<base::Image8> read(const std::string& name, const std::filesystem::path& folder);

    std::vector<std::filesystem::path> folders_;
    Budget budget_;
    std::map<std::string, int> index_;
};

/// Sets texture, alpha test and cut-off of a material whose opacity is `factor` times the texture's alpha and that is
/// drawn where this is at least `cutoff`. `texture`: -1 for none. Returns false when it is drawn nowhere. A texture is
/// a cut-out when more than one texel in a thousand falls below: JPEG noise and stray texels do not count.
bool setOpacity(Material& material, const std::vector<Texture>& textures, int texture, float factor,
                float cutoff = kAlphaCutoff);

/// Notes an opacity that setOpacity() does not follow: one between 0 and 1.
void noteOpacity(Notes& notes, float factor, const std::string& material);

/// IEC 61966-2-1, the sRGB transfer function.
float linearFromSrgb(float v);

}  // namespace dapple::scenegen
