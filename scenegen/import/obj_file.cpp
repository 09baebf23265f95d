#include "scenegen/import/obj_file.h"

#include "base/file.h"
#include "scenegen/import/mtl.h"
#include "scenegen/import/polygon_object.h"
#include "scenegen/import/texture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

// Alias/Wavefront, Advanced Visualizer Manual (1995), appendix B1.
namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

struct Object {
    std::string name;
    std::map<std::string, Faces> byMaterial;
};

class Reader {
public:
    Reader(const fs::path& file, const Sidecar& sidecar)
        : file_(file),
          builder_(file, sidecar, 'y'),
          textures_(file, sidecar),
          budget_(file),
          notes_(builder_.scene.notes) {}

    FileScene read() {
        parse(base::readFile(file_));
        readLibraries();
        if (smooth_ && data_.normals.empty())
            notes_.add("smoothing groups are ignored: edges sharper than 45 degrees are creases");
        for (const Object& object : objects_) {
            std::vector<ObjectPart> parts;
            for (const auto& [material, faces] : object.byMaterial) parts.push_back({&faces, lookOf(material)});
            addPolygonObject(builder_, budget_, data_, object.name, parts);
        }
        builder_.scene.textures = std::move(textures_.textures);
        notes_.add(textures_.notes);
        return builder_.finish();
    }

private:
    void parse(const std::string& text) {
        Faces* faces = nullptr;                // where the next face goes; to be looked up when null
        std::map<std::string, size_t> groups;  // of the current "o"
        std::string material;
        std::string_view line;
        size_t count = 0;
        size_t current = 0;
        const auto begin = [&](const std::string& name) {
            objects_.push_back({name, {}}), faces = nullptr, current = objects_.size() - 1;
        };
        begin("defaultobject");
        for (ObjLines lines(text); lines.next(line);) {
            if (++count % 65536 == 0) budget_.time();
            const std::string_view key = cutWord(line);
            if (key == "v") data_.positions.push_back(position(line));
            else if (key == "vt") data_.uvs.emplace_back(numbers(line));
            else if (key == "vn") data_.normals.push_back(numbers(line));
            else if (key == "f") {
                if (!faces) faces = &objects_[current].byMaterial[material];
                addFace(line, *faces);
            } else if (key == "o") {
                groups.clear();
                begin(std::string(trimmed(line)));
            } else if (key == "g") {
                // A group that comes back goes on.
                const std::string name(trimmed(line));
                const auto [it, isNew] = groups.emplace(name, objects_.size());
                if (isNew) begin(name);
                else faces = nullptr, current = it->second;
            } else if (key == "usemtl") {
                material = trimmed(line);
                faces = nullptr;
            } else if (key == "mtllib") libraries_.emplace(trimmed(line));
            else if (key == "s") smooth_ = smooth_ || (trimmed(line) != "off" && trimmed(line) != "0");
            else if (key == "l" || key == "p") notes_.add("lines and points are ignored");
            else notes_.add("statements that make no faces are ignored", std::string(key));
        }
    }

    static glm::dvec3 numbers(std::string_view line) {
        glm::dvec3 v(0);
        for (int i = 0; i < 3 && cutNumber(line, v[i]); ++i) {}
        return v;
    }

    /// "x y z", "x y z w", or "x y z r g b", whose colours a scene does not have.
    static glm::dvec3 position(std::string_view line) {
        glm::dvec3 p(0);
        for (int i = 0; i < 3 && cutNumber(line, p[i]); ++i) {}
        double w = 1, more = 0;
        if (cutNumber(line, w) && !cutNumber(line, more) && w != 0) p /= w;
        return p;
    }

    /// "7", "7/3", "7//2", "7/3/2"; negative ones count back from the last.
    Faces::Corner corner(std::string_view word) const {
        const auto cut = [&](size_t soFar) {
            int64_t i = 0;
            const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), i);
            if (error != std::errc{} && !word.empty() && word[0] != '/')
                builder_.fail(fmt::format("a face has the corner '{}', which is no index", word.substr(0, 40)));
            word.remove_prefix(size_t(end - word.data()));
            if (word.starts_with('/')) word.remove_prefix(1);
            return i > 0 ? i - 1 : i < 0 ? std::max(int64_t(soFar) + i, int64_t{-2}) : Faces::Corner::kNone;
        };
        Faces::Corner c;
        c.position = cut(data_.positions.size());
        c.uv = cut(data_.uvs.size());
        c.normal = cut(data_.normals.size());
        return c;
    }

    void addFace(std::string_view line, Faces& faces) {
        const size_t before = faces.corners.size();
        for (std::string_view word = cutWord(line); !word.empty() && word[0] != '#'; word = cutWord(line))
            faces.corners.push_back(corner(word));
        const size_t size = faces.corners.size() - before;
        if (size < 3) {
            faces.corners.resize(before);
            notes_.add("faces with fewer than three corners are ignored");
            return;
        }
        budget_.triangles(size - 2);
        faces.sizes.push_back(uint32_t(size));
    }

    void readLibraries() {
        const fs::path folder = file_.parent_path().empty() ? fs::path(".") : file_.parent_path();
        for (const std::string& names : libraries_) {
            std::vector<std::string> wanted{names};  // one name with blanks, or several names
            Notes probed;
            if (names.find(' ') != std::string::npos && findFile({folder}, names, probed).empty()) {
                wanted.clear();
                std::string_view rest = names;
                for (std::string_view word = cutWord(rest); !word.empty(); word = cutWord(rest))
                    wanted.emplace_back(word);
            }
            for (const std::string& name : wanted) {
                fs::path path = findFile({folder}, name, notes_);
                if (path.empty()) {
                    path = findFile({folder}, file_.stem().string() + ".mtl", probed);
                    notes_.add(path.empty()
                                   ? "material libraries are not found, and their materials are grey"
                                   : "material libraries are not found, and the one named like the scene is read",
                               name);
                }
                if (path.empty()) continue;
                anyLibrary_ = true;
                for (const MtlMaterial& m : readMtl(base::readFile(path), notes_))
                    looks_.emplace(m.name, look(m, path.parent_path()));
            }
        }
    }

    Look look(const MtlMaterial& source, const fs::path& folder) {
        Material m;
        m.name = source.name;
        for (int i = 0; i < 3; ++i)
            m.albedo[i] = source.diffuse[i] >= 0 ? linearFromSrgb(std::min(source.diffuse[i], 1.0f)) : 0;
        if (source.shininess >= 1) {  // below: no highlight that a pixel could show
            m.specular =
                std::clamp(std::max({source.specular.r, source.specular.g, source.specular.b, 0.0f}), 0.0f, 1.0f);
            m.shininess = std::min(source.shininess, 1024.0f);
        }
        const bool hasMask = !source.mask.file.empty(), hasColour = !source.colour.file.empty();
        const MtlMaterial::Map& map = hasColour ? source.colour : source.mask;
        if (hasColour && hasMask &&
            (source.mask.scale != map.scale || source.mask.offset != map.offset || source.mask.clamp != map.clamp))
            notes_.add("-s, -o and -clamp of map_d are ignored where map_Kd says otherwise", source.name);
        const Wrap wrap = map.clamp ? Wrap::clamp : Wrap::repeat;
        int texture = -1;
        if (hasColour || hasMask)
            texture = textures_.load({source.colour.file, source.mask.file, source.mask.channel, wrap, wrap, folder});
        noteOpacity(notes_, source.opacity, source.name);
        Look look{-1, -1, map.scale, map.offset};
        if (setOpacity(m, {}, -1, source.opacity)) look.flat = int(builder_.addMaterial(m));
        // Many exporters leave a textured material black.
        if (texture >= 0 && std::max({m.albedo.r, m.albedo.g, m.albedo.b}) < 0.01f) m.albedo = glm::vec3(1);
        if (setOpacity(m, textures_.textures, texture, source.opacity)) look.textured = int(builder_.addMaterial(m));
        return look;
    }

    const Look& lookOf(const std::string& material) {
        if (const auto it = looks_.find(material); it != looks_.end()) return it->second;
        if (!material.empty() && anyLibrary_) notes_.add("materials are in no library and are grey", material);
        MtlMaterial grey;
        grey.name = material;
        return looks_.emplace(material, look(grey, {})).first->second;
    }

    const fs::path& file_;
    SceneBuilder builder_;
    TextureFiles textures_;
    Budget budget_;
    Notes& notes_;
    PolygonData data_;
    std::vector<Object> objects_;
    std::set<std::string> libraries_;
    std::map<std::string, Look> looks_;
    bool smooth_ = false, anyLibrary_ = false;
};

}  // namespace

FileScene readObj(const fs::path& file, const Sidecar& sidecar) { return Reader(file, sidecar).read(); }

}  // namespace dapple::scenegen
