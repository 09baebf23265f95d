#include "scenegen/import/polygons.h"

#include "scenegen/files.h"

#include <chrono>
#include <random>

// Oracles: areas by hand, and Gauss's formula for the polygon.
namespace dapple::scenegen {
namespace {

using Polygon = std::vector<glm::dvec3>;

struct Cut {
    bool whole;
    double area = 0;    ///< of all triangles
    glm::dvec3 sum{0};  ///< of their area vectors: shorter than `area` where one is turned round
    size_t triangles = 0;
};

Cut cut(const Polygon& polygon) {
    std::vector<std::array<uint32_t, 3>> triangles;
    Cut result{cutPolygon(polygon, triangles)};
    for (const auto& t : triangles) {
        for (const uint32_t k : t) EXPECT_LT(k, polygon.size());
        const glm::dvec3 n = glm::cross(polygon[t[1]] - polygon[t[0]], polygon[t[2]] - polygon[t[0]]) / 2.0;
        result.sum += n;
        result.area += glm::length(n);
    }
    result.triangles = triangles.size();
    return result;
}

/// In the plane z = 3, turned so that no axis is spared, from every corner on, and both ways round.
void expectArea(const std::vector<glm::dvec2>& shape, double area) {
    for (const glm::dvec3 axis : {glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0), glm::dvec3(1, 2, 3)})
        for (size_t first = 0; first < shape.size(); ++first)
            for (const bool reversed : {false, true}) {
                Polygon polygon;
                for (size_t k = 0; k < shape.size(); ++k) {
                    const glm::dvec2 p = shape[(first + (reversed ? shape.size() - k : k)) % shape.size()];
                    polygon.push_back(
                        glm::dvec3(glm::rotate(glm::dmat4(1), 1.0, glm::normalize(axis)) * glm::dvec4(p, 3, 1)));
                }
                const Cut c = cut(polygon);
                EXPECT_TRUE(c.whole) << first << reversed;
                EXPECT_NEAR(c.area, area, 1e-9 * area) << first << reversed;
                EXPECT_NEAR(glm::length(c.sum), area, 1e-9 * area) << first << reversed;
            }
}

TEST(Polygons, concaveOnesKeepTheirAreaWhicheverCornerComesFirst) {
    expectArea({{-4, -4}, {-4, 4}, {0, 4}, {0, 0}, {4, 0}, {4, -4}}, 48);                        // L
    expectArea({{-4, -4}, {4, -4}, {4, -2}, {1, -2}, {1, 4}, {-1, 4}, {-1, -2}, {-4, -2}}, 28);  // T
    expectArea({{-4, -4}, {4, -4}, {4, 4}, {2, 4}, {2, -2}, {-2, -2}, {-2, 4}, {-4, 4}}, 40);    // U
    expectArea({{0, 0}, {4, 0}, {1, 1}, {0, 4}}, 4);                                  // a quad that is an arrow
    expectArea({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}, 4);  // corners on its edges
}

TEST(Polygons, holesThatAnEdgeJoinsToTheRimStayOpen) {
    expectArea(
        {{-5, -5}, {-5, 5}, {5, 5}, {5, -5}, {0, -5}, {0, -2}, {2, -2}, {2, 2}, {-2, 2}, {-2, -2}, {0, -2}, {0, -5}},
        84);
    // Two holes, the second joined to the first.
    expectArea({{0, 0},
                {9, 0},
                {9, 9},
                {0, 9},
                {0, 4},
                {1, 4},
                {1, 5},
                {2, 5},
                {3, 4},
                {4, 5},
                {5, 4},
                {4, 3},
                {3, 4},
                {2, 5},
                {2, 4},
                {1, 4},
                {0, 4}},
               78);
}

TEST(Polygons, repeatedCornersAndSpikesAddNothing) {
    expectArea({{0, 0}, {4, 0}, {4, 0}, {4, 4}, {2, 4}, {2, 7}, {2, 4}, {0, 4}, {0, 0}}, 16);
    expectArea({{0, 0}, {4, 0}, {4, 4}, {4, 6}, {4, 8}, {4, 4}, {0, 4}}, 16);
}

TEST(Polygons, oddOnesNeverCrashAndSayThatTheyAreFans) {
    EXPECT_FALSE(cut({{0, 0, 0}, {3, 2, 0}, {3, 0, 0}, {0, 1, 0}}).whole) << "a bow tie of unequal wings";
    EXPECT_FALSE(cut({{0, 0, 0}, {5, 0, 0}, {5, 5, 0}, {2, -3, 0}, {0, 5, 0}}).whole);
    EXPECT_EQ(cut({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}).area, 0);
    EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}}).area, 0);
    EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}}).triangles, 0u);
    EXPECT_EQ(cut({}).triangles, 0u);
    std::mt19937 random(1);
    std::uniform_int_distribution<int> coordinate(-3, 3), corners(3, 12);
    for (int i = 0; i < 20000; ++i) {
        Polygon polygon(size_t(corners(random)));
        for (glm::dvec3& p : polygon) p = {coordinate(random), coordinate(random), i % 3 == 0 ? coordinate(random) : 0};
        const Cut c = cut(polygon);
        if (!c.whole) {
            EXPECT_EQ(c.triangles, polygon.size() - 2);
        }
        // What is cut whole is covered once, as seen from above.
        if (c.whole && i % 3 != 0) {
            double gauss = 0;
            for (size_t k = 0; k < polygon.size(); ++k) {
                const glm::dvec3 a = polygon[k], b = polygon[(k + 1) % polygon.size()];
                gauss += (a.x * b.y - a.y * b.x) / 2;
            }
            if (gauss != 0) {
                EXPECT_NEAR(c.area, std::abs(gauss), 1e-9) << i;
            }
        }
    }
}

TEST(Polygons, slightlyBentOnesAreCutAsSeenAlongTheirNormal) {
    const Cut c = cut({{0, 0, 0}, {4, 0, 0.01}, {4, 1, 0}, {1, 1, 0.01}, {1, 4, 0}, {0, 4, 0.01}});
    EXPECT_TRUE(c.whole);
    EXPECT_NEAR(c.area, 7, 1e-2);
}

using PolygonFiles = Files;

// 48 m² of roof and 1,600 m² of ground; not only OBJ has polygons.
TEST_F(PolygonFiles, objAndPlyAndOffRoofs) {
    const double whole = 1600 + 48;
    EXPECT_NEAR(area(importFile(write("l.obj",
                                      "v -20 0 -20\nv 20 0 -20\nv 20 0 20\nv -20 0 20\nf 4 3 2 1\no roof\nv -4 3 -4\nv "
                                      "-4 3 4\nv 0 3 4\nv 0 3 0\nv 4 3 0\n"
                                      "v 4 3 -4\nf 5 6 7 8 9 10\n"))),
                whole, 1e-3);
    const std::string points = "-20 -20 0\n20 -20 0\n20 20 0\n-20 20 0\n-4 -4 3\n-4 4 3\n0 4 3\n0 0 3\n4 0 3\n4 -4 3\n",
                      faces = "4 0 1 2 3\n6 4 5 6 7 8 9\n";
    EXPECT_NEAR(area(importFile(write(
                    "l.ply",
                    "ply\nformat ascii 1.0\nelement vertex 10\nproperty float x\nproperty float y\nproperty float z\n"
                    "element face 2\nproperty list uchar int vertex_indices\nend_header\n" +
                        points + faces))),
                whole, 1e-3);
    EXPECT_NEAR(area(importFile(write("l.off", "OFF\n10 2 0\n" + points + faces))), whole, 1e-3);
}

TEST_F(PolygonFiles, manyTrianglesRoundACornerTakeNoTimeOfTheirSquare) {
    // A flat fan and the side of a cone, each of 40,000 triangles at one vertex: their pairs would take a minute.
    constexpr int kCount = 40000;
    write("fan.toml", "[[view]]\nname = \"v\"\neye = [0, -9, 9]\ntarget = [0, 0, 0]\n");
    for (const double height : {0.0, 0.5, 4.0}) {
        std::string obj = fmt::format("v 0 {} 0\n", height);
        for (int i = 0; i < kCount; ++i) {
            const double a = 2 * glm::pi<double>() * i / kCount;
            obj += fmt::format("v {:.9f} 0 {:.9f}\n", 100 * std::cos(a), 100 * std::sin(a));
        }
        for (int i = 0; i < kCount; ++i) obj += fmt::format("f 1 {} {}\n", i + 2, (i + 1) % kCount + 2);
        const auto start = std::chrono::steady_clock::now();
        const Scene scene = importFile(write("fan.obj", obj));
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
        EXPECT_EQ(scene.facts().triangles, size_t(kCount));
        // The tip's normal is the mean of all faces where they are not steeper than a crease: upright.
        for (const Mesh& mesh : scene.prototypes.at(0).meshes)
            for (size_t v = 0; v < mesh.positions.size(); ++v)
                if (mesh.positions[v].x == 0 && mesh.positions[v].y == 0) {
                    EXPECT_NEAR(std::abs(mesh.normals[v].z), 1, 1e-3) << height;
                }
    }
}

TEST_F(PolygonFiles, oneThatCrossesItselfIsNoted) {
    const Scene scene = importFile(write("bow.obj", "v 0 0 0\nv 3 0 2\nv 3 0 0\nv 0 0 1\no tie\nf 1 2 3 4\n"));
    EXPECT_TRUE(hasNote(scene, "cut as fans ('tie')"));
}

}  // namespace
}  // namespace dapple::scenegen
