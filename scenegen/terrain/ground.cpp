#include "scenegen/terrain/ground.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>

namespace dapple::scenegen {
namespace det = base::det;

Ground::Ground(const GroundOptions& options) : options_(options) {
    if (options.undulation == 0) return;
    base::Random random(options.seed, 0, 0x67726f756e64);
    for (int i = 0; i < 4; ++i) {
        const auto [s, c] = det::sinCos(2 * det::kPi * random.next());
        const double wavelength = random.next(30, 90);
        waves_.push_back({glm::dvec2(c, s) * (2 * det::kPi / wavelength), 2 * det::kPi * random.next(), options.undulation / 4});
    }
}

double Ground::height(double x, double y) const {
    double z = 0;
    for (const Wave& w : waves_) z += w.amplitude * det::sin(w.k.x * x + w.k.y * y + w.phase);
    return z;
}

glm::dvec3 Ground::normal(double x, double y) const {
    glm::dvec2 slope(0);
    for (const Wave& w : waves_) slope += w.k * (w.amplitude * det::cos(w.k.x * x + w.k.y * y + w.phase));
    return glm::normalize(glm::dvec3(-slope, 1));
}

Mesh Ground::mesh() const {
    constexpr uint32_t kStripe = 12;  // columns per pass: a row of it stays in a GPU's vertex cache
    const auto n = uint32_t(options_.cells);
    Mesh mesh;
    for (uint32_t j = 0; j <= n; ++j)
        for (uint32_t i = 0; i <= n; ++i) {
            const double x = (double(i) / n - 0.5) * options_.size, y = (double(j) / n - 0.5) * options_.size;
            mesh.positions.emplace_back(float(x), float(y), float(height(x, y)));
            mesh.normals.emplace_back(normal(x, y));
        }
    for (uint32_t stripe = 0; stripe < n; stripe += kStripe)
        for (uint32_t j = 0; j < n; ++j)
            for (uint32_t i = stripe; i < std::min(n, stripe + kStripe); ++i) {
                const uint32_t a = j * (n + 1) + i, b = a + n + 1;
                mesh.indices.insert(mesh.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
            }
    return mesh;
}

}  // namespace dapple::scenegen
