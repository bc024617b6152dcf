// pieprobe as a user runs it: closed forms through files, and what it says about everything that is wrong.

#include "tests/support/command.h"
#include "tests/support/cornell.h"
#include "tests/support/files.h"
#include "tests/support/room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <sstream>

namespace pie::test {
namespace {

using ::testing::HasSubstr;
constexpr double pi = std::numbers::pi;

using Row = std::map<std::string, std::string>;

std::vector<Row> rowsOf(const std::string& csv) {
    std::istringstream stream(csv);
    std::vector<std::string> names;
    std::vector<Row> rows;
    for (std::string line; std::getline(stream, line);) {
        std::vector<std::string> cells(1);
        for (const char c : line)
            if (c == ',')
                cells.emplace_back();
            else
                cells.back() += c;
        if (names.empty()) {
            names = cells;
            continue;
        }
        Row& row = rows.emplace_back();
        for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) row[names[i]] = cells[i];
    }
    return rows;
}

/// A black floor of 1,000 units under a sky at height 600.
class Pieprobe : public ::testing::Test {
protected:
    TemporaryFolder folder_;
    std::string scene_ = folder_.write("floor.obj", "mtllib floor.mtl\n"
                                                    "v -500 -500 0\nv 500 -500 0\nv 500 500 0\nv -500 500 0\n"
                                                    "v -900 -900 600\nv 900 -900 600\nv 900 900 600\nv -900 900 600\n"
                                                    "usemtl black\nf 1 2 3 4\nusemtl sky_blue\nf 5 8 7 6\n");
    std::string points_ = folder_.write("points.csv", "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n60,80,0,0,0,1\n");
    std::string out_ = (folder_.path() / "out.csv").string();

    Pieprobe() { (void)folder_.write("floor.mtl", "newmtl black\nKd 0 0 0\nnewmtl sky_blue\nKd 0 0 0\n"); }

    [[nodiscard]] CommandResult probe(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), PIEPROBE);
        return run(arguments);
    }
    /// Irradiance, second channel, of the points; checks that all went well.
    [[nodiscard]] std::vector<double> light(const std::vector<std::string>& options) const {
        std::vector<std::string> arguments{scene_, points_, out_};
        arguments.insert(arguments.end(), options.begin(), options.end());
        const CommandResult result = probe(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        std::vector<double> e;
        for (const Row& row : rowsOf(readText(out_))) {
            EXPECT_EQ(row.at("status"), "ok");
            e.push_back(std::stod(row.at("Eg")));
        }
        return e;
    }
    /// The same by both ways, each within half a per cent of what is known.
    void expectLight(const std::string& lightOption, const std::vector<double>& exact) const {
        for (const bool reference : {false, true}) {
            std::vector<std::string> options{"--light", lightOption};
            if (reference)
                options.insert(options.end(), {"--reference", "--target", "0.001"});
            else
                options.insert(options.end(), {"--frames", "1", "--set", "direct_samples=256"});
            const auto e = light(options);
            ASSERT_EQ(e.size(), exact.size());
            for (std::size_t i = 0; i < e.size(); ++i)
                EXPECT_NEAR(e[i], exact[i], 0.005 * exact[i] + 1e-9) << lightOption << ", point " << i;
        }
    }
};

TEST_F(Pieprobe, EveryLightGivesTheWattsItWasTold) {
    const auto fromAbove = [](double h, double r) { return h / std::pow(h * h + r * r, 1.5); };
    expectLight("point 0 0 100 1 1000 1", {1000 / (4 * pi) * fromAbove(100, 0), 1000 / (4 * pi) * fromAbove(100, 100)});
    expectLight("sphere 0 0 100 5 1 1000 1",
                {1000 / (4 * pi) * fromAbove(100, 0), 1000 / (4 * pi) * fromAbove(100, 100)});
    const double cone = 2 * pi * (1 - std::cos(50 * pi / 180));
    expectLight("spot 0 0 100 0 0 -1 50 1 1000 1",
                {1000 / cone * fromAbove(100, 0), 1000 / cone * fromAbove(100, 100)});
    expectLight("spot 0 0 100 0 0 -2 20 1 1000 1", {1000 / (2 * pi * (1 - std::cos(20 * pi / 180))) * 1e-4, 0});
    expectLight("sun 0 3 4 1 20 1", {16, 16});
    // A square of 20 under its middle: four rectangles.
    const double side = 0.1 / std::sqrt(1.01);
    const double share = 4 * 2 * side * std::atan(side) / (2 * pi);
    const auto middle =
        light({"--light", "area -10 10 100 10 10 100 10 -10 100 -10 -10 100 1 1000 1", "--frames", "1"});
    EXPECT_NEAR(middle[0], 1000.0 / 400 * share, 0.005 * 1000.0 / 400 * share);
    expectLight("area -10 -10 100 10 -10 100 10 10 100 1 1000 1", {0, 0}); // lights upwards
}

TEST_F(Pieprobe, LightsAddUp) {
    const auto both = light({"--light", "point 0 0 100 1 600 1", "--light", "point 0 0 100 1 400 1", "--frames", "1"});
    EXPECT_NEAR(both[0], 1000 / (4 * pi * 1e4), 1e-6);
}

TEST_F(Pieprobe, OneLineForALightThatIsNone) {
    const std::vector<std::pair<std::string, std::string>> wrong{
        {"", "no such kind"},
        {"lamp 1 2 3", "no such kind"},
        {"point 1 2 3 4 5", "has 5 numbers, not 6"},
        {"point 1 2 x 4 5 6", "number 3 is \"x\""},
        {"point 1 2 inf 4 5 6", "number 3 is \"inf\""},
        {"point 1 2 3 4 -5 6", "number 5 is negative"},
        {"sphere 1 2 3 0 5 6 7", "radius"},
        {"spot 1 2 3 0 0 0 20 1 1 1", "direction is zero"},
        {"spot 1 2 3 0 0 1 90 1 1 1", "between 0 and 90"},
        {"sun 0 0 0 1 1 1", "direction is zero"},
        {"sun 0 0 1 1 1 1 91", "between 0 and 90"},
        {"area 0 0 0 1 0 0 1 1 1", "has 9 numbers"},
        {"area 0 0 0 1 0 0 2 0 0 1 1 1", "no area"},
        {"area 0 0 0 1 0 0 1 1 0 0 1 1 1 1 1", "not in a plane"},
        {"area 0 0 0 9 0 0 9 9 0 8 1 0 1 1 1", "go inwards"}};
    for (const auto& [light, reason] : wrong) {
        const CommandResult result = probe({scene_, points_, out_, "--light", light});
        EXPECT_EQ(result.status, 2) << light;
        EXPECT_THAT(result.err, HasSubstr(reason)) << light;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_FALSE(std::filesystem::exists(out_));
    }
}

TEST_F(Pieprobe, ColumnsInAnyOrderAreRepeatedAsTheyWere) {
    points_ = folder_.write("points.csv", "\xef\xbb\xbfnz, nx ,name,y,x,ny,z\r\n1.0,0,lamp,8e1,+60.50,0,0\r\n\r\n");
    const CommandResult result = probe({scene_, points_, out_, "--light", "point 0 0 100 1 1 1", "--frames", "1"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("\"name\" is not used"));
    EXPECT_THAT(readText(out_), ::testing::StartsWith("x,y,z,nx,ny,nz,Er,Eg,Eb,stderr,photons,radius,bias,status\n"
                                                      "+60.50,8e1,0,0,0,1.0,"));
}

TEST_F(Pieprobe, DamagedPointsNameLineAndColumn) {
    const std::vector<std::pair<std::string, std::string>> wrong{
        {"", "is empty"},
        {"1,2,3,0,0,1\n", "line 1: there is no column x"},
        {"x,y,z,nx,ny\n1,2,3,0,0\n", "line 1: there is no column nz"},
        {"x,y,z,nx,ny,nz,x\n", "line 1, column 7: a second x"},
        {"x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,0,0,0,zero,1\n", "line 3, column 5 (ny): \"zero\" is not a number"},
        {"x,y,z,nx,ny,nz\n0,0,0,0,,1\n", "line 2, column 5 (ny): \"\" is not a number"},
        {"x,y,z,nx,ny,nz\n0,0,0,0,0\n", "line 2: has 5 columns, the header 6"}};
    for (const auto& [text, reason] : wrong) {
        points_ = folder_.write("points.csv", text);
        const CommandResult result = probe({scene_, points_, out_, "--light", "point 0 0 100 1 1 1"});
        EXPECT_EQ(result.status, 1) << reason;
        EXPECT_THAT(result.err, HasSubstr(reason));
        EXPECT_FALSE(std::filesystem::exists(out_));
    }
    EXPECT_EQ(probe({scene_, "nowhere.csv", out_}).status, 1);
}

TEST_F(Pieprobe, PointsThatFitNoSurfaceAreReportedAndTheRestIsDone) {
    points_ = folder_.write("points.csv", "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,0,9,0,0,1\n0,0,0,0,0,-1\n0,0,0,0,0,0\n"
                                          "nan,0,0,0,0,1\n1e99,0,0,0,0,1\n0,0,600,0,0,-1\n0,0,0.5,0,0,7\n");
    const CommandResult result = probe({scene_, points_, out_, "--light", "point 0 0 100 1 1 1", "--frames", "1"});
    EXPECT_EQ(result.status, 3);
    for (const char* line :
         {"line 3: no surface within", "line 4: no surface there faces", "line 5: the normal is zero",
          "line 6: is not finite", "line 7: is not finite", "line 8: no surface within"})
        EXPECT_THAT(result.err, HasSubstr(line));
    std::vector<std::string> status;
    for (const Row& row : rowsOf(readText(out_))) {
        status.push_back(row.at("status"));
        EXPECT_EQ(row.at("Er").empty(), row.at("status") != "ok");
    }
    EXPECT_THAT(status, ::testing::ElementsAre("ok", "off_surface", "bad_normal", "bad_normal", "not_finite",
                                               "not_finite", "off_surface", "ok"));
    points_ = folder_.write("points.csv", "x,y,z,nx,ny,nz\n0,0,9,0,0,1\n");
    EXPECT_EQ(probe({scene_, points_, out_, "--light", "point 0 0 100 1 1 1", "--tolerance", "10"}).status, 0);
}

TEST_F(Pieprobe, WhatCannotBeWrittenLosesNothing) {
    const std::string light = "point 0 0 100 1 1 1";
    EXPECT_EQ(probe({scene_, points_, (folder_.path() / "no" / "out.csv").string(), "--light", light}).status, 1);
    EXPECT_EQ(probe({scene_, points_, folder_.path().string(), "--light", light}).status, 1);
    out_ = folder_.write("out.csv", "precious");
    EXPECT_EQ(probe({"nowhere.obj", points_, out_, "--light", light}).status, 1);
    EXPECT_EQ(readText(out_), "precious");
    EXPECT_EQ(probe({scene_, points_, out_, "--light", light, "--frames", "1"}).status, 0);
    EXPECT_THAT(readText(out_), HasSubstr("Er"));
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Pieprobe, DamagedScenesAreOneLine) {
    const std::vector<std::pair<std::string, std::string>> wrong{{"", "holds no faces"},
                                                                 {"v 0 0 0\nv 1 0 0\nf 1 2 9\n", "vertex"},
                                                                 {"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", ""}};
    for (const auto& [text, reason] : wrong) {
        const CommandResult result = probe({folder_.write("bad.obj", text), points_, out_, "--quiet"});
        EXPECT_NE(result.status, 0) << text;
        EXPECT_LT(result.status, 4) << result.err;
        EXPECT_THAT(result.err, HasSubstr(reason));
    }
    EXPECT_EQ(probe({"nowhere.obj", points_, out_}).status, 1);
    EXPECT_EQ(probe({"nowhere.bsp", points_, out_}).status, 1);
}

TEST_F(Pieprobe, WrongArgumentsAreStatus2) {
    EXPECT_EQ(probe({scene_, points_}).status, 2);
    EXPECT_EQ(probe({scene_, points_, out_, "--frames", "0"}).status, 2);
    EXPECT_EQ(probe({scene_, points_, out_, "--target", "2", "--reference"}).status, 2);
    const CommandResult setting = probe({scene_, points_, out_, "--set", "photons_from_lihgt=3"});
    EXPECT_EQ(setting.status, 2);
    EXPECT_THAT(setting.err, HasSubstr("photons_from_light"));
    EXPECT_EQ(probe({"--help"}).status, 0);
    EXPECT_THAT(probe({"--help"}).out, HasSubstr("spot x y z dx dy dz degrees r g b"));
}

TEST_F(Pieprobe, TimeIsJson) {
    const CommandResult result =
        probe({scene_, points_, out_, "--light", "point 0 0 100 1 1 1", "--frames", "2", "--time", "--threads", "1"});
    ASSERT_EQ(result.status, 0) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("points"), 2);
    EXPECT_EQ(json.at("threads"), 1);
    EXPECT_EQ(json.at("engine").at("frames_traced"), 2);
    double sum = 0;
    for (const auto& [stage, milliseconds] : json.at("milliseconds").items())
        if (stage != "total") sum += milliseconds.get<double>();
    EXPECT_NEAR(json.at("milliseconds").at("total").get<double>(), sum, 0.02);
}

TEST_F(Pieprobe, DrawsPointsEvenlyOverWhatCanBeLit) {
    const std::string drawn = (folder_.path() / "drawn.csv").string();
    ASSERT_EQ(probe({scene_, drawn, out_, "--sample", "400", "--light", "point 0 0 100 1 1 1", "--frames", "1"}).status,
              0);
    const auto rows = rowsOf(readText(drawn));
    ASSERT_EQ(rows.size(), 400U);
    int right = 0;
    for (const Row& row : rows) {
        EXPECT_EQ(std::stod(row.at("z")), 0.0); // none in the sky
        EXPECT_EQ(std::stod(row.at("nz")), 1.0);
        EXPECT_LE(std::abs(std::stod(row.at("y"))), 500.0);
        right += std::stod(row.at("x")) > 0 ? 1 : 0;
    }
    EXPECT_NEAR(right, 200, 50); // five sigma of a coin
    for (const Row& row : rowsOf(readText(out_))) EXPECT_EQ(row.at("status"), "ok");
    const std::string first = readText(drawn);
    ASSERT_EQ(probe({scene_, drawn, out_, "--sample", "400", "--light", "point 0 0 100 1 1 1", "--frames", "1",
                     "--seed", "3"})
                  .status,
              0);
    EXPECT_NE(readText(drawn), first);
    EXPECT_EQ(probe({scene_, drawn, out_, "--sample", "0"}).status, 2);
}

TEST_F(Pieprobe, SaysWhereTheTargetWasNotReached) {
    const CommandResult result = probe({scene_, points_, out_, "--light", "sphere 0 0 10 8 1 1 1", "--reference",
                                        "--target", "0.000001", "--most-paths", "4096"});
    EXPECT_EQ(result.status, 3);
    EXPECT_THAT(result.err, HasSubstr("after 4096 paths"));
    EXPECT_EQ(rowsOf(readText(out_))[0].at("status"), "target_not_reached");
    EXPECT_FALSE(rowsOf(readText(out_))[0].at("Er").empty());
}

TEST_F(Pieprobe, ThreadsChangeNothingSeedsDo) {
    scene_ = writeCornell(folder_.path()).string();
    points_ = folder_.write("points.csv", pointsCsv(cornellPoints(20)));
    const auto text = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{scene_, points_, out_, "--light", cornellLight, "--frames", "2"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        EXPECT_EQ(probe(arguments).status, 0);
        return readText(out_);
    };
    for (const std::vector<std::string>& way :
         {std::vector<std::string>{}, std::vector<std::string>{"--reference", "--target", "0.05"}}) {
        auto one = way;
        one.insert(one.end(), {"--threads", "1"});
        auto two = way;
        two.insert(two.end(), {"--threads", "2"});
        auto other = way;
        other.insert(other.end(), {"--seed", "7"});
        const std::string first = text(one);
        EXPECT_EQ(first, text(two));
        EXPECT_NE(first, text(other));
    }
}

TEST_F(Pieprobe, EdgesOfTheCornellBoxAreOnTheirWalls) {
    scene_ = writeCornell(folder_.path()).string();
    points_ = folder_.write("points.csv", pointsCsv(cornellEdgeVertices()));
    const CommandResult result = probe({scene_, points_, out_, "--light", cornellLight, "--reference", "--target",
                                        "0.2", "--set", "recursion_depth=0"});
    EXPECT_EQ(result.status, 0) << result.err;
    // Direct light alone, of a lamp in full view of most: the formula.
    const auto vertices = cornellEdgeVertices();
    const auto rows = rowsOf(readText(out_));
    int seen = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double e = std::stod(rows[i].at("Er"));
        const Vec3 to = cornellLightPosition - vertices[i].inset;
        const auto d = static_cast<double>(glm::length(to));
        const double exact = double{cornellWatts} * double{glm::dot(to, vertices[i].normal)} / (4 * pi * d * d * d);
        if (e > 0) {
            ++seen;
            EXPECT_NEAR(e / exact, 1, 0.015) << i; // the program's inset may differ by a millimetre
        }
    }
    EXPECT_GT(seen, 150);
}

TEST_F(Pieprobe, LevelsWithTheirLightsAndWithout) {
    writeGame(folder_, "room", makeRoom());
    scene_ = (folder_.path() / "maps" / "room.bsp").string();
    points_ = folder_.write("points.csv", "x,y,z,nx,ny,nz\n0,0,-256,0,0,1\n");
    const double own = 7500.0 * 300 / (384.0 * 384.0);
    EXPECT_NEAR(light({"--frames", "1", "--set", "recursion_depth=0"})[0], own, 0.005 * own);
    EXPECT_EQ(light({"--frames", "1", "--no-level-lights"})[0], 0.0);
    const double added = 1e6 / (4 * pi * 256 * 256);
    EXPECT_NEAR(light({"--set", "recursion_depth=0", "--no-level-lights", "--light", "point 0 0 0 1e6 1e6 1e6"})[0],
                added, 0.005 * added);
    EXPECT_NEAR(light({"--set", "recursion_depth=0", "--light", "point 0 0 0 1e6 1e6 1e6"})[0], own + added,
                0.005 * (own + added));
    EXPECT_EQ(probe({scene_, points_, out_, "--two-sided"}).status, 2);
}

} // namespace
} // namespace pie::test
