#include "scenegen/import/sidecar.h"

#include "base/config.h"
#include "scenegen/import/file_access.h"
#include "scenegen/import/file_kind.h"

#include <fnmatch.h>

#include <algorithm>
#include <set>

namespace dapple::scenegen {
namespace {

View readView(base::ConfigTable& table) {
    View view;
    view.name = table.text("name");
    const auto eye = table.numbers("eye", 3), target = table.numbers("target", 3);
    view.eye = {eye[0], eye[1], eye[2]};
    const glm::dvec3 line = glm::dvec3(target[0], target[1], target[2]) - view.eye;
    if (glm::length(line) < 1e-6) table.fail("target", "must differ from eye");
    view.forward = glm::normalize(line);
    if (std::abs(view.forward.z) > 1 - 1e-9) view.up = {0, 1, 0};
    view.fovY = table.number("fov", 60, 1, 170);
    view.near = table.number("near", 0.3, 1e-6, 1e6);
    view.far = table.number("far", 0, 0, 1e9);
    if (table.has("far") && view.far <= view.near) table.fail("far", "must be beyond near");
    table.finish();
    return view;
}

}  // namespace

Sidecar readSidecar(const std::filesystem::path& file) {
    Sidecar sidecar;
    const auto path = std::filesystem::path(file).replace_extension(".toml");
    if (!hasSidecar(file)) return sidecar;
    auto root = base::ConfigTable::parseFile(path);
    if (root.has("up")) {
        const std::string up = root.text("up");
        if (up != "x" && up != "y" && up != "z" && up != "-x" && up != "-y" && up != "-z")
            root.fail("up", "must be \"x\", \"y\", \"z\", \"-x\", \"-y\" or \"-z\"");
        sidecar.up = up;
    }
    if (root.has("unit")) sidecar.unit = root.number("unit", 1, 1e-9, 1e9);
    sidecar.cell = root.number("cell", sidecar.cell, 1, 1e6);
    if (root.has("textures"))
        for (const std::string& folder : root.values("textures")) {
            sidecar.textures.push_back(path.parent_path() / folder);
            requireInside(path, sidecar.textures.back());
        }
    if (root.has("drop")) sidecar.drop = root.values("drop");
    if (root.has("receivers")) sidecar.receivers = root.values("receivers");
    for (base::ConfigTable& table : root.tables("copy")) {
        Sidecar::Copy copy{table.text("node"), {}, table.number("yaw", 0, -360, 360)};
        const auto to = table.numbers("to", 3);
        copy.to = {to[0], to[1], to[2]};
        table.finish();
        sidecar.copies.push_back(std::move(copy));
    }
    if (auto table = root.table("sun")) {
        Sun sun;
        sun.azimuth = table->number("azimuth", sun.azimuth, -360, 360);
        sun.elevation = table->number("elevation", sun.elevation, -90, 90);
        table->finish();
        sidecar.sun = sun;
    }
    std::set<std::string> names;
    for (base::ConfigTable& table : root.tables("view")) {
        sidecar.views.push_back(readView(table));
        if (!names.insert(sidecar.views.back().name).second) table.fail("name", "is used by two views");
    }
    root.finish();
    return sidecar;
}

bool matchesAny(const std::string& name, const std::vector<std::string>& patterns) {
    return std::ranges::any_of(patterns, [&](const std::string& p) { return ::fnmatch(p.c_str(), name.c_str(), 0) == 0; });
}

}  // namespace dapple::scenegen
