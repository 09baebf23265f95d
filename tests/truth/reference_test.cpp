#include "truth/closed_form.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace dapple::truth::test {
namespace {

constexpr double kBand = 1e-3;  ///< metres by which a start may be off: above 16 ε at the distances used here

std::vector<dvec3> suns() {
    std::vector<dvec3> lights;
    for (const double elevation : {90.0, 60.0, 30.0, 5.0})
        for (const double azimuth : {0.0, 77.0, 135.0, 200.0, 311.0}) lights.push_back(scenegen::Sun{azimuth, elevation}.direction());
    return lights;
}

struct Tally {
    size_t lit = 0, shadowed = 0, either = 0;
};

/// Every label must be what the closed form says, but where it says either.
Tally expectLabels(const Reference& reference, const std::vector<Point>& points, const std::function<Expected(const Point&)>& expected) {
    Tally tally;
    size_t wrong = 0;
    for (size_t i = 0; i < points.size(); ++i) {
        const Expected e = expected(points[i]);
        if (e == Expected::either) {
            ++tally.either;
            continue;
        }
        ++(e == Expected::lit ? tally.lit : tally.shadowed);
        if (reference.label[i] == (e == Expected::lit ? Label::lit : Label::shadowed)) continue;
        if (++wrong <= 3)
            ADD_FAILURE() << "label " << int(reference.label[i]) << ", expected " << (e == Expected::lit ? "lit" : "shadowed") << " at ("
                          << points[i].position.x << ", " << points[i].position.y << ", " << points[i].position.z << ")";
    }
    EXPECT_EQ(wrong, 0u);
    return tally;
}

Expected boxShadow(const dvec3& p, const dvec3& toSun, const dvec3& lo, const dvec3& hi, double band = kBand) {
    if (!hitsBox(p, toSun, lo - band, hi + band)) return Expected::lit;
    const bool thick = glm::all(glm::greaterThan(hi - lo, dvec3(2 * band)));
    return thick && hitsBox(p, toSun, lo + band, hi - band) ? Expected::shadowed : Expected::either;
}

// A row of boxes over a plane: those contribute whose shadow falls on the patch, by the closed form; one hidden from the sun
// by another counts as well.
TEST(ReferenceTest, ContributorsAreTheCastersBetweenReceiversAndSun) {
    std::vector<scenegen::Mesh> meshes;
    for (int i = 0; i < 12; ++i) meshes.push_back(boxMesh({-9 + 1.5 * i, 2, 1}, {-8.2 + 1.5 * i, 2.6, 2}));
    meshes.push_back(boxMesh({-0.5, 2, 4}, {0.5, 2.6, 5}));
    scenegen::Scene scene = sceneOf({});
    scene.prototypes.clear();
    scene.instances.clear();
    for (const scenegen::Mesh& mesh : meshes) {
        scene.instances.push_back({vec3(0), 1, 0, uint32_t(scene.prototypes.size())});
        scene.prototypes.push_back({"caster", {mesh}, true, false});
    }
    const dvec3 eye(0, -8, 3);
    const Tracer tracer(scene);
    const Patch patch = patchOf(planeGrid(80, 2), 80, eye);
    for (const dvec3& light : suns()) {
        const std::vector<uint32_t> found = tracer.contributors(patch.receivers, eye, light);
        for (uint32_t i = 0; i < meshes.size(); ++i) {
            const base::Box box = scene.prototypes[scene.instances[i].prototype].box();
            const auto hits = [&](double band) {
                return std::ranges::any_of(patch.points, [&](const Point& p) { return hitsBox(p.position, -light, dvec3(box.lo) - band, dvec3(box.hi) + band); });
            };
            const bool there = std::ranges::binary_search(found, i);
            EXPECT_TRUE(there || !hits(-kBand)) << i;
            EXPECT_TRUE(!there || hits(kBand)) << i;
        }
    }
    EXPECT_TRUE(tracer.contributors(patch.receivers, eye, {0, 0, 1}).empty()) << "by night";
}

TEST(ReferenceTest, BoxOnPlane) {
    const dvec3 lo(-1, -0.7, 0), hi(1.3, 0.9, 2), eye(1.5, -8, 2.2);
    const Tracer tracer(sceneOf({boxMesh(lo, hi)}));
    const Patch patch = patchOf(planeGrid(160, 8), 160, eye);
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) { return boxShadow(p.position, -light, lo, hi); });
        EXPECT_GT(t.shadowed, 300u);
        EXPECT_GT(t.lit, 3000u);
        EXPECT_LT(t.either, 160u);
    }
}

TEST(ReferenceTest, SphereAbovePlane) {
    const dvec3 centre(0.3, -0.2, 2), eye(1.5, -8, 2.2);
    const double radius = 1.2;
    const scenegen::Mesh mesh = sphereMesh(centre, radius, 128, 256);
    const double inner = inscribedRadius(mesh, centre);
    EXPECT_GT(inner, 0.999 * radius);
    const Tracer tracer(sceneOf({mesh}));
    const Patch patch = patchOf(planeGrid(160, 8), 160, eye);
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) {
            if (!hitsBall(p.position, -light, centre, radius + kBand)) return Expected::lit;
            return hitsBall(p.position, -light, centre, inner - kBand) ? Expected::shadowed : Expected::either;
        });
        EXPECT_GT(t.lit, 3000u);
        EXPECT_LT(t.either, 200u);
        if (-light.z > 0.4) {
            EXPECT_GT(t.shadowed, 300u);
        }
    }
}

TEST(ReferenceTest, ThinSlabAbovePlane) {
    const dvec3 lo(-2, -1.5, 1.5), hi(2, 1.5, 1.51), eye(-6, -8, 2.2);
    const Tracer tracer(sceneOf({boxMesh(lo, hi)}));
    const Patch patch = patchOf(planeGrid(160, 8), 160, eye);
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) { return boxShadow(p.position, -light, lo, hi); });
        EXPECT_GT(t.lit, 3000u);
        EXPECT_LT(t.either, 300u);
        if (-light.z > 0.4) {
            EXPECT_GT(t.shadowed, 800u);
        }
    }
}

/// Points over the six faces of a box, inset from the edges.
std::vector<Point> facePoints(const dvec3& lo, const dvec3& hi, int n) {
    std::vector<Point> points;
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < n * n; ++i) {
            const int k = face / 2, a = (k + 1) % 3, b = (k + 2) % 3;
            Point p;
            p.normal = dvec3(0);
            p.normal[k] = face % 2 ? 1 : -1;
            p.position[k] = face % 2 ? hi[k] : lo[k];
            p.position[a] = lo[a] + (hi[a] - lo[a]) * (i % n + 0.5) / n;
            p.position[b] = lo[b] + (hi[b] - lo[b]) * (i / n + 0.5) / n;
            points.push_back(p);
        }
    return points;
}

TEST(ReferenceTest, BoxFacesUnderASlabShadowOnlyByTheSlab) {
    const dvec3 lo(-1, -0.7, 0), hi(1.3, 0.9, 2), slabLo(-0.5, -3, 3), slabHi(3, 0.4, 3.1);
    const dvec3 eye(6, -8, 2.2);
    const Tracer tracer(sceneOf({boxMesh(lo, hi), boxMesh(slabLo, slabHi)}));
    const Patch patch = patchOf(facePoints(lo, hi, 40), 40, eye, 1e-6);
    size_t lit = 0, shadowed = 0;
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        for (size_t i = 0; i < patch.points.size(); ++i)
            EXPECT_EQ(g.label[i] == Label::excluded, glm::dot(patch.points[i].normal, -light) <= 0.02);
        // A convex body never shadows a face that is turned to the sun.
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) {
            if (glm::dot(p.normal, -light) <= 0.02) return Expected::either;
            return boxShadow(p.position, -light, slabLo, slabHi);
        });
        lit += t.lit;
        shadowed += t.shadowed;
    }
    EXPECT_GT(lit, 20000u);
    EXPECT_GT(shadowed, 5000u);
}

/// The receiver is itself a caster, its triangles long, its points off by the depth buffer's error: no acne.
TEST(ReferenceTest, SlopedCasterDoesNotShadowItself) {
    const dvec3 normal = glm::normalize(dvec3(0.21, -0.13, 1)), u = glm::normalize(glm::cross(normal, dvec3(0, 1, 0))), v = glm::cross(normal, u);
    for (const double size : {1.0, 30.0, 3000.0})
        for (const dvec3& offset : {dvec3(0), dvec3(3000.3, -1234.5, 77.7)}) {
            const auto at = [&](double a, double b) { return offset + a * size * u + b * size * v; };
            const Tracer tracer(sceneOf({meshOf({at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)}, {0, 1, 2, 0, 2, 3})}));
            // The mesh's vertices are floats: the surface is where they are, not where the formula put them.
            const dvec3 a(vec3(at(-1, -1))), b(vec3(at(1, -1))), d(vec3(at(-1, 1)));
            const dvec3 eye = offset + 1.7 * normal;
            std::vector<Point> points;
            std::mt19937 random(5);
            const auto uniform = [&] { return double(random()) / double(std::mt19937::max()); };
            for (int i = 0; i < 64 * 64; ++i) {
                // Squared so that near points are as many as far ones; one triangle's half, whose plane is exact.
                double s = 0.5 + 0.45 * (2 * uniform() - 1) * uniform(), t = 0.5 + 0.45 * (2 * uniform() - 1) * uniform();
                if (s + t > 1) s = 1 - s, t = 1 - t;
                points.push_back({a + s * (b - a) + t * (d - a), normal});
            }
            const Patch patch = patchOf(points, 64, eye, 1e-6);
            for (const dvec3& light : suns()) {
                const Reference g = tracer.trace(patch.receivers, eye, light);
                const bool facing = glm::dot(normal, -light) > 0.021;
                if (facing) {
                    EXPECT_EQ(std::ranges::count(g.label, Label::lit), 64 * 64) << "size " << size;
                }
            }
        }
}

/// A sloped ground of triangles a metre long about `centre`, 60 m along a side, its vertices relative to `origin`.
scenegen::Scene groundAbout(const dvec3& centre, const dvec3& origin, scenegen::Mesh& ground) {
    constexpr int kCells = 60;
    std::vector<dvec3> positions;
    std::vector<uint32_t> indices;
    for (int y = 0; y <= kCells; ++y)
        for (int x = 0; x <= kCells; ++x) positions.push_back(centre - origin + dvec3(x, y, 0.1 * x - 0.05 * y) - 0.5 * kCells * dvec3(1, 1, 0.05));
    for (uint32_t y = 0; y < kCells; ++y)
        for (uint32_t x = 0; x < kCells; ++x) {
            const uint32_t a = y * (kCells + 1) + x, b = a + kCells + 1;
            indices.insert(indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    ground = meshOf(positions, indices);
    scenegen::Scene scene = sceneOf({ground});
    scene.instances[0].translation = origin;
    return scene;
}

/// A point in each triangle as its floats have it.
std::vector<Point> pointsOn(const scenegen::Mesh& mesh, const dvec3& origin) {
    std::vector<Point> points;
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]), c(mesh.positions[mesh.indices[i + 2]]);
        points.push_back({origin + (a * 0.31 + b * 0.42 + c * 0.27), glm::normalize(glm::cross(b - a, c - a))});
    }
    return points;
}

// Embree rounds a ray in the space of the prototype that it meets, however near the receiver is to the eye.
TEST(ReferenceTest, ReceiversFarFromTheirInstancesOriginDoNotShadowThemselves) {
    for (const dvec3& centre : {dvec3(90, 55, 7), dvec3(5000, -3000, 40), dvec3(-30000, 30000, 500)}) {
        scenegen::Mesh ground;
        const Tracer tracer(groundAbout(centre, dvec3(0), ground));
        const Patch patch = patchOf(pointsOn(ground, dvec3(0)), 60, centre + dvec3(0.3, -0.2, 1.8), 1e-6);
        for (const dvec3& light : suns()) {
            const Reference g = tracer.trace(patch.receivers, centre + dvec3(0.3, -0.2, 1.8), light);
            size_t wrong = 0;
            for (size_t i = 0; i < patch.points.size(); ++i) wrong += glm::dot(patch.points[i].normal, -light) > 0.021 && g.label[i] == Label::shadowed;
            EXPECT_EQ(wrong, 0u) << centre.x;
        }
    }
}

// The width of the band that no reference can decide follows from the receiver, not from where its mesh has its origin.
TEST(ReferenceTest, OriginOfAMeshDoesNotMakeReceiversAmbiguous) {
    std::vector<size_t> ambiguous;
    for (const double away : {0.0, 105.0, 1050.0}) {
        scenegen::Mesh ground;
        const dvec3 origin(away, away / 2, 0), eye(0.3, -0.2, 1.8), lo(-0.02, -0.02, -1), hi(0.02, 0.02, 1);
        scenegen::Scene scene = groundAbout(dvec3(0), origin, ground);
        scene.prototypes.push_back({"post", {boxMesh(lo, hi)}, true, false});
        scene.instances.push_back({vec3(0), 1, 0, 1});
        // Points of one triangle about the end of the post's shadow, an eighth of a millimetre apart.
        std::vector<Point> points;
        const dvec3 light = scenegen::Sun{200, 40}.direction();
        const dvec3 normal = glm::normalize(dvec3(-0.1, 0.05, 1));
        for (int i = 0; i < 160 * 160; ++i) {
            const dvec2 at(0.42 + (i % 160 - 80) * 0.125e-3, 1.157 + (i / 160 - 80) * 0.125e-3);
            points.push_back({{at, 0.1 * at.x - 0.05 * at.y}, normal});
        }
        const Patch patch = patchOf(points, 160, eye);
        const Reference g = Tracer(scene).trace(patch.receivers, eye, light);
        ambiguous.push_back(size_t(std::ranges::count(g.label, Label::ambiguous)));
        EXPECT_GT(std::ranges::count(g.label, Label::lit), 1000);
        EXPECT_GT(std::ranges::count(g.label, Label::shadowed), 1000);
    }
    EXPECT_GT(ambiguous[0], 50u);
    EXPECT_LT(double(ambiguous[1]), 1.3 * double(ambiguous[0]));
    EXPECT_LT(double(ambiguous[2]), 1.3 * double(ambiguous[0]));
}

TEST(ReferenceTest, ContactShadowOfFiveMillimetresIsKept) {
    const dvec3 lo(-0.02, -0.02, 0), hi(0.02, 0.02, 0.005), eye(0.5, -2.5, 1.6);
    scenegen::Scene scene = sceneOf({boxMesh(lo, hi), meshOf({{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {0, 1, 2, 0, 2, 3})});
    const Tracer tracer(scene);
    const Patch patch = patchOf(planeGrid(120, 0.03), 120, eye, 1e-6);
    for (const double elevation : {60.0, 30.0}) {
        const dvec3 light = scenegen::Sun{200, elevation}.direction();
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) { return boxShadow(p.position, -light, lo, hi, 4e-4); });
        EXPECT_GT(t.shadowed, 5500u);
        EXPECT_LT(t.either, 1000u);
    }
}

TEST(ReferenceTest, InstancesWithYawAndScale) {
    const dvec3 lo(-0.5, -0.2, 0), hi(0.7, 0.3, 1.5), eye(1.5, -8, 2.2);
    scenegen::Scene scene = sceneOf({boxMesh(lo, hi)});
    scene.instances = {{{-3, 1, 0}, 1.3f, 0.7f, 0}, {{2, 2, 0.5f}, 0.6f, -2.1f, 0}, {{1, -3, 0}, 2.2f, 4.0f, 0}};
    scene.prototypes.push_back({"ground", {meshOf({{-9, -9, 1}, {9, -9, 1}, {0, 9, 1}}, {0, 1, 2})}, false, false});
    scene.instances.push_back({{0, 0, 0}, 1, 0, 1});  // a receiver only, above the points: it must not shadow
    const Tracer tracer(scene);
    const Patch patch = patchOf(planeGrid(160, 8), 160, eye);
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) {
            Expected all = Expected::lit;
            for (size_t i = 0; i < 3; ++i) {
                const scenegen::Instance& instance = scene.instances[i];
                const double c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw));
                const auto turn = [&](const dvec3& q) { return dvec3(c * q.x + s * q.y, -s * q.x + c * q.y, q.z); };
                const dvec3 q = turn(p.position - dvec3(instance.translation)) / double(instance.scale);
                const Expected e = boxShadow(q, turn(-light), lo, hi, kBand / instance.scale);
                if (e == Expected::shadowed) return e;
                if (e == Expected::either) all = e;
            }
            return all;
        });
        EXPECT_GT(t.shadowed, 400u);  // footprints alone: 0.6 m² · (1.3² + 0.6² + 2.2²) at 100 points per m²
        EXPECT_GT(t.lit, 3000u);
        EXPECT_LT(t.either, 400u);
    }
}

TEST(ReferenceTest, AlphaTestedCardBlocksWhereItsTexelsDo) {
    // 8 × 4 texels without symmetry; 127 and 128 stand on either side of the cutoff.
    constexpr int kWidth = 8, kHeight = 4;
    constexpr double kHalf = 2, kZ = 1.5, kRepeat = 1.75, kShift = -0.4;
    scenegen::Scene scene = sceneOf({meshOf({{-kHalf, -kHalf, kZ}, {kHalf, -kHalf, kZ}, {kHalf, kHalf, kZ}, {-kHalf, kHalf, kZ}}, {0, 1, 2, 0, 2, 3})});
    scenegen::Texture texture{"checker", {kWidth, kHeight, 4, {}}};
    const auto opaque = [](int x, int y) { return ((x + y) % 2 == 0) != (x * 3 + y * 5 > 19); };
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) texture.image.texels.insert(texture.image.texels.end(), {200, 200, 200, uint8_t(opaque(x, y) ? 128 : 127)});
    scene.textures = {texture};
    scene.materials[0].texture = 0;
    scene.materials[0].alphaTested = true;
    const auto uvAt = [&](double x, double y) { return dvec2((x + kHalf) / (2 * kHalf), (kHalf - y) / (2 * kHalf)) * kRepeat + kShift; };
    for (const vec3& p : scene.prototypes[0].meshes[0].positions) scene.prototypes[0].meshes[0].uvs.emplace_back(uvAt(p.x, p.y));

    const dvec3 eye(1.5, -8, 2.2);
    const Tracer tracer(scene);
    const Patch patch = patchOf(planeGrid(200, 5), 200, eye);
    for (const dvec3& light : suns()) {
        const Reference g = tracer.trace(patch.receivers, eye, light);
        const Tally t = expectLabels(g, patch.points, [&](const Point& p) {
            const dvec3 hit = p.position + light * (kZ / light.z);
            const double band = kBand / -light.z;
            const double inside = kHalf - std::max(std::abs(hit.x), std::abs(hit.y));
            if (inside < -band) return Expected::lit;
            const dvec2 texel = uvAt(hit.x, hit.y) * dvec2(kWidth, kHeight), cell = glm::floor(texel), rest = texel - cell;
            const double border = band * kRepeat * kWidth / (2 * kHalf);
            if (inside < band || glm::any(glm::lessThan(rest, dvec2(border))) || glm::any(glm::greaterThan(rest, dvec2(1 - border)))) return Expected::either;
            const auto wrap = [](double i, int n) { return ((int(i) % n) + n) % n; };
            return opaque(wrap(cell.x, kWidth), wrap(cell.y, kHeight)) ? Expected::shadowed : Expected::lit;
        });
        if (-light.z > 0.4) {
            EXPECT_GT(t.shadowed, 1500u);
        }
        EXPECT_GT(t.lit, 3000u);
        EXPECT_LT(t.either, 2000u);
    }

    // The same card without the alpha test blocks everywhere: the texture alone must not matter.
    scene.materials[0].alphaTested = false;
    const dvec3 down(0, 0, -1);
    expectLabels(Tracer(scene).trace(patch.receivers, eye, down), patch.points, [&](const Point& p) {
        const double inside = kHalf - std::max(std::abs(p.position.x), std::abs(p.position.y));
        return std::abs(inside) < kBand ? Expected::either : inside > 0 ? Expected::shadowed : Expected::lit;
    });
}

TEST(ReferenceTest, FarOriginAndFarEyeGiveTheSameLabels) {
    const dvec3 eye(1.5, -8, 2.25), shift(131072, -65536, 4096);  // exact in float beside the instances' places
    scenegen::Scene scene = sceneOf({boxMesh({-1, -0.7, 0}, {1.3, 0.9, 2}), sphereMesh({2, 2, 1}, 0.8, 24, 48)});
    scene.instances = {{{-2, 1, 0}, 1.25f, 0.7f, 0}, {{2, -1, 0}, 0.5f, 2.1f, 0}};
    const Patch patch = patchOf(planeGrid(160, 8), 160, eye, 1e-6);
    const dvec3 light = scenegen::Sun{200, 30}.direction();
    const Reference here = Tracer(scene).trace(patch.receivers, eye, light);
    EXPECT_GT(std::ranges::count(here.label, Label::shadowed), 500);

    scenegen::Scene far = scene;
    far.origin = dvec3(1e6, -1e6, 1e3);
    EXPECT_EQ(Tracer(far).trace(patch.receivers, eye, light).label, here.label);

    scenegen::Scene wide = scene;
    for (scenegen::Instance& instance : wide.instances) instance.translation += vec3(shift);
    EXPECT_EQ(Tracer(wide).trace(patch.receivers, eye + shift, light).label, here.label);
}

TEST(ReferenceTest, RepeatsBitForBitAndAfterAMove) {
    const dvec3 eye(1.5, -8, 2.2), light = scenegen::Sun{77, 30}.direction();
    Tracer tracer(sceneOf({sphereMesh({0, 0, 1}, 0.8, 24, 48)}));
    const Patch patch = patchOf(planeGrid(101, 8), 101, eye);  // not a multiple of the tracer's blocks
    const Reference first = tracer.trace(patch.receivers, eye, light);
    const Tracer moved = std::move(tracer);
    EXPECT_EQ(moved.trace(patch.receivers, eye, light).label, first.label);
}

TEST(ReferenceTest, SunAtTheHorizonAndBelow) {
    const dvec3 lo(-1, -0.7, 0), hi(1.3, 0.9, 2), eye(1.5, -8, 2.2);
    const Tracer tracer(sceneOf({boxMesh(lo, hi)}));
    Patch plane = patchOf(planeGrid(64, 8), 64, eye), wall = plane;
    for (vec3& n : wall.receivers.normal) n = vec3(0, -1, 0);
    for (const double elevation : {0.0, -1.0, -90.0}) {
        const dvec3 light = scenegen::Sun{180, elevation}.direction();
        EXPECT_EQ(std::ranges::count(tracer.trace(plane.receivers, eye, light).label, Label::excluded), 64 * 64);
        const Label expected = elevation > -90 ? Label::shadowed : Label::excluded;
        EXPECT_EQ(std::ranges::count(tracer.trace(wall.receivers, eye, light).label, expected), 64 * 64);
    }
    // At 1° the plane is grazed (sin 1° < 0.02), a wall is not.
    const dvec3 low = scenegen::Sun{180, 1}.direction();
    EXPECT_EQ(std::ranges::count(tracer.trace(plane.receivers, eye, low).label, Label::excluded), 64 * 64);
    const Tally t = expectLabels(tracer.trace(wall.receivers, eye, low), wall.points, [&](const Point& p) {
        return boxShadow(p.position, -low, lo, hi);
    });
    EXPECT_GT(t.lit, 2000u);
    EXPECT_GT(t.shadowed, 200u);
}

TEST(ReferenceTest, NoCastersNoReceiversAndBrokenReceivers) {
    const dvec3 eye(1.5, -8, 2.2), light = scenegen::Sun{200, 30}.direction();
    scenegen::Scene scene = sceneOf({boxMesh({-1, -1, 0}, {1, 1, 2})});
    Patch patch = patchOf(planeGrid(32, 8), 32, eye);

    scenegen::Scene receiversOnly = scene, noInstances = scene, emptyMesh = sceneOf({{}});
    receiversOnly.prototypes[0].castsShadow = false;
    noInstances.instances.clear();
    for (const scenegen::Scene& s : {receiversOnly, noInstances, emptyMesh, sceneOf({})})
        EXPECT_EQ(std::ranges::count(Tracer(s).trace(patch.receivers, eye, light).label, Label::lit), 32 * 32);

    const Tracer tracer(scene);
    EXPECT_TRUE(tracer.trace(Receivers{}, eye, light).label.empty());
    const Reference all = tracer.trace(patch.receivers, eye, light);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    patch.receivers.present[3] = 0;
    patch.receivers.position[40].x = nan;
    patch.receivers.normal[77] = vec3(nan);
    patch.receivers.normal[90] = vec3(0);
    Reference some = tracer.trace(patch.receivers, eye, light);
    for (const size_t i : {3u, 40u, 77u, 90u}) {
        EXPECT_EQ(some.label[i], Label::excluded);
        some.label[i] = all.label[i];
    }
    EXPECT_EQ(some.label, all.label);
}

TEST(ReferenceTest, DegenerateTrianglesChangeNothing) {
    const dvec3 eye(1.5, -8, 2.2), light = scenegen::Sun{200, 30}.direction();
    scenegen::Mesh mesh = boxMesh({-1, -1, 0}, {1, 1, 2});
    const Patch patch = patchOf(planeGrid(100, 8), 100, eye);
    const Reference clean = Tracer(sceneOf({mesh})).trace(patch.receivers, eye, light);
    for (uint32_t i = 0; i < 10000; ++i) mesh.indices.insert(mesh.indices.end(), {i % 8, i % 8, (i + 1) % 8});
    EXPECT_EQ(Tracer(sceneOf({mesh})).trace(patch.receivers, eye, light).label, clean.label);
}

}  // namespace
}  // namespace dapple::truth::test
