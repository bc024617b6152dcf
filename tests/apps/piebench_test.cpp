// piebench as a user runs it, with numbers so small that it takes a moment: what it reports is complete and finite,
// what does not depend on time is right, and what it cannot do it says in one line. No time decides anything.

#include "tests/support/command.h"
#include "tests/support/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace pie::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

const std::string smallLevel = std::string(PIE_LEVELS) + "/maps/small.map";
const std::string cornellLevel = std::string(PIE_LEVELS) + "/maps/cornell.map";

/// Every number below is finite.
void expectFinite(const Json& json, const std::string& path = "") {
    if (json.is_number()) {
        EXPECT_TRUE(std::isfinite(json.get<double>())) << path;
    } else if (json.is_object() || json.is_array()) {
        for (const auto& [key, value] : json.items()) expectFinite(value, path + "/" + key);
    }
}

class Piebench : public ::testing::Test {
protected:
    TemporaryFolder folder_;

    [[nodiscard]] static CommandResult bench(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), PIEBENCH);
        CommandOptions patient;
        patient.timeoutSeconds = 300;
        return run(arguments, patient);
    }
    /// JSON of a run that went well.
    [[nodiscard]] static Json report(std::vector<std::string> arguments) {
        arguments.emplace_back("--json");
        const CommandResult result = bench(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        EXPECT_EQ(result.err, "");
        Json json = Json::parse(result.out, nullptr, false);
        EXPECT_FALSE(json.is_discarded()) << result.out;
        expectFinite(json);
        return json;
    }
    [[nodiscard]] Json frame(const std::vector<std::string>& more) const {
        std::vector<std::string> arguments{"frame",        cornellLevel,
                                           "--photons",    "600",
                                           "--triangles",  "300",
                                           "--repeats",    "2",
                                           "--sample",     "8",
                                           "--target",     "0.2",
                                           "--most-paths", "4096",
                                           "--cache",      folder_.path().string(),
                                           "--set",        "gather_rays=16"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return report(arguments);
    }
    static void expectOneLine(const std::vector<std::string>& arguments, int status, const std::string& reason) {
        const CommandResult result = bench(arguments);
        EXPECT_EQ(result.status, status) << reason;
        EXPECT_THAT(result.err, HasSubstr(reason));
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_EQ(result.out, "");
    }
};

void expectKeys(const Json& json, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key;
}

TEST_F(Piebench, AFrameHasEveryStageAndItsError) {
    const Json json = frame({"--against", "nanoflann", "--against", "embree"});
    expectKeys(json, {"program",
                      "command",
                      "level",
                      "machine",
                      "threads",
                      "settings",
                      "triangles",
                      "coarse_triangles",
                      "vertices",
                      "receivers",
                      "lights",
                      "photons",
                      "accumulation_frames",
                      "repeats",
                      "upload",
                      "reference",
                      "runs",
                      "ratios",
                      "scaling",
                      "targets",
                      "load_after"});
    expectKeys(json["machine"], {"processor", "cores", "load"});
    EXPECT_EQ(json["triangles"], 300);
    EXPECT_EQ(json["threads"], 1);
    EXPECT_NEAR(json["photons"]["stored"].get<double>(), 600, 60);
    ASSERT_EQ(json["runs"].size(), 3U);
    for (std::size_t i = 0; i < 2; ++i) {
        const Json& run = json["runs"][i];
        EXPECT_EQ(run["estimator"], i == 0 ? "gather" : "nanoflann");
        EXPECT_GT(run["bytes_per_vertex"], 0.0);
        EXPECT_GT(run["bytes_per_photon"], 0.0);
        expectKeys(run, {"prepare_ms"});
        for (const char* kind : {"full", "steady"}) {
            const Json& times = run[kind];
            expectKeys(times, {"trace_ms", "build_ms", "estimate_ms", "upload_ms", "total_ms", "processor_ms",
                               "photons_stored_per_second", "estimates_per_second"});
            EXPECT_EQ(times["error"]["points"], 8);
            EXPECT_GT(times["error"]["rms"], 0.0);
            EXPECT_GE(times["error"]["rms"], times["error"]["rms_99"]);
            EXPECT_GT(times["error"]["median"], 0.0);
        }
        EXPECT_GT(run["full"]["photons_new"], run["steady"]["photons_new"]);
    }
    EXPECT_EQ(json["runs"][2]["tracer"], "embree");
    EXPECT_GT(json["runs"][2]["rays"]["rays"], 600);
    expectKeys(json["ratios"]["nanoflann"], {"full", "full_processor", "steady", "steady_processor", "steady_over_full",
                                             "steady_over_full_processor", "error_rms", "error_rms_99"});
    expectKeys(json["ratios"]["embree"], {"photons_per_second", "photons_per_second_processor"});
    EXPECT_EQ(json["targets"].size(), 6U);
}

/// Two searches for the same photons: what differs is rounding of sums.
TEST_F(Piebench, NanoflannAndTheKdTreeGiveTheSameIrradiance) {
    const Json json = frame({"--estimator", "nearest", "--against", "nanoflann"});
    for (const char* kind : {"full", "steady"}) {
        const Json& ours = json["runs"][0][kind]["error"];
        const Json& theirs = json["runs"][1][kind]["error"];
        for (const char* key : {"rms", "median", "mean"})
            EXPECT_NEAR(ours[key].get<double>(), theirs[key].get<double>(), 1e-3 * std::abs(theirs[key].get<double>()));
    }
}

TEST_F(Piebench, AReferenceIsComputedOnceAndAgainWhenDamaged) {
    const Json first = frame({});
    EXPECT_EQ(first["reference"]["kept"], false);
    const std::string file = first["reference"]["file"];
    const std::string text = readText(file);
    const Json second = frame({"--seed", "5", "--threads", "2"});
    EXPECT_EQ(second["reference"]["kept"], true);
    EXPECT_EQ(second["reference"]["file"], file);
    EXPECT_NE(first["runs"][0]["full"]["error"], second["runs"][0]["full"]["error"]); // another seed
    (void)folder_.write(std::filesystem::path(file).filename().string(), text.substr(0, text.size() / 2));
    const Json third = frame({});
    EXPECT_EQ(third["reference"]["kept"], false);
    EXPECT_EQ(third["runs"][0]["full"]["error"], first["runs"][0]["full"]["error"]);
    // Seconds are in the second line.
    EXPECT_EQ(readText(file).substr(text.find('\n', text.find('\n') + 1)),
              text.substr(text.find('\n', text.find('\n') + 1)));
    EXPECT_NE(frame({"--set", "light_scale=2"})["reference"]["file"], file);
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Piebench, ThreadsAndTextAndRaysAlone) {
    const Json json = frame({"--threads", "2", "--scaling", "--no-reference"});
    EXPECT_EQ(json["reference"], nullptr);
    EXPECT_EQ(json["runs"][0]["full"]["error"], nullptr);
    expectKeys(json["scaling"], {"threads", "full", "full_trace", "full_build", "full_estimate", "steady"});
    EXPECT_EQ(frame({"--tracer", "embree"})["runs"].size(), 1U);
    const CommandResult text =
        bench({"frame", cornellLevel, "--photons", "100", "--repeats", "1", "--no-reference", "--triangles", "200"});
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_THAT(text.out, HasSubstr("| gather | steady |"));
}

TEST_F(Piebench, TheTablesOfThePaper) {
    const Json rates = report({"table61", "--most", "800", "--seconds", "0", "--set", "gather_rays=4"});
    EXPECT_EQ(rates["level"], "small");
    ASSERT_EQ(rates["cells"].size(), 4U);
    EXPECT_EQ(rates["cells"][0]["paper_fps"], 460);
    EXPECT_EQ(rates["cells"][2]["paper_fps"], 344); // 800 triangles, 400 photons
    EXPECT_EQ(rates["cells"][2]["triangles"], 800);
    for (const Json& cell : rates["cells"])
        for (const char* key : {"nearest_ms", "nearest_fps", "gather_ms", "gather_fps"}) EXPECT_GT(cell[key], 0.0);
    expectKeys(rates["exponents"], {"paper", "nearest", "gather"});
    // Of the paper's own four numbers, by hand: slope of log(1 / rate) over log(triangles + photons).
    EXPECT_NEAR(rates["exponents"]["paper"].get<double>(), 0.918, 0.0006);
    EXPECT_EQ(rates["targets"].size(), 2U);

    const Json renewal =
        report({"table62", smallLevel, "--photons", "640", "--seconds", "0", "--set", "gather_rays=4"});
    ASSERT_EQ(renewal["rows"].size(), 7U);
    for (const Json& row : renewal["rows"])
        for (const char* which : {"nearest", "gather"}) {
            const double frames = row["accumulation_frames"];
            EXPECT_NEAR(row[std::string(which) + "_fps"].get<double>() *
                            row[std::string(which) + "_renewal_s"].get<double>(),
                        frames, 0.01 * frames);
        }
    EXPECT_EQ(renewal["rows"][4]["paper_renewal_s"], 1.94);
}

TEST_F(Piebench, TheStatementsOfThePaper) {
    const Json json = report({"statements", "--seconds", "0"});
    ASSERT_EQ(json["statements"].size(), 12U);
    for (const Json& statement : json["statements"]) {
        expectKeys(statement, {"statement", "where", "paper", "measured", "verdict"});
        EXPECT_GE(statement["measured"], 0.0);
        // Corners over receivers are counted, not timed.
        if (statement["statement"].get<std::string>().find("5–6 times") != std::string::npos) {
            EXPECT_NEAR(statement["measured"].get<double>(), 5, 1);
            EXPECT_EQ(statement["verdict"], "agrees");
        }
    }
}

TEST_F(Piebench, OneLineForWhatCannotBeDone) {
    expectOneLine({}, 2, "subcommand");
    expectOneLine({"frame"}, 2, "LEVEL");
    expectOneLine({"frame", cornellLevel, "--estimator", "guess"}, 2, "guess");
    expectOneLine({"frame", cornellLevel, "--photons", "0"}, 2, "--photons");
    expectOneLine({"frame", cornellLevel, "--triangles", "3"}, 2, "before any is split");
    expectOneLine({"frame", cornellLevel, "--set", "photons_from_lihgt=3"}, 2, "photons_from_light");
    expectOneLine({"frame", cornellLevel, "--scaling"}, 2, "--threads");
    expectOneLine({"frame", cornellLevel, "--tracer", "embree", "--against", "gather"}, 2, "--against embree");
    expectOneLine({"frame", "nowhere.map"}, 1, "nowhere.map");
    expectOneLine({"frame", cornellLevel, "--set", "recursion_depth=0"}, 1, "keeps 0 of");
    expectOneLine({"table61", "--most", "1"}, 2, "--most");
    expectOneLine({"table61", cornellLevel, "--set", "seed=x"}, 2, "seed");
    expectOneLine({"table62", "nowhere.map"}, 1, "nowhere.map");
    expectOneLine({"statements", "what"}, 2, "what");
    const std::string file = folder_.write("file", "");
    expectOneLine({"frame", cornellLevel, "--sample", "1", "--most-paths", "16", "--cache", file}, 1,
                  "cannot be written");
    for (const std::vector<std::string>& help : {std::vector<std::string>{"--help"}, {"frame", "--help"}}) {
        const CommandResult result = bench(help);
        EXPECT_EQ(result.status, 0);
        EXPECT_THAT(result.out, HasSubstr("frame"));
    }
    EXPECT_THAT(bench({"frame", "--help"}).out, HasSubstr("Examples:"));
    EXPECT_THAT(bench({"frame", "--help"}).out, HasSubstr("Exit status"));
}

} // namespace
} // namespace pie::test
