#include "scenegen/recipe_species.h"

#include "base/detmath.h"
#include "base/error.h"
#include "scenegen/primitives.h"
#include "scenegen/require_memory.h"

#include <fmt/format.h>

#include <string_view>

namespace dapple::scenegen {
namespace {

constexpr size_t kBytesPerTriangle = 60;  ///< of a tree's meshes, leaves with vertices of their own

}  // namespace

SpeciesEntry readSpeciesEntry(base::ConfigTable& t) {
    SpeciesEntry e;
    const std::string name = t.text("name");
    try {
        e.species = loadSpecies(name);
    } catch (const base::Error& error) {
        // A damaged species file names itself; an unknown name is this table's fault.
        if (std::string_view(error.what()).starts_with("unknown")) t.fail("name", error.what());
        throw;
    }
    e.stand.share = t.number("share", 1, 1e-6, 1e6);
    e.individuals = int(t.integer("individuals", 1, 1, 1000));
    e.triangles = size_t(t.integer("triangles", 0, 0, 10'000'000));
    const std::string leaves = t.text("leaves", "polygon");
    if (leaves != "polygon" && leaves != "card" && leaves != "solid") t.fail("leaves", fmt::format("'{}' is none of polygon, card, solid", leaves));
    e.leaves = leaves == "card" ? LeafMode::card : leaves == "solid" ? LeafMode::solid : LeafMode::polygon;
    if (t.has("lod")) {
        e.lod = int(t.integer("lod", 0, 0, kLods - 1));
        if (!t.has("triangles")) e.triangles = e.species.triangles[size_t(e.lod)];
    }
    e.keep = t.number("keep", 1, 0.001, 1);
    e.transmittance = readTransmittance(t);
    if (t.has("position")) {
        const std::vector<double> p = t.numbers("position", 2);
        e.position = {p[0], p[1]};
    }
    if (t.has("scale")) {
        const std::vector<double> s = t.numbers("scale", 2);
        if (!(s[0] > 0 && s[1] >= s[0])) t.fail("scale", "must be [lo, hi] with 0 < lo ≤ hi");
        e.stand.scale = {s[0], s[1]};
    }
    if (t.has("altitude")) {
        const std::vector<double> z = t.numbers("altitude", 2);
        if (!(z[1] >= z[0])) t.fail("altitude", "must be [lo, hi] with lo ≤ hi");
        e.stand.altitude = {z[0], z[1]};
    }
    if (t.has("slope")) {
        const auto [sine, cosine] = base::det::sinCos(t.number("slope", 0, 0, 89) * base::det::kDegree);
        e.stand.steepest = sine / cosine;
    }
    t.finish();
    requireMemory(t, "individuals", fmt::format("{} individuals of {} triangles", e.individuals, e.triangles),
                  double(e.individuals) * double(e.triangles), kBytesPerTriangle);
    return e;
}

}  // namespace dapple::scenegen
