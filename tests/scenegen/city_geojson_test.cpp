#include "base/error.h"
#include "base/file.h"
#include "scenegen/city/footprints.h"
#include "scenegen/city/rings.h"
#include "scenegen/city/tidy.h"
#include "scenegen/library.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <string>

using namespace dapple::scenegen;
using namespace dapple::scenegen::city;
using testing::HasSubstr;

namespace {

std::string ringText(const Ring& ring) {
    std::string text;
    for (size_t i = 0; i <= ring.size(); ++i)
        text += fmt::format("{}[{},{}]", i ? "," : "[", ring[i % ring.size()].x, ring[i % ring.size()].y);
    return text + "]";
}

std::string polygon(const std::vector<Ring>& rings) {
    std::string text;
    for (const Ring& ring : rings) text += (text.empty() ? "" : ",") + ringText(ring);
    return "{\"type\":\"Polygon\",\"coordinates\":[" + text + "]}";
}

std::string feature(const std::string& geometry, const std::string& properties = "") {
    return "{\"type\":\"Feature\",\"properties\":{" + properties + "},\"geometry\":" + geometry + "}";
}

std::string collection(const std::string& features, const std::string& crs = "") {
    return "{\"type\":\"FeatureCollection\"," + (crs.empty() ? "" : "\"crs\":" + crs + ",") + "\"features\":[" + features + "]}";
}

std::string named(const std::string& crs) { return "{\"type\":\"name\",\"properties\":{\"name\":\"" + crs + "\"}}"; }

Ring square(double x, double y, double size) { return {{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}}; }

Ring reversed(const Ring& ring) { return {ring.rbegin(), ring.rend()}; }

double area(const Footprint& footprint) {
    double twice = 0;
    for (const Ring& ring : footprint.rings) twice += twiceArea(ring);
    return 0.5 * twice;
}

/// Square metres of roofs of the scene: triangles that face straight up, without the ground's.
double roofs(const Scene& scene) {
    double sum = 0;
    for (const Instance& instance : scene.instances)
        for (const Mesh& mesh : scene.prototypes[instance.prototype].meshes)
            for (size_t i = 0; i < mesh.indices.size(); i += 3) {
                const glm::dvec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]];
                const glm::dvec3 c = mesh.positions[mesh.indices[i + 2]], n = glm::cross(b - a, c - a);
                if (scene.prototypes[instance.prototype].castsShadow && n.z > 0 && a.z > 1) sum += 0.5 * n.z;
            }
    return sum;
}

Scene sceneOf(const std::string& text, const std::string& extension = ".geojson",
              const std::vector<std::string>& settings = {"city.projected=true"}) {
    const std::filesystem::path folder = testing::TempDir(), file = folder / fmt::format("geo-{}{}", getpid(), extension);
    dapple::base::writeFile(file, text);
    return loadScene(file.string(), settings);
}

std::string errorOf(const std::string& text, bool projected = true) {
    try {
        parseFootprints(text, "town.geojson", projected);
    } catch (const dapple::base::UsageError& e) {
        EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
        return e.what();
    }
    return "no error";
}

Footprints parse(const std::string& features, const std::string& crs = "", bool projected = true) {
    return parseFootprints(collection(features, crs), "x", projected);
}

/// A line for each note.
std::string notesOf(const Footprints& footprints) { return fmt::format("{}", fmt::join(footprints.notes.lines(), "\n")); }

glm::dvec2 sizeOf(const Footprint& footprint) {
    glm::dvec2 lo(1e300), hi(-1e300);
    for (const glm::dvec2& p : footprint.rings[0]) lo = glm::min(lo, p), hi = glm::max(hi, p);
    return hi - lo;
}

}  // namespace

TEST(GeoJson, lengthsWithUnitsSignsAndCommas) {
    const std::vector<std::pair<std::string, double>> lengths = {
        {"20", 20},         {" 20", 20},       {"20 m", 20},           {"20,5", 20.5},      {"20.5m", 20.5},     {"+7", 7},
        {"~ 12 m", 12},     {"≈9", 9},         {"66 ft", 20.1168},     {"66'", 20.1168},    {"66′", 20.1168},    {"66 feet", 20.1168},
        {"65'7\"", 19.9898}, {"65' 7\"", 19.9898}, {"65 ft 7 in", 19.9898}, {"65'7", 19.9898}, {"5,5 Meter", 5.5}, {"300 cm", 3},
        {"12\u00a0m", 12},  {"-3", -3},        {"0.02 km", 20},        {"ca. 8 m", 8}};
    for (const auto& [text, metres] : lengths) {
        const std::optional<double> got = parseLength(text);
        ASSERT_TRUE(got) << text;
        EXPECT_NEAR(*got, metres, 1e-4) << text;
    }
    for (const char* text : {"", "m", "tall", "10;12", "10-12", "1,234.5", "1.2.3", "12 parsecs", "6'7'", "7\" 6'", "nan",
                             "inf", "1e3", "20 m high"})
        EXPECT_FALSE(parseLength(text)) << text;
}

TEST(GeoJson, heightsThatAreNotUnderstoodAreCounted) {
    const Footprints f = parse(feature(polygon({square(0, 0, 5)}), "\"height\":\"high\",\"building:levels\":2") + "," +
                               feature(polygon({square(10, 0, 5)}), "\"height\":\"10;12\"") + "," +
                               feature(polygon({square(20, 0, 5)}), "\"height\":9999") + "," +
                               feature(polygon({square(30, 0, 5)}), "\"levels\":\"3 m\"") + "," +
                               feature(polygon({square(40, 0, 5)}), "\"height\":0,\"roof:shape\":\"gabled\""));
    ASSERT_EQ(f.buildings.size(), 5u);
    EXPECT_DOUBLE_EQ(f.buildings[0].height, 2 * kStorey);
    EXPECT_EQ(f.withoutHeight, 4u);
    EXPECT_EQ(f.notes.entries().size(), 3u);
    EXPECT_THAT(notesOf(f), HasSubstr("values of height that are no height are ignored (3 times"));
    EXPECT_THAT(notesOf(f), HasSubstr("values of levels that are no number of storeys"));
    EXPECT_THAT(notesOf(f), HasSubstr("roofs are flat"));
}

TEST(GeoJson, buildingsFloatAtTheirBase) {
    const std::string levels = "\"building:levels\":\"6\",\"building:min_level\":\"3\"";
    const Footprints f = parse(feature(polygon({square(0, 0, 10)}), "\"height\":20,\"min_height\":\"12 m\"") + "," +
                               feature(polygon({square(20, 0, 10)}), levels) + "," +
                               feature(polygon({square(40, 0, 10)}), "\"min_height\":15,\"height\":10") + "," +
                               feature(polygon({square(60, 0, 10)}), "\"render_min_height\":4"));
    ASSERT_EQ(f.buildings.size(), 4u);
    const double expected[4][2] = {{12, 20}, {9.6, 19.2}, {0, 10}, {4, 4 + kUsualHeight}};
    for (size_t i = 0; i < 4; ++i) {
        EXPECT_DOUBLE_EQ(f.buildings[i].base, expected[i][0]);
        EXPECT_DOUBLE_EQ(f.buildings[i].height, expected[i][1]);
    }
    EXPECT_EQ(f.notes.entries().size(), 1u);
    EXPECT_THAT(notesOf(f), HasSubstr("base is not below"));
    float lowest = 1e9f;
    for (const glm::vec3& p : footprintPrism(f.buildings[0], 0.002).positions) lowest = std::min(lowest, p.z);
    EXPECT_EQ(lowest, 12);
}

TEST(GeoJson, partsStandInPlaceOfTheirOutline) {
    const std::string outline = feature(polygon({square(0, 0, 30)}), "\"building\":\"yes\",\"height\":60");
    const std::string podium = feature(polygon({square(0, 0, 30)}), "\"building:part\":\"yes\",\"height\":9");
    const std::string tower = feature(polygon({square(10, 10, 10)}), "\"building:part\":\"yes\",\"height\":60");
    const std::string neighbour = feature(polygon({square(40, 0, 10)}), "\"building\":\"yes\",\"height\":10");
    const Footprints f = parse(outline + "," + podium + "," + tower + "," + neighbour);
    ASSERT_EQ(f.buildings.size(), 3u);
    double volume = 0;
    for (const Footprint& b : f.buildings) volume += area(b) * b.height;
    EXPECT_NEAR(volume, 900 * 9 + 100 * 60 + 100 * 10, 1e-6);
    EXPECT_EQ(notesOf(f), "");
    // In whatever order they come; building:part=no is a building.
    EXPECT_EQ(parse(tower + "," + neighbour + "," + podium + "," + outline).buildings.size(), 3u);
    const std::string noPart = feature(polygon({square(2, 2, 5)}), "\"building:part\":\"no\"");
    EXPECT_EQ(parse(outline + "," + noPart).buildings.size(), 2u);
    EXPECT_THAT(notesOf(parse(outline + "," + tower)), HasSubstr("cover less than half"));
}

TEST(GeoJson, everyRootIsReadAndTheRestCounted) {
    const std::string house = feature(polygon({square(0, 0, 10)}), "\"height\":20");
    const std::string second = feature(polygon({square(0, 40, 10)}));
    const std::string mixed = feature("{\"type\":\"GeometryCollection\",\"geometries\":[" + polygon({square(20, 0, 10)}) +
                                      ",{\"type\":\"Point\",\"coordinates\":[5,45]}]}");
    const std::string multi = "{\"type\":\"MultiPolygon\",\"coordinates\":[[" + ringText(square(0, 0, 9)) + "],[" +
                              ringText(square(20, 0, 9)) + "]]}";
    const std::vector<std::pair<std::string, size_t>> files = {
        {house, 1}, {polygon({square(0, 0, 10)}), 1}, {multi, 2}, {collection(house + "," + mixed), 2},
        {house + "\n" + second + "\n", 2},                  // GeoJSON lines
        {house + "\r\n\r\n" + second, 2},
        {"\x1e" + house + "\n\x1e" + second + "\n", 2},     // RFC 8142
        {"\xef\xbb\xbf" + collection(house), 1},
        {collection(feature(polygon({square(0, 0, 10)}), "\"name\":\"Stra\xdf" "e\"")), 1},
        {collection(house + ",{\"type\":\"Feature\",\"geometry\":null},7"), 1}};
    const auto notes = [&](size_t i) { return notesOf(parseFootprints(files[i].first, "x", true)); };
    for (const auto& [text, buildings] : files)
        EXPECT_EQ(parseFootprints(text, "x", true).buildings.size(), buildings) << text;
    EXPECT_THAT(notes(3), HasSubstr("no polygons are left out: Point"));
    EXPECT_THAT(notes(8), HasSubstr("Latin-1"));
    EXPECT_THAT(notes(9), HasSubstr("features without a geometry are left out"));
    EXPECT_THAT(notes(9), HasSubstr("members of a collection that are no features"));
    EXPECT_THAT(errorOf("{\"type\":\"Topology\",\"objects\":{}}"), HasSubstr("is of type 'Topology'"));
    EXPECT_THAT(errorOf(house + "\n{\"type\":"), HasSubstr("not valid JSON"));
    EXPECT_THAT(errorOf(std::string("\xff\xfe{\0", 4)), HasSubstr("UTF-16"));
}

TEST(GeoJson, deepNestingIsOneLine) {
    for (const char* open : {"[", "{\"a\":", "{\"type\":\"GeometryCollection\",\"geometries\":["}) {
        std::string text;
        for (int i = 0; i < 200'000; ++i) text += open;
        EXPECT_THAT(errorOf(text), HasSubstr("nested deeper than 64"));
        EXPECT_THAT(errorOf(collection(feature(text))), HasSubstr("nested deeper than 64"));
    }
}

TEST(GeoJson, courtyardsThatTouchAreLeftOpen) {
    const Ring outline = square(0, 40, 30), diamond{{0, 55}, {5, 50}, {10, 55}, {5, 60}};
    const std::vector<std::pair<std::vector<Ring>, double>> cases = {
        {{outline, square(5, 45, 8)}, 836},
        {{outline, square(5, 45, 8), square(13, 53, 8)}, 772},           // two at one corner
        {{outline, diamond}, 850},                                       // the outline at a point
        {{outline, reversed(diamond)}, 850},
        {{outline, {{0, 40}, {10, 44}, {4, 50}}}, 900 - 42},              // at a corner of the outline
        {{outline, {{0, 55}, {15, 50}, {30, 55}, {15, 60}}}, 750},        // at two points: two buildings
        {{outline, {{0, 45}, {10, 45}, {10, 55}, {0, 55}}}, 800},         // along an edge
        {{outline, square(5, 45, 8), square(13, 45, 8)}, 772},           // two along an edge
        {{outline, square(25, 60, 20)}, 900},                            // crosses the outline: filled
        {{outline, square(100, 60, 20)}, 900}};                          // outside: filled
    for (auto [rings, expected] : cases)
        for (const double angle : {0.0, 0.3, 1.1}) {
            SCOPED_TRACE(testing::Message() << expected << " m², turned by " << angle);
            for (Ring& ring : rings)
                for (glm::dvec2& p : ring)
                    p = {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y};
            const Scene scene = sceneOf(collection(feature(polygon(rings), "\"height\":20")));
            EXPECT_TRUE(scene.facts().closed);
            EXPECT_NEAR(roofs(scene), expected, 0.6) << "less joints of 2 mm";
        }
    EXPECT_THAT(notesOf(parse(feature(polygon(cases[8].first)))), HasSubstr("courtyards that cross"));
}

TEST(GeoJson, outlinesKeepTheirAreaWhateverTheirCorners) {
    // A round one of 50,000 corners, a star of 8,000 with courtyards: the time of both is bounded, too.
    Ring round, star;
    const auto turned = [](double radius, double turns) {
        return radius * glm::dvec2(std::cos(2 * M_PI * turns), std::sin(2 * M_PI * turns));
    };
    for (int i = 0; i < 50'000; ++i) round.push_back(turned(100, i / 50'000.0));
    for (int i = 0; i < 8'000; ++i) star.push_back(turned(i % 2 ? 60 : 100, i / 8'000.0));
    std::vector<Ring> pierced{star};
    for (int i = -3; i < 3; ++i) pierced.push_back(square(12 * i, 12 * i, 9));
    const double starArea = 0.5 * twiceArea(star) - 6 * 81;
    const std::clock_t start = std::clock();
    EXPECT_NEAR(area(parse(feature(polygon({round}))).buildings.at(0)), 0.5 * twiceArea(round), 1);
    const Footprints f = parse(feature(polygon(pierced)));
    EXPECT_NEAR(area(f.buildings.at(0)), starArea, 1);
    EXPECT_FALSE(footprintPrism(f.buildings[0], 0.002).indices.empty());
    EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 5) << "seconds of processor time";
}

TEST(GeoJson, theFilesReferenceSystemIsObeyed) {
    // A house of 10 m at 48.2 degrees, in four systems.
    constexpr double kRadius = 6378137, kLatitude = 48.2;
    const double stretch = 1 / std::cos(kLatitude * M_PI / 180);
    const double x = kRadius * 16.37 * M_PI / 180, y = kRadius * std::asinh(std::tan(kLatitude * M_PI / 180));
    const Ring mercator = square(x, y, 10 * stretch);
    for (const char* name : {"urn:ogc:def:crs:EPSG::3857", "EPSG:900913", "http://www.opengis.net/def/crs/EPSG/0/3857"})
        for (const bool projected : {false, true}) {
            const Footprints f = parse(feature(polygon({mercator})), named(name), projected);
            EXPECT_NEAR(sizeOf(f.buildings.at(0)).x, 10, 0.001);
            EXPECT_NEAR(sizeOf(f.buildings.at(0)).y, 10, 0.001);
        }
    const double north = 10 / (kRadius * M_PI / 180), east = north * stretch;
    const Ring degrees{{16.37, 48.2}, {16.37 + east, 48.2}, {16.37 + east, 48.2 + north}, {16.37, 48.2 + north}};
    for (const char* name : {"urn:ogc:def:crs:OGC:1.3:CRS84", "EPSG:4326", "urn:ogc:def:crs:EPSG::4258"})
        EXPECT_NEAR(sizeOf(parse(feature(polygon({degrees})), named(name)).buildings.at(0)).x, 10, 0.001);
    const std::string utm = feature(polygon({square(602'000, 5'340'000, 10)}));
    EXPECT_NEAR(sizeOf(parse(utm, named("urn:ogc:def:crs:EPSG::32633"), false).buildings.at(0)).x, 10, 1e-6);
    const std::string unknown = collection(feature(polygon({square(0, 340'000, 10)})), named("EPSG:31256"));
    EXPECT_THAT(errorOf(unknown, false), HasSubstr("EPSG:31256, is not read"));
    EXPECT_EQ(errorOf(unknown, true), "no error") << "the user says that its unit is the metre";
    const std::string link = "{\"type\":\"link\",\"properties\":{\"href\":\"http://x/y\"}}";
    EXPECT_THAT(errorOf(collection(feature(polygon({square(0, 0, 10)})), link), false), HasSubstr("http://x/y"));
}

TEST(GeoJson, aTownOnThe180thMeridianIsOneTown) {
    const double s = 10 / 111'319.4908;
    const auto house = [&](double longitude) { return feature(polygon({square(longitude, 10, s)})); };
    for (const auto& [a, b] : {std::pair(179.9999, -179.9999), {-179.9999, 179.9999}, {179.9999, 180.0005}}) {
        const Footprints f = parse(house(a) + "," + house(b), "", false);
        ASSERT_EQ(f.buildings.size(), 2u);
        EXPECT_LT(glm::distance(f.buildings[0].rings[0][0], f.buildings[1].rings[0][0]), 100);
    }
}

TEST(GeoJson, aFileIsASceneByItself) {
    const std::string house = feature(polygon({square(0, 0, 10)}), "\"height\":20");
    for (const char* extension : {".geojson", ".geojsonl", ".geojsons", ".json", ".GeoJSON"}) {
        const Scene scene = sceneOf(house, extension);
        EXPECT_EQ(scene.facts().triangles, 24u);
        EXPECT_NEAR(roofs(scene), 100, 0.1);
    }
    EXPECT_NEAR(sceneOf(house, ".geojson", {"city.projected=true", "sun.elevation=12.5"}).sun.elevation, 12.5, 0);
    const Scene noted = sceneOf(collection(house + ",{\"type\":\"Feature\",\"geometry\":null}"));
    ASSERT_EQ(noted.notes.size(), 1u);
    EXPECT_THAT(noted.notes[0], HasSubstr("without a geometry"));
}
