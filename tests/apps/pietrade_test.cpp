// pietrade as a user runs it: the report of a small room, resumed, interrupted, and what it refuses.

#include "tests/support/command.h"
#include "tests/support/files.h"
#include "tests/support/room.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

namespace pie::test {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
namespace fs = std::filesystem;

std::vector<std::string> linesOf(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

/// Lines of measurements.csv behind the columns.
std::vector<std::string> measured(const fs::path& file) {
    std::vector<std::string> lines = linesOf(readText(file));
    const auto head =
        std::find_if(lines.begin(), lines.end(), [](const std::string& line) { return line.starts_with("settings,"); });
    if (head == lines.end()) return {};
    return {std::next(head), lines.end()};
}

class Pietrade : public ::testing::Test {
protected:
    TemporaryFolder folder_;
    fs::path out_ = folder_.path() / "report";
    std::string level_ = (folder_.path() / "maps" / "room.bsp").string();
    // A room of few triangles, few photons and little of everything: seconds.
    std::vector<std::string> few_{"--out", out_.string(), "--quick", "--points", "12",    "--frames",
                                  "2",     "--random",    "2",       "--set",    "seed=3"};

    Pietrade() { writeGame(folder_, "room", makeRoom(small())); }

    static Room small() {
        Room room;
        room.side = 192;
        room.entities = "{\n\"classname\" \"info_player_start\"\n\"origin\" \"0 -64 -64\"\n\"angle\" \"90\"\n}\n"
                        "{\n\"classname\" \"light\"\n\"origin\" \"0 0 64\"\n\"light\" \"300\"\n}\n";
        return room;
    }

    [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& more = {}) const {
        std::vector<std::string> all{PIETRADE, level_};
        all.insert(all.end(), few_.begin(), few_.end());
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }
    [[nodiscard]] CommandResult trade(const std::vector<std::string>& more = {}) const { return run(command(more)); }
    [[nodiscard]] json report() const { return json::parse(readText(out_ / "report.json")); }
    [[nodiscard]] std::string all() const {
        return readText(out_ / "measurements.csv") + readText(out_ / "reference.csv") + readText(out_ / "report.json") +
               readText(out_ / "report.html");
    }
    /// Refused with one line, and nothing was touched.
    void expectRefused(const std::string& reason, const std::vector<std::string>& more = {}) const {
        const std::string before = all();
        const CommandResult result = trade(more);
        EXPECT_EQ(result.status, 1) << reason;
        EXPECT_THAT(result.err, HasSubstr(reason));
        EXPECT_EQ(linesOf(result.err).size(), 1U) << result.err;
        EXPECT_EQ(all(), before) << reason;
    }
};

void expectFront(const json& report, const char* front, const char* time) {
    std::map<std::string, std::pair<double, double>> costs;
    for (const json& m : report.at("measurements"))
        if (!m.at(time).is_null() && m.at("settings").get<std::string>().find("threads=") == std::string::npos)
            costs[m.at("settings")] = {m.at("error").get<double>(), m.at(time).get<double>()};
    const std::vector<std::string> names = report.at(front);
    EXPECT_FALSE(names.empty());
    for (const std::string& name : names)
        for (const auto& [other, cost] : costs)
            EXPECT_FALSE(cost.first < costs.at(name).first && cost.second <= costs.at(name).second)
                << other << " beats " << name;
}

TEST_F(Pietrade, MeasuresResumesAndRefuses) {
    const CommandResult first = trade({"--try", "gather_rays=16 texel_size=100"});
    ASSERT_EQ(first.status, 0) << first.err;
    EXPECT_THAT(first.out, HasSubstr("For "));
    const json made = report();
    EXPECT_TRUE(made.at("complete"));
    EXPECT_EQ(made.at("measurements").size(), made.at("planned"));

    // Every parameter is there, with numbers for each of its values.
    std::map<std::string, json> bySettings;
    for (const json& m : made.at("measurements")) bySettings[m.at("settings")] = m;
    std::set<std::string> keys;
    for (const json& sweep : made.at("sweeps")) {
        keys.insert(sweep.at("key"));
        EXPECT_EQ(sweep.at("values").size(), sweep.at("settings").size());
        for (const std::string settings : sweep.at("settings")) {
            ASSERT_TRUE(bySettings.contains(settings)) << settings;
            const json& m = bySettings.at(settings);
            for (const char* column : {"error", "error_stderr", "median", "frame_ms", "trace_ms", "build_ms",
                                       "estimate_ms", "ready_ms", "refine_ms", "receivers", "bytes"}) {
                ASSERT_TRUE(m.at(column).is_number()) << settings << ": " << column;
                EXPECT_GE(m.at(column).get<double>(), 0.0) << settings << ": " << column;
            }
            EXPECT_LT(m.at("error").get<double>(), 0.8) << settings; // light is there, and about right
        }
    }
    for (const char* key :
         {"estimator", "photons_from_light", "gather_rays", "texel_size", "accumulation_frames", "max_search_count",
          "direct_tolerance", "direct_samples", "direct_light", "texel_light", "max_edge", "threads"})
        EXPECT_TRUE(keys.contains(key)) << key;
    EXPECT_TRUE(bySettings.contains("texel_size=100 gather_rays=16"));
    EXPECT_EQ(bySettings.at("texel_size=100 gather_rays=16").at("command"),
              "osgviewer -O \"seed=3 texel_size=100 gather_rays=16\" " + level_);
    expectFront(made, "front_frame", "frame_ms");

    // A page of its own.
    const std::string page = readText(out_ / "report.html");
    for (const char* part :
         {"<!doctype html>", "</html>", "<svg", "prefers-color-scheme: dark", "max_search_count", "osgviewer -O"})
        EXPECT_THAT(page, HasSubstr(part));
    for (const char* part : {"<script", "http", "src=", "<link"}) EXPECT_THAT(page, Not(HasSubstr(part)));
    for (const auto& entry : fs::directory_iterator(out_)) EXPECT_NE(entry.path().extension(), ".part");

    // Again: nothing is measured anew. Without three lines: these three, and no other.
    const std::vector<std::string> same{"--try", "gather_rays=16 texel_size=100"};
    const std::string csv = readText(out_ / "measurements.csv");
    EXPECT_EQ(trade(same).status, 0);
    EXPECT_EQ(readText(out_ / "measurements.csv"), csv);
    const std::vector<std::string> lines = linesOf(csv);
    const std::size_t last = lines.size();
    std::string less;
    std::vector<std::string> taken;
    for (std::size_t i = 0; i < last; ++i)
        if (i == last - 4 || i == last - 9 || i == last - 15)
            taken.push_back(lines[i].substr(0, lines[i].find(',')));
        else
            less += lines[i] + '\n';
    (void)folder_.write("report/measurements.csv", less);
    const CommandResult resumed = trade(same);
    EXPECT_EQ(resumed.status, 0) << resumed.err;
    const std::vector<std::string> now = linesOf(readText(out_ / "measurements.csv"));
    ASSERT_EQ(now.size(), last);
    EXPECT_THAT(readText(out_ / "measurements.csv"), StartsWith(less));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_THAT(now[last - 3 + i], StartsWith(taken[i] + ","));

    // Other settings, another level, a damaged or foreign file.
    expectRefused("another settings", {"--set", "max_edge=48"});
    expectRefused("another view", {"--everything"});
    const std::string good = readText(out_ / "measurements.csv");
    (void)folder_.write("report/measurements.csv", good.substr(0, good.size() - 5));
    expectRefused("line " + std::to_string(last));
    (void)folder_.write("report/measurements.csv", "a,b\n");
    expectRefused("is no file of pietrade");
    (void)folder_.write("report/measurements.csv", good);
    (void)folder_.write("report/reference.csv", "a,b\n");
    expectRefused("reference.csv");
    Room bright = small();
    bright.entities.replace(bright.entities.find("300"), 3, "301");
    writeGame(folder_, "room", makeRoom(bright));
    expectRefused("another level");
}

TEST_F(Pietrade, InterruptedItKeepsWhatItHasAndGoesOn) {
    // As Ctrl-C, once two lines are there.
    std::string line;
    for (const std::string& word : command()) line += '\'' + word + "' ";
    const std::string csv = (out_ / "measurements.csv").string();
    const CommandResult result =
        run({"bash", "-c",
             line + "& child=$!; until [ \"$(grep -c sweep '" + csv +
                 "' 2>/dev/null)\" -ge 2 ] 2>/dev/null; do sleep 0.02; done; kill -INT $child; wait $child"});
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_THAT(result.err, HasSubstr("ended early"));
    const std::vector<std::string> before = measured(csv);
    EXPECT_GE(before.size(), 3U);
    EXPECT_FALSE(report().at("complete"));
    EXPECT_LT(report().at("measurements").size(), report().at("planned"));
    EXPECT_EQ(report().at("measurements").size(), before.size());
    EXPECT_THAT(readText(out_ / "report.html"), HasSubstr("Not complete"));

    const CommandResult rest = trade();
    EXPECT_EQ(rest.status, 0) << rest.err;
    const std::vector<std::string> after = measured(csv);
    EXPECT_TRUE(report().at("complete"));
    ASSERT_GT(after.size(), before.size());
    EXPECT_TRUE(std::equal(before.begin(), before.end(), after.begin()));
    std::set<std::string> settings;
    for (const std::string& row : after) EXPECT_TRUE(settings.insert(row.substr(0, row.find(','))).second) << row;
}

TEST_F(Pietrade, MeasuresOnlyWhatItIsTold) {
    const std::vector<std::string> some{"--no-sweeps", "--random", "0", "--try", "max_edge=32", "--everything"};
    std::vector<std::string> command{PIETRADE, level_,     "--out", out_.string(), "--quick", "--frames",
                                     "1",      "--points", "5"};
    command.insert(command.end(), some.begin(), some.end());
    const CommandResult result = run(command);
    EXPECT_EQ(result.status, 0) << result.err;
    const std::vector<std::string> rows = measured(out_ / "measurements.csv");
    ASSERT_EQ(rows.size(), 2U);
    EXPECT_THAT(rows[0], StartsWith(",default,"));
    EXPECT_THAT(rows[1], StartsWith("max_edge=32,tried,"));
    EXPECT_TRUE(report().at("complete"));
}

TEST_F(Pietrade, ATimeLimitEndsItEarly) {
    const CommandResult result = trade({"--time-limit", "0.000001"});
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_FALSE(report().at("complete"));
    EXPECT_TRUE(fs::exists(out_ / "reference.csv"));
    EXPECT_TRUE(fs::exists(out_ / "report.html"));
}

TEST_F(Pietrade, OneLineForWhatIsWrong) {
    const auto expectLine = [&](const CommandResult& result, int status, const std::string& reason) {
        EXPECT_EQ(result.status, status) << reason;
        EXPECT_THAT(result.err, HasSubstr(reason));
        EXPECT_EQ(linesOf(result.err).size(), 1U) << result.err;
        EXPECT_FALSE(fs::exists(out_)) << reason;
    };
    expectLine(trade({"--set", "gather_rais=3"}), 2, "gather_rays");
    expectLine(trade({"--set", "view=baked"}), 2, "view");
    expectLine(trade({"--try", "max_edge=wide"}), 2, "--try: max_edge");
    expectLine(trade({"--points", "1"}), 2, "--points");
    expectLine(trade({"--camera", "1 2 3"}), 2, "x y z yaw pitch");
    expectLine(trade({"--camera", "1 2 3 4 5", "--everything"}), 2, "exclude");
    expectLine(run({PIETRADE}), 2, "LEVEL");
    expectLine(run({PIETRADE, "nowhere.bsp", "--out", out_.string()}), 1, "nowhere.bsp");
    EXPECT_EQ(run({PIETRADE, "--help"}).status, 0);
    (void)folder_.write("report/report.html", "mine");
    const CommandResult foreign = trade();
    EXPECT_EQ(foreign.status, 1);
    EXPECT_THAT(foreign.err, HasSubstr("not of this program"));
    EXPECT_EQ(readText(out_ / "report.html"), "mine");
    const std::string file = folder_.write("file", "mine");
    EXPECT_EQ(run({PIETRADE, level_, "--out", file}).status, 1);
    EXPECT_EQ(readText(file), "mine");
}

} // namespace
} // namespace pie::test
