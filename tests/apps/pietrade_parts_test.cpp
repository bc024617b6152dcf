// The parts of pietrade that need no engine: front, plan, accuracy, files that are kept, progress, the view.

#include "apps/pietrade/accuracy.h"
#include "apps/pietrade/csv.h"
#include "apps/pietrade/front.h"
#include "apps/pietrade/kept.h"
#include "apps/pietrade/page.h"
#include "apps/pietrade/plan.h"
#include "apps/pietrade/progress.h"
#include "apps/pietrade/report.h"
#include "apps/pietrade/svg.h"
#include "apps/pietrade/view.h"
#include "pie/core/whole_file.h"
#include "pie/sampling/hash.h"
#include "tests/support/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace pie::test {
namespace {

using pietrade::Cost;
using pietrade::Ground;
using pietrade::Measurement;
using pietrade::Truth;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(TradeFront, NothingOnItIsBeatenAndNothingBesideItIsNot) {
    std::vector<Cost> costs;
    for (std::uint64_t i = 0; i < 400; ++i)
        costs.push_back({double{sampling::hash01(1, i)}, std::floor(20 * double{sampling::hash01(2, i)})});
    const auto beats = [](const Cost& a, const Cost& b) {
        return a.error <= b.error && a.time <= b.time && (a.error < b.error || a.time < b.time);
    };
    const std::vector<std::size_t> found = pietrade::front(costs);
    const std::set<std::size_t> on(found.begin(), found.end());
    EXPECT_GT(on.size(), 2U);
    for (std::size_t i = 0; i < costs.size(); ++i) {
        bool beaten = false;
        for (const Cost& other : costs) beaten = beaten || beats(other, costs[i]);
        EXPECT_EQ(on.contains(i), !beaten) << i;
    }
    for (std::size_t i = 1; i < found.size(); ++i) EXPECT_LT(costs[found[i - 1]].time, costs[found[i]].time);
}

TEST(TradeFront, EqualsAndNumbersThatAreNone) {
    const std::vector<Cost> costs{{0.1, 2}, {0.1, 2}, {pietrade::unknown, 1}, {0.01, pietrade::unknown},
                                  {0.2, 1}, {0.2, 3}};
    EXPECT_THAT(pietrade::front(costs), ElementsAre(4, 0));
    EXPECT_THAT(pietrade::front({}), IsEmpty());
    EXPECT_EQ(pietrade::bestWithin(costs, 1.5), 4U);
    EXPECT_EQ(pietrade::bestWithin(costs, 100), 0U);
    EXPECT_EQ(pietrade::bestWithin(costs, 0.5), std::nullopt);
    EXPECT_EQ(pietrade::fastestWithin(costs, 0.15), 0U);
    EXPECT_EQ(pietrade::fastestWithin(costs, 0.05), std::nullopt);
}

TEST(TradeAccuracy, OfDeviationsThatAreKnown) {
    // All 10 % too bright: |E - E0| / (1.1 E0 + 0.1 E0).
    const std::vector<Truth> truth(50, Truth{2.0, 0.0});
    const std::vector<double> bright(50, 2.2);
    const pietrade::Accuracy a = pietrade::compare(bright, truth);
    EXPECT_NEAR(a.error, 0.1 / 1.2, 1e-12);
    EXPECT_NEAR(a.median, 0.1, 1e-12);
    EXPECT_NEAR(a.errorDeviation, 0, 1e-9);
    EXPECT_EQ(a.points, 50U);
    EXPECT_EQ(pietrade::errorOf(bright, truth), a.error);
}

TEST(TradeAccuracy, LeavesOutWhatTheTruthDoesNotKnow) {
    // Noise of the truth is no error of the estimate: normal noise of 5 % around an exact answer.
    std::vector<Truth> truth;
    std::vector<double> found;
    for (std::uint64_t i = 0; i < 20'000; ++i) {
        double normal = -6;
        for (std::uint64_t n = 0; n < 12; ++n) normal += double{sampling::hash01(i, n)};
        truth.push_back({1 + 0.05 * normal, 0.05});
        found.push_back(1.0);
    }
    EXPECT_LT(pietrade::errorOf(found, truth), 0.01);
    for (Truth& t : truth) t.standardError = 0;
    EXPECT_NEAR(pietrade::errorOf(found, truth), 0.05 / 1.1, 0.003);
    // Points that see nothing do not count, whatever is found there.
    const std::vector<Truth> dark{{0, 0}, {1, 0}, {0, 0}};
    EXPECT_EQ(pietrade::compare(std::vector<double>{9, 1, 7}, dark).points, 1U);
    EXPECT_EQ(pietrade::errorOf(std::vector<double>{9, 1, 7}, dark), 0.0);
    EXPECT_TRUE(std::isnan(pietrade::errorOf(std::vector<double>{1}, std::vector<Truth>{{0, 0}})));
    // Light where there should be hardly any is wrong at most once.
    EXPECT_LE(pietrade::errorOf(std::vector<double>{1000, 1}, std::vector<Truth>{{1e-6, 0}, {1, 0}}), std::sqrt(0.5));
}

// The stated standard error against the spread over samples: 200 samples of 100 points, tolerance 4 sigma of a spread.
TEST(TradeAccuracy, StandardErrorsAreHonest) {
    std::vector<double> errors;
    double stated = 0;
    constexpr std::uint64_t samples = 200;
    for (std::uint64_t s = 0; s < samples; ++s) {
        std::vector<double> found;
        for (std::uint64_t i = 0; i < 100; ++i) found.push_back(1 + 0.2 * (double{sampling::hash01(s, i)} - 0.5));
        const auto a = pietrade::compare(found, std::vector<Truth>(100, Truth{1, 0}));
        errors.push_back(a.error);
        stated += a.errorDeviation / samples;
    }
    double mean = 0;
    double square = 0;
    for (const double e : errors) mean += e / samples;
    for (const double e : errors) square += (e - mean) * (e - mean) / (samples - 1);
    EXPECT_NEAR(stated / std::sqrt(square), 1, 0.2);
}

Ground ground() {
    Ground g;
    g.cores = 2;
    return g;
}

TEST(TradePlan, SweepsChangeOneParameterAndHoldTheDefault) {
    const engine::Settings base;
    std::set<std::string> keys;
    for (const pietrade::Sweep& sweep : pietrade::sweeps(ground())) {
        keys.insert(sweep.key);
        ASSERT_EQ(sweep.values.size(), sweep.settings.size());
        EXPECT_GE(sweep.values.size(), 2U) << sweep.key;
        int defaults = 0;
        for (std::size_t i = 0; i < sweep.values.size(); ++i) {
            engine::Settings expected = base;
            ASSERT_TRUE(expected.set(sweep.key, sweep.values[i], engine::Source::CommandLine));
            if (!sweep.with.empty()) {
                ASSERT_TRUE(expected.setPair(sweep.with, engine::Source::CommandLine));
            }
            EXPECT_EQ(pietrade::difference(pietrade::changed(base, sweep.settings[i]), expected), "") << sweep.key;
            defaults += pietrade::changed(base, sweep.settings[i]).value(sweep.key) == base.value(sweep.key) ? 1 : 0;
        }
        EXPECT_EQ(defaults, sweep.key == "threads" ? 0 : 1) << sweep.key;
    }
    for (const char* key : {"estimator", "photons_from_light", "gather_rays", "texel_size", "still_frames",
                            "accumulation_frames", "max_search_count", "direct_tolerance", "direct_samples",
                            "direct_light", "texel_light", "max_edge", "threads"})
        EXPECT_TRUE(keys.contains(key)) << key;
}

TEST(TradePlan, WhatTheUserSetStays) {
    Ground g = ground();
    ASSERT_TRUE(g.base.setOptions("max_edge=48 gather_rays=512", engine::Source::CommandLine));
    for (const pietrade::Sweep& sweep : pietrade::sweeps(g)) {
        EXPECT_NE(sweep.key, "max_edge");
        EXPECT_NE(sweep.key, "gather_rays");
    }
    for (const std::string& settings : pietrade::randomSettings(g)) {
        EXPECT_THAT(settings, ::testing::Not(HasSubstr("max_edge")));
        EXPECT_THAT(settings, ::testing::Not(HasSubstr("gather_rays")));
    }
    const engine::Settings changed = pietrade::changed(g.base, "still_frames=7");
    EXPECT_EQ(pietrade::optionString(changed), "gather_rays=512 still_frames=7 max_edge=48");
}

TEST(TradePlan, RandomSettingsMeetEverySpanOnce) {
    Ground g = ground();
    g.random = 30; // 24 of the gather
    std::set<int> spans;
    std::size_t gathers = 0;
    for (const std::string& settings : pietrade::randomSettings(g)) {
        const engine::Settings s = pietrade::changed(g.base, settings);
        if (s.estimator != engine::EstimatorKind::Gather) continue;
        ++gathers;
        // 0.25 to 8, evenly in the logarithm; two digits may round a value over a border.
        spans.insert(static_cast<int>(24 * std::log(double{s.directTolerance} / 0.25) / std::log(32)));
    }
    EXPECT_EQ(gathers, 24U);
    EXPECT_GE(spans.size(), 21U);
    EXPECT_EQ(pietrade::randomSettings(g), pietrade::randomSettings(g));
    g.seed = 1;
    EXPECT_NE(pietrade::randomSettings(g), pietrade::randomSettings(ground()));
}

TEST(TradePlan, NearSettingsAreNewAndMoveOneParameter) {
    const Ground g = ground();
    const std::vector<std::string> best{"gather_rays=64 max_edge=100", ""};
    const std::vector<std::string> found = pietrade::nearSettings(g, best, best, 12);
    EXPECT_EQ(found.size(), 12U);
    EXPECT_EQ(std::set<std::string>(found.begin(), found.end()).size(), 12U);
    for (const std::string& settings : found) {
        const engine::Settings s = pietrade::changed(g.base, settings);
        std::size_t fewest = 99;
        for (const std::string& from : best) {
            const std::string moved = pietrade::difference(pietrade::changed(g.base, from), s);
            fewest = std::min(fewest, static_cast<std::size_t>(std::count(moved.begin(), moved.end(), '=')));
        }
        EXPECT_EQ(fewest, 1U) << settings;
    }
}

TEST(TradeCsv, CellsAndNumbersComeBack) {
    for (const std::string text : {"", "plain", "with, comma", "with \"quotes\"", "\""}) {
        const auto cells = pietrade::csvCells(pietrade::csvCell(text) + ",x");
        ASSERT_TRUE(cells);
        EXPECT_THAT(*cells, ElementsAre(text, "x"));
    }
    EXPECT_FALSE(pietrade::csvCells("\"open,x"));
    for (const double value : {0.0, 1.0 / 3, 1e-300, 123456789.125})
        EXPECT_EQ(pietrade::readNumber(pietrade::csvNumber(value)), value);
    EXPECT_TRUE(std::isnan(*pietrade::readNumber(pietrade::csvNumber(pietrade::unknown))));
    for (const char* text : {"x", "1x", "inf", "nan", "1e999", " 1"}) EXPECT_FALSE(pietrade::readNumber(text)) << text;
}

class TradeKept : public ::testing::Test {
protected:
    TemporaryFolder folder_;
    pietrade::Identity identity_{{"program", "1"}, {"level", "room, content 0123"}};
    std::filesystem::path file_ = folder_.path() / "measurements.csv";

    static std::vector<Measurement> some() {
        std::vector<Measurement> all(2);
        all[0].stage = "default";
        all[1].settings = "max_edge=32 texel_size=8";
        all[1].stage = "sweep";
        all[1].error = 0.0625;
        all[1].frameMs = 1.0 / 3;
        return all;
    }
    [[nodiscard]] std::string problem(const std::string& text) const {
        EXPECT_FALSE(pie::writeWhole(file_, text));
        const auto read = pietrade::readMeasurements(file_, identity_);
        EXPECT_FALSE(read);
        EXPECT_EQ(readText(file_), text); // as it was
        return read ? "" : read.error().message();
    }
};

TEST_F(TradeKept, MeasurementsComeBack) {
    const auto none = pietrade::readMeasurements(file_, identity_);
    ASSERT_TRUE(none);
    EXPECT_THAT(*none, IsEmpty());
    EXPECT_FALSE(pie::writeWhole(file_, pietrade::measurementsText(identity_, some())));
    const auto read = pietrade::readMeasurements(file_, identity_);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->size(), 2U);
    EXPECT_EQ((*read)[1].settings, "max_edge=32 texel_size=8");
    EXPECT_EQ((*read)[1].stage, "sweep");
    EXPECT_EQ((*read)[1].error, 0.0625);
    EXPECT_EQ((*read)[1].frameMs, 1.0 / 3);
    EXPECT_TRUE(std::isnan((*read)[1].vertexError));
    EXPECT_EQ(pietrade::measurementsText(identity_, *read), readText(file_));
}

TEST_F(TradeKept, OneLineForWhatIsDamagedOrForeign) {
    const std::string good = pietrade::measurementsText(identity_, some());
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        return text.replace(text.find(from), from.size(), to);
    };
    EXPECT_THAT(problem(""), HasSubstr("is no file of pietrade"));
    EXPECT_THAT(problem("a,b\n1,2\n"), HasSubstr("is no file of pietrade"));
    EXPECT_THAT(problem(replaced("content 0123", "content 9999")),
                HasSubstr(R"(made with another level ("room, content 9999", now "room, content 0123"))"));
    EXPECT_THAT(problem(replaced("# program: 1", "# program: 2")), HasSubstr("made with another program"));
    EXPECT_THAT(problem(replaced("# program: 1\n", "")), HasSubstr("does not say its program"));
    EXPECT_THAT(problem(replaced(",error,", ",mistake,")), HasSubstr("columns of this version"));
    EXPECT_THAT(problem(replaced("0.0625", "0.06z25")), HasSubstr("line 6: \"0.06z25\" is no error"));
    EXPECT_THAT(problem(replaced(",sweep", "")), HasSubstr("line 6: has"));
    EXPECT_THAT(problem(good.substr(0, good.size() - 3)), HasSubstr("line 6: "));
    EXPECT_THAT(problem(replaced("max_edge=32 texel_size=8", "")), HasSubstr("repeats"));
}

TEST_F(TradeKept, TruthAsFarAsItWasTraced) {
    file_ = folder_.path() / "reference.csv";
    const std::vector<Truth> traced{{1.0 / 3, 0.01}, {0, 0}};
    EXPECT_FALSE(pie::writeWhole(file_, pietrade::truthText(identity_, traced)));
    const auto read = pietrade::readTruth(file_, identity_, 5);
    ASSERT_TRUE(read) << read.error().message();
    ASSERT_EQ(read->size(), 2U);
    EXPECT_EQ((*read)[0].irradiance, 1.0 / 3);
    EXPECT_FALSE(pietrade::readTruth(file_, identity_, 1));
    identity_[1].second = "another";
    EXPECT_FALSE(pietrade::readTruth(file_, identity_, 5));
}

TEST_F(TradeKept, FilesAreWholeOrAsTheyWere) {
    EXPECT_TRUE(pie::writeWhole(folder_.path() / "no" / "file", "x"));
    EXPECT_TRUE(pie::writeWhole(folder_.path(), "x")); // a folder
    EXPECT_FALSE(pie::writeWhole(file_, "one"));
    EXPECT_FALSE(pie::writeWhole(file_, "two"));
    EXPECT_EQ(readText(file_), "two");
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
        EXPECT_EQ(entry.path().filename(), "measurements.csv");
}

TEST(TradeProgress, BarAndDurations) {
    EXPECT_EQ(pietrade::duration(11.2), "12 s");
    EXPECT_EQ(pietrade::duration(200), "3 min 20 s");
    EXPECT_EQ(pietrade::duration(3720), "1 h 02 min");
    EXPECT_EQ(pietrade::bar(5, 20, 61, "max_edge=32", 79), "[#####...............] 5/20, 1 min 01 s left: max_edge=32");
    EXPECT_EQ(pietrade::bar(0, 20, pietrade::unknown, "", 79), "[....................] 0/20");
    EXPECT_EQ(pietrade::bar(20, 20, 0, "long", 24).size(), 24U);
}

TEST(TradeView, MeetsWhatIsAheadAndNotWhatIsBehind) {
    const pietrade::Camera camera{{0, 0, 0}, 90, 0}; // along +y
    const auto box = [](const Vec3& at) {
        Box b;
        b.extend(at - 1.0F);
        b.extend(at + 1.0F);
        return b;
    };
    EXPECT_TRUE(pietrade::meets(camera, box({0, 10, 0})));
    EXPECT_TRUE(pietrade::meets(camera, box({0, 0, 0})));
    EXPECT_FALSE(pietrade::meets(camera, box({0, -10, 0})));
    EXPECT_TRUE(pietrade::meets(camera, box({9.5F, 10, 0})));
    EXPECT_FALSE(pietrade::meets(camera, box({13, 10, 0})));
    EXPECT_FALSE(pietrade::meets(camera, box({-13, 10, 0})));
    EXPECT_TRUE(pietrade::meets(camera, box({0, 10, 7})));
    EXPECT_FALSE(pietrade::meets(camera, box({0, 10, 10})));
    EXPECT_TRUE(pietrade::meets({{0, 0, 0}, 90, -30}, box({0, 10, 10}))); // looking up
    EXPECT_FALSE(pietrade::meets(camera, Box()));
}

TEST(TradeSvg, TicksAreRoundAndWithin) {
    EXPECT_THAT(pietrade::ticks(0, 10, false), ElementsAre(0, 2, 4, 6, 8, 10));
    EXPECT_THAT(pietrade::ticks(1, 20, true), ElementsAre(1, 2, 5, 10, 20));
    EXPECT_LE(pietrade::ticks(1e-3, 1e4, true).size(), 9U);
}

TEST(TradeSvg, MarksStandWhereTheirNumbersAre) {
    pietrade::Plot plot;
    plot.x = {"milliseconds & more", true, {}};
    plot.y = {"error", false, {}};
    plot.series = {
        {"series <one>", 1, true, {{1, 5, 1, "first", "1"}, {10, 2, 0, "second", ""}, {100, 1, 0, "third", ""}}},
        {"", 0, false, {{0, 3, 0, "not on a logarithmic axis", ""}, {5, pietrade::unknown, 0, "unknown", ""}}}};
    const std::string text = pietrade::svg(plot);
    EXPECT_THAT(text, HasSubstr("milliseconds &amp; more"));
    EXPECT_THAT(text, HasSubstr("series &lt;one&gt;"));
    EXPECT_THAT(text, ::testing::Not(HasSubstr("unknown")));
    EXPECT_THAT(text, ::testing::Not(HasSubstr("logarithmic")));
    EXPECT_THAT(text, ::testing::Not(HasSubstr("nan")));
    // Places of the marks, in order: evenly apart in the logarithm, and less is lower.
    std::vector<std::pair<double, double>> places;
    const std::string circle = R"(<circle class="mark s1" cx=")";
    for (std::size_t at = text.find(circle); at != std::string::npos; at = text.find(circle, at + 1)) {
        const std::size_t y = text.find("cy=\"", at);
        places.emplace_back(std::stod(text.substr(at + circle.size())), std::stod(text.substr(y + 4)));
    }
    ASSERT_EQ(places.size(), 4U); // one in the legend
    EXPECT_NEAR(places[2].first - places[1].first, places[3].first - places[2].first, 0.2);
    EXPECT_LT(places[1].second, places[2].second);
    EXPECT_NEAR((places[2].second - places[1].second) / (places[3].second - places[2].second), 3, 0.02);
    EXPECT_THAT(pietrade::svg({}), HasSubstr("nothing measured"));
}

TEST(TradePage, NumbersAndCells) {
    EXPECT_EQ(pietrade::shown(0.03928, 100), "3.93");
    EXPECT_EQ(pietrade::shown(12345.6), "12346");
    EXPECT_EQ(pietrade::shown(pietrade::unknown), "\u2013");
    EXPECT_THAT(pietrade::table({"a", "b"}, {{"1", "2"}}), HasSubstr("<td class=\"text\">1</td><td>2</td>"));
}

/// Three settings of which one is beaten, and one of other threads.
pietrade::Findings findings() {
    pietrade::Findings found;
    found.level = "room <1>";
    found.levelArgument = "room.map";
    found.sweeps = pietrade::sweeps(ground());
    const auto add = [&](const char* settings, double error, double ms, double within) {
        Measurement m;
        m.settings = settings;
        m.error = error;
        m.frameMs = ms;
        m.within10Ms = m.within20Ms = within;
        found.measurements.push_back(m);
    };
    add("", 0.08, 6, 300);
    add("gather_rays=32", 0.15, 3, pietrade::unknown);
    add("gather_rays=512", 0.09, 7, 200);
    add("threads=2", 0.01, 1, 1);
    return found;
}

TEST(TradeAnalysis, FrontsAndAdvice) {
    const pietrade::Findings found = findings();
    const pietrade::Analysis a = pietrade::analyse(found);
    EXPECT_THAT(a.compared, ElementsAre(0, 1, 2));
    EXPECT_THAT(a.frames, ElementsAre(1, 0));
    EXPECT_EQ(a.near, 0.2); // hardly anything comes within 10 %
    EXPECT_THAT(a.pictures, ElementsAre(2, 0));
    const std::vector<std::string> lines = pietrade::advice(found, a);
    EXPECT_THAT(lines, ::testing::Contains("For 4 ms a frame take gather_rays=32: an error of 15.0 % at 3.0 ms."));
    EXPECT_THAT(lines, ::testing::Contains("For 8 ms a frame take the default: an error of 8.0 % at 6.0 ms."));
    EXPECT_THAT(lines, ::testing::Not(::testing::Contains(HasSubstr("For 16 ms")))); // more time buys nothing
    EXPECT_THAT(lines, ::testing::Contains("Nothing measured here has an error of 5 % or less."));
    EXPECT_EQ(pietrade::command(found, found.measurements[0]), "osgviewer room.map");
    EXPECT_EQ(pietrade::command(found, found.measurements[1]), "osgviewer -O \"gather_rays=32\" room.map");
}

TEST(TradeReport, HoldsWithoutAnyMeasurement) {
    pietrade::Findings found = findings();
    found.why = "not all settings were measured";
    EXPECT_THAT(pietrade::reportHtml(found, pietrade::analyse(found)), HasSubstr("room &lt;1&gt;"));
    found.measurements.clear();
    const pietrade::Analysis a = pietrade::analyse(found);
    EXPECT_THAT(pietrade::reportHtml(found, a), HasSubstr("nothing measured yet"));
    EXPECT_THAT(pietrade::reportJson(found, a), HasSubstr("\"complete\": false"));
}

} // namespace
} // namespace pie::test
