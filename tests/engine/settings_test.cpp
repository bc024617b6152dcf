#include "pie/engine/options.h"
#include "pie/engine/settings.h"
#include "tests/support/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <sstream>

namespace pie::engine {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SettingsFile : public ::testing::Test {
protected:
    [[nodiscard]] std::string write(const std::string& text) const { return folder_.write("pie.toml", text); }
    [[nodiscard]] std::string below(const char* name) const { return (folder_.path() / name).string(); }

private:
    test::TemporaryFolder folder_;
};

/// A value other than the default that the row accepts.
std::string otherValue(const SettingInfo& info) {
    if (info.syntax == "true|false") return info.defaultValue == "true" ? "false" : "true";
    if (info.syntax.find('|') != std::string::npos) {
        std::stringstream names(info.syntax);
        for (std::string name; std::getline(names, name, '|');)
            if (name != info.defaultValue) return name;
    }
    if (info.syntax == "<folder>:<folder>") return "/a:/b";
    if (info.syntax == "<folder>") return "/a";
    if (info.syntax == "<integer>" && info.defaultValue == "1") return "2";
    // Half of the default or, from zero, one: inside every range of the table.
    if (info.defaultValue == "0") return "1";
    const double half = std::stod(info.defaultValue) / 2;
    if (info.syntax == "<number>") return info.key == "overbright_clamp" ? "2" : std::to_string(half);
    return std::to_string(static_cast<long>(std::ceil(half)));
}

TEST(Settings, EveryRowIsDescribedAndKeysAreUnique) {
    std::set<std::string_view> keys;
    for (const SettingInfo& info : describe()) {
        SCOPED_TRACE(info.key);
        EXPECT_TRUE(keys.insert(info.key).second);
        EXPECT_FALSE(info.syntax.empty());
        EXPECT_FALSE(info.group.empty());
        EXPECT_GT(info.consequence.size(), 10U);
        EXPECT_EQ(info.key.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_"), std::string_view::npos);
    }
    EXPECT_GE(keys.size(), 45U);
}

// The table may name the wrong field or swap two names of an enumeration; what goes in must come out, alone.
TEST(Settings, EveryRowWritesItsOwnFieldAndNoOther) {
    for (const SettingInfo& info : describe()) {
        if (info.key == "config") continue; // reads a file: SettingsFile
        if (info.key == "preset") continue; // writes others, too: see below
        SCOPED_TRACE(info.key);
        Settings settings;
        const std::string wanted = otherValue(info);
        const Result<bool> taken = settings.set(info.key, wanted, Source::CommandLine);
        ASSERT_TRUE(taken) << taken.error().message();
        EXPECT_TRUE(*taken);
        EXPECT_NE(settings.value(info.key), info.defaultValue);
        for (const SettingInfo& other : describe()) {
            if (other.key == info.key) continue;
            EXPECT_EQ(settings.value(other.key), other.defaultValue) << other.key;
            EXPECT_EQ(settings.origin(other.key), Source::Default) << other.key;
        }
        EXPECT_EQ(settings.origin(info.key), Source::CommandLine);
        // A value as shown is a value as read.
        Settings again;
        ASSERT_TRUE(again.set(info.key, settings.value(info.key), Source::Options));
        EXPECT_EQ(again.value(info.key), settings.value(info.key));
        // And it can be taken back.
        ASSERT_TRUE(settings.set(info.key, info.defaultValue, Source::CommandLine));
        EXPECT_EQ(settings.value(info.key), info.defaultValue);
        EXPECT_EQ(settings.origin(info.key), Source::CommandLine);
    }
}

TEST(Settings, NamesOfChoicesStandInTheOrderOfTheEnumerations) {
    Settings s;
    ASSERT_TRUE(s.setOptions("view=baked renderer=fixed color_space=srgb blending=add_signed scattering=split "
                             "intersector=bsp estimator=nearest kernel=constant photon_map=exact direct_light=photons "
                             "reflectance=compiler"));
    EXPECT_EQ(s.view, View::Baked);
    EXPECT_EQ(s.renderer, Renderer::Fixed);
    EXPECT_EQ(s.colorSpace, ColorSpace::Srgb);
    EXPECT_EQ(s.blending, Blending::AddSigned);
    EXPECT_EQ(s.scattering, photons::TracerOptions::Scattering::Splitting);
    EXPECT_EQ(s.intersector, intersect::Kind::Bsp);
    EXPECT_EQ(s.estimator, EstimatorKind::Nearest);
    EXPECT_EQ(s.kernel, gather::Kernel::Constant);
    EXPECT_EQ(s.photonMap, PhotonMapKind::Exact);
    EXPECT_EQ(s.directLight, DirectLight::Photons);
    EXPECT_EQ(s.reflectance, scene::ReflectanceModel::Compiler);
    ASSERT_TRUE(s.setOptions("view=fullbright intersector=brute_force"));
    EXPECT_EQ(s.view, View::Fullbright);
    EXPECT_EQ(s.intersector, intersect::Kind::BruteForce);
    ASSERT_TRUE(s.setOptions("view=light intersector=embree"));
    EXPECT_EQ(s.view, View::Light);
    EXPECT_EQ(s.intersector, intersect::Kind::Embree);
    ASSERT_TRUE(s.setOptions("view=lit"));
    EXPECT_EQ(s.view, View::Lit);
}

TEST(Settings, NamesOfEstimatesStandInTheOrderOfTheEnumerations) {
    Settings s;
    ASSERT_TRUE(s.setOptions("kernel=cone area=ellipse search_volume=cylinder search_radius=progressive"));
    EXPECT_EQ(s.kernel, gather::Kernel::Cone);
    EXPECT_EQ(s.area, gather::AreaEstimate::Ellipse);
    EXPECT_EQ(s.searchVolume, gather::SearchVolume::Cylinder);
    EXPECT_EQ(s.searchRadius, gather::RadiusRule::Progressive);
    ASSERT_TRUE(s.setOptions("kernel=gaussian area=convex_hull search_volume=ellipsoid search_radius=fixed"));
    EXPECT_EQ(s.kernel, gather::Kernel::Gaussian);
    EXPECT_EQ(s.area, gather::AreaEstimate::Hull);
    EXPECT_EQ(s.volume(), gather::SearchVolume::Ellipsoid);
    EXPECT_EQ(s.searchRadius, gather::RadiusRule::Fixed);
    ASSERT_TRUE(s.setOptions("area=true_area search_volume=sphere"));
    EXPECT_EQ(s.area, gather::AreaEstimate::True);
    EXPECT_EQ(s.searchVolume, gather::SearchVolume::Sphere);
    ASSERT_TRUE(s.setOptions("area=box"));
    EXPECT_EQ(s.area, gather::AreaEstimate::Box);
    ASSERT_TRUE(s.setOptions("area=oriented_box"));
    EXPECT_EQ(s.area, gather::AreaEstimate::OrientedBox);
}

TEST(Settings, OldNamesOfEstimatesKeepTheirMeaning) {
    Settings s;
    EXPECT_EQ(s.volume(), gather::SearchVolume::Slice);
    ASSERT_TRUE(s.setOptions("use_sphere_slice=false estimator=nearest"));
    EXPECT_EQ(s.volume(), gather::SearchVolume::Sphere);
    EXPECT_FALSE(s.usesTrueArea());
    ASSERT_TRUE(s.setOptions("estimator=true_area"));
    EXPECT_TRUE(s.usesTrueArea());
    ASSERT_TRUE(s.setOptions("estimator=nearest area=true_area"));
    EXPECT_TRUE(s.usesTrueArea());
}

TEST(Settings, OptionStringsAreSplitAtBlanks) {
    Settings s;
    ASSERT_TRUE(s.setOptions("  photons_from_light=123\tmax_edge=32.5  stats \n seed=18446744073709551615 "));
    EXPECT_EQ(s.photonsFromLight, 123);
    EXPECT_FLOAT_EQ(s.maxEdge, 32.5F);
    EXPECT_TRUE(s.stats);
    EXPECT_EQ(s.seed, std::numeric_limits<std::uint64_t>::max());
    EXPECT_TRUE(s.setOptions(""));
    EXPECT_THAT(s.effective(), ElementsAre("photons_from_light=123 (options)", "seed=18446744073709551615 (options)",
                                           "max_edge=32.5 (options)", "stats=true (options)"));
    EXPECT_EQ(s.effective(true).size(), describe().size());
}

TEST(Settings, UnknownKeysSuggestTheNearestName) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"max_serch_count", "max_search_count"},
        {"photons", "photons_from_light"},
        {"photonsFromLight", "photons_from_light"},
        {"expsoure", "exposure"},
        {"EXPOSURE", "exposure"},
        {"use-sphere-slice", "use_sphere_slice"},
        {"recursiondepth", "recursion_depth"},
        {"colour_space", "color_space"},
        {"accumulation", "accumulation_frames"},
        {"veiw", "view"},
        {"radius", "search_radius"},
    };
    for (const auto& [typed, meant] : cases) {
        Settings s;
        const Result<bool> result = s.set(typed, "1", Source::Options);
        ASSERT_FALSE(result) << typed;
        EXPECT_EQ(result.error().message(), fmt::format("{}: no such setting (did you mean {}?)", typed, meant));
    }
    Settings s;
    const Result<bool> monster = s.set(std::string(1 << 20, 'x'), "1", Source::Options);
    ASSERT_FALSE(monster);
    EXPECT_LT(monster.error().message().size(), 300U);
    EXPECT_FALSE(s.setOptions("=5"));
}

TEST(Settings, BadValuesNameWhatIsAllowed) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"photons_from_light=many", "photons_from_light: cannot be \"many\" (use <integer>, 0 to 10000000)"},
        {"photons_from_light=-1", "photons_from_light: cannot be \"-1\" (use <integer>, 0 to 10000000)"},
        {"photons_from_light=10000001", "photons_from_light: cannot be \"10000001\" (use <integer>, 0 to 10000000)"},
        {"photons_from_light=99999999999",
         "photons_from_light: cannot be \"99999999999\" (use <integer>, 0 to 10000000)"},
        {"photons_from_light=5.5", "photons_from_light: cannot be \"5.5\" (use <integer>, 0 to 10000000)"},
        {"photons_from_light=", "photons_from_light: cannot be \"\" (use <integer>, 0 to 10000000)"},
        {"exposure=nan", "exposure: cannot be \"nan\" (use <number>, 0 to 1000)"},
        {"exposure=-0.5", "exposure: cannot be \"-0.5\" (use <number>, 0 to 1000)"},
        {"exposure=1.5x", "exposure: cannot be \"1.5x\" (use <number>, 0 to 1000)"},
        {"max_edge=0", "max_edge: cannot be \"0\" (use <number>, 0.001 or more)"},
        {"seed=-1", "seed: cannot be \"-1\" (use <integer>, 0 or more)"},
        {"view=pretty", "view: cannot be \"pretty\" (use "
                        "lit|baked|fullbright|light|lightmap|split|difference|normals|triangles|coarse_"
                        "triangles|photons|samples)"},
        {"stats=maybe", "stats: cannot be \"maybe\" (use true|false)"},
        {"view",
         "view: has no value (write view=lit|baked|fullbright|light|lightmap|split|difference|normals|triangles|coarse_"
         "triangles|photons|samples)"},
    };
    for (const auto& [option, message] : cases) {
        Settings s;
        const Result<bool> result = s.setOptions(option);
        ASSERT_FALSE(result) << option;
        EXPECT_EQ(result.error().message(), message);
    }
}

TEST(Settings, BoundsThemselvesAndInfinityAreAllowed) {
    Settings s;
    EXPECT_TRUE(s.setOptions("max_edge=0.001 max_search_radius=inf max_reflectance=1 photons_from_light=0 "
                             "max_search_count=0 radius_heuristic_alpha=0.000001"));
    EXPECT_TRUE(std::isinf(s.maxSearchRadius));
    EXPECT_TRUE(s.set("max_search_radius", "1e-45", Source::Options));
    EXPECT_GT(s.maxSearchRadius, 0.0F);
    EXPECT_FALSE(s.setOptions("exposure=inf"));
}

TEST(Settings, AFailedCallChangesNothing) {
    Settings s;
    ASSERT_FALSE(s.setOptions("exposure=2 seed=7 max_edge=none"));
    EXPECT_THAT(s.effective(), IsEmpty());
    EXPECT_EQ(s.origin("exposure"), Source::Default);
}

TEST(Settings, SourcesRankWhateverTheOrderOfCalls) {
    const std::vector<Source> sources{Source::Level, Source::File, Source::Options, Source::CommandLine};
    for (const Source first : sources)
        for (const Source second : sources) {
            Settings s;
            ASSERT_TRUE(s.set("exposure", "2", first));
            const Result<bool> taken = s.set("exposure", "3", second);
            ASSERT_TRUE(taken);
            EXPECT_EQ(*taken, second >= first);
            EXPECT_EQ(s.exposure, second >= first ? 3.0F : 2.0F);
            EXPECT_EQ(s.origin("exposure"), std::max(first, second));
        }
}

TEST(Settings, PairsKeepBlanks) {
    Settings s;
    ASSERT_TRUE(s.setPair("game=/games/open arena", Source::CommandLine));
    EXPECT_EQ(s.game, "/games/open arena");
    ASSERT_TRUE(s.setPair("textures=/a b::/c=d", Source::CommandLine));
    EXPECT_THAT(s.textures, ElementsAre("/a b", "/c=d"));
}

TEST(Settings, WarnsOfSettingsThatDoNothing) {
    EXPECT_THAT(Settings().warnings(), IsEmpty());
    Settings s;
    ASSERT_TRUE(s.setOptions("diffuse_reflections=10"));
    EXPECT_THAT(s.warnings(), ElementsAre(AllOf(HasSubstr("diffuse_reflections"), HasSubstr("roulette"))));
    ASSERT_TRUE(s.setOptions("scattering=split"));
    EXPECT_THAT(s.warnings(), IsEmpty());
    ASSERT_TRUE(s.setOptions("direct_light=photons store_direct_light=false"));
    EXPECT_TRUE(s.storesDirectLight());
    EXPECT_THAT(s.warnings(), ElementsAre(HasSubstr("store_direct_light")));
    ASSERT_TRUE(s.setOptions("direct_light=shadow_rays"));
    EXPECT_FALSE(s.storesDirectLight());
    Settings split;
    ASSERT_TRUE(split.setOptions("split_maps=both"));
    EXPECT_EQ(split.splitMaps, maps::SplitBy::Both);
    EXPECT_THAT(split.warnings(), ElementsAre(AllOf(HasSubstr("split_maps"), HasSubstr("no photon map"))));
    ASSERT_TRUE(split.setOptions("estimator=nearest"));
    EXPECT_THAT(split.warnings(), IsEmpty());
}

TEST_F(SettingsFile, AllKinds) {
    const std::string file = write("# ours\nview = \"baked\"\nexposure = 2\nmax_edge = 12.5\nstats = true\n"
                                   "photons_from_light = 1_000\ngame = \"base\"\ntextures = [\"a\", \"/b\"]\n");
    Settings s;
    const Result<bool> read = s.readFile(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(s.view, View::Baked);
    EXPECT_EQ(s.exposure, 2.0F);
    EXPECT_EQ(s.maxEdge, 12.5F);
    EXPECT_TRUE(s.stats);
    EXPECT_EQ(s.photonsFromLight, 1000);
    EXPECT_EQ(s.game, below("base"));
    EXPECT_THAT(s.textures, ElementsAre(below("a"), "/b"));
    EXPECT_EQ(s.origin("exposure"), Source::File);
}

TEST_F(SettingsFile, OptionsWinOverTheFileTheyName) {
    const std::string file = write("exposure = 5\nseed = 9\n");
    for (const std::string& options : {"exposure=2 config=" + file, "config=" + file + " exposure=2"}) {
        Settings s;
        const Result<bool> read = s.setOptions(options);
        ASSERT_TRUE(read) << read.error().message();
        EXPECT_EQ(s.exposure, 2.0F);
        EXPECT_EQ(s.seed, 9U);
        EXPECT_EQ(s.origin("seed"), Source::File);
        EXPECT_EQ(s.origin("exposure"), Source::Options);
        EXPECT_EQ(s.config, file);
    }
}

TEST_F(SettingsFile, ErrorsNameFileLineAndColumn) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"\nexposur = 1\n", ": line 2, column 11: exposur: no such setting (did you mean exposure?)"},
        {"exposure = -1\n", ": line 1, column 12: exposure: cannot be \"-1\" (use <number>, 0 to 1000)"},
        {"exposure = [1]\n", ": line 1, column 12: exposure has a value of the wrong kind (use <number>)"},
        {"exposure = 2001-01-01\n", ": line 1, column 12: exposure has a value of the wrong kind (use <number>)"},
        {"game = [\"a\"]\n", ": line 1, column 8: game has a value of the wrong kind (use <folder>)"},
        {"[photons]\nseed = 1\n", ": line 1, column 1: [photons] is a table (settings are flat: key = value)"},
        {"config = \"x.toml\"\n", ": line 1, column 10: config: a file cannot name another file"},
    };
    for (const auto& [text, message] : cases) {
        Settings s;
        const std::string file = write(text);
        const Result<bool> read = s.readFile(file);
        ASSERT_FALSE(read) << text;
        EXPECT_EQ(read.error().message(), file + message);
        EXPECT_THAT(s.effective(), IsEmpty());
    }
    Settings s;
    const std::string broken = write("seed = 1\nexposure = = 2\n");
    const Result<bool> read = s.readFile(broken);
    ASSERT_FALSE(read);
    EXPECT_THAT(read.error().message(), HasSubstr(broken + ": line 2, column "));
    EXPECT_EQ(s.seed, 0U);
}

TEST_F(SettingsFile, UnreadableFilesAreErrors) {
    Settings s;
    for (const std::string& path : {below("none.toml"), below("")}) {
        const Result<bool> read = s.setOptions("config=" + path);
        ASSERT_FALSE(read) << path;
        EXPECT_THAT(read.error().message(), HasSubstr(path + ": cannot be read"));
    }
}

// doc/settings.md is the table. PIE_UPDATE_DOC=1 writes it.
TEST(SettingsPage, IsWhatTheDocumentationSays) {
    const std::filesystem::path file = std::filesystem::path(PIE_SOURCE_DIR) / "doc" / "settings.md";
    if (std::getenv("PIE_UPDATE_DOC") != nullptr) {
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file) << settingsPage();
    }
    EXPECT_EQ(test::readText(file), settingsPage())
        << "doc/settings.md is stale. Run: PIE_UPDATE_DOC=1 build/release/bin/engine_tests "
           "--gtest_filter='SettingsPage.*'";
}

TEST(Settings, PresetsSayWhatNobodySetAndGiveWayToWhoeverDoes) {
    Settings settings;
    ASSERT_TRUE(settings.set("max_edge", "48", Source::File));
    ASSERT_TRUE(settings.set("preset", "draft", Source::Level));
    EXPECT_EQ(settings.gatherRays, 64);
    EXPECT_EQ(settings.maxEdge, 48.0F);
    EXPECT_EQ(settings.origin("gather_rays"), Source::Preset);
    ASSERT_TRUE(settings.set("photons_from_light", "777", Source::Level));
    ASSERT_TRUE(settings.set("preset", "accurate", Source::CommandLine));
    EXPECT_EQ(settings.gatherRays, 256);
    EXPECT_EQ(settings.directTolerance, 0.5F);
    EXPECT_EQ(settings.photonsFromLight, 777);
    EXPECT_EQ(settings.stillFrames, 100) << "of the draft nothing stays";
    const Result<bool> late = settings.set("preset", "draft", Source::Options);
    ASSERT_TRUE(late);
    EXPECT_FALSE(*late);
    EXPECT_EQ(settings.gatherRays, 256);
    ASSERT_TRUE(settings.set("preset", "none", Source::CommandLine));
    EXPECT_EQ(settings.gatherRays, Settings{}.gatherRays);
    EXPECT_EQ(settings.origin("gather_rays"), Source::Default);
    EXPECT_FALSE(settings.set("preset", "best", Source::CommandLine));
}

TEST(Settings, BudgetAndTargetChooseWhatNobodySet) {
    Settings settings;
    const Settings as = chosen(settings);
    EXPECT_EQ(as.effective(), settings.effective());
    settings.budgetMs = 8;
    EXPECT_EQ(chosen(settings).maxTriangles, 96'000);
    EXPECT_EQ(chosen(settings).maxEdge, 32.0F);
    ASSERT_TRUE(settings.set("max_edge", "20", Source::Options));
    EXPECT_EQ(chosen(settings).maxEdge, 20.0F);
    EXPECT_EQ(chosen(settings).maxTriangles, settings.maxTriangles);
    settings.targetError = 1;
    EXPECT_TRUE(chosen(settings).standardErrors);
    EXPECT_EQ(chosen(settings).gatherRays, 1024);
    settings.targetError = 0.1F;
    EXPECT_EQ(chosen(settings).gatherRays, 4096);
    ASSERT_TRUE(settings.set("gather_rays", "64", Source::File));
    EXPECT_EQ(chosen(settings).gatherRays, 64);
}

} // namespace
} // namespace pie::engine
