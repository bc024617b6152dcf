#include "pie/engine/settings.h"

#include "pie/engine/settings_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace pie::engine {
namespace {

constexpr std::string_view blanks = " \t\r\n\f\v";

std::string_view nextWord(std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

/// A bare | would end a cell of a Markdown table.
std::string cell(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '|') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

Error unknownKey(std::string_view key) {
    return {"", std::string(key.substr(0, 80)), "no such setting",
            fmt::format("did you mean {}?", table::nearest(key))};
}

} // namespace

std::string_view sourceName(Source source) {
    switch (source) {
    case Source::Default: return "default";
    case Source::Preset: return "preset";
    case Source::Level: return "level";
    case Source::File: return "file";
    case Source::Options: return "options";
    case Source::CommandLine: return "command line";
    }
    return {};
}

Result<bool> Settings::set(std::string_view key, std::string_view value, Source source) {
    const auto index = table::find(key);
    if (!index) return unknownKey(key);
    const table::Row& row = table::rows()[*index];
    Settings changed = *this;
    if (Result<bool> written = table::write(row, value, changed); !written) return written;
    if (source < origin(key)) return false;
    if (key == "config" && !value.empty()) {
        if (source <= Source::File) return Error{"", "config", "a file cannot name another file", ""};
        if (Result<bool> read = changed.readFile(std::string(value)); !read) return read;
    }
    changed.origins_.resize(table::rows().size(), Source::Default);
    changed.origins_[*index] = source;
    if (key == "preset") changed.applyPreset();
    *this = std::move(changed);
    return true;
}

/// Every preset speaks of the same keys, so that one undoes the other.
void Settings::applyPreset() {
    struct Line {
        std::string_view key, draft, balanced, accurate;
    };
    static constexpr std::array<Line, 5> lines{{
        {"photons_from_light", "1000", "2500", "2500"},
        {"gather_rays", "64", "128", "256"},
        {"still_frames", "50", "100", "100"},
        {"direct_tolerance", "2", "1", "0.5"},
        {"max_edge", "128", "32", "24"},
    }};
    const Settings defaults;
    for (const Line& line : lines) {
        const std::size_t index = *table::find(line.key);
        if (origins_[index] > Source::Preset) continue;
        const std::array<std::string_view, 4> values{"", line.draft, line.balanced, line.accurate};
        const table::Row& row = table::rows()[index];
        const auto which = static_cast<std::size_t>(preset);
        const Result<bool> written =
            table::write(row, which == 0 ? table::read(row, defaults) : std::string(values.at(which)), *this);
        if (written) origins_[index] = which == 0 ? Source::Default : Source::Preset;
    }
}

Result<bool> Settings::setPair(std::string_view pair, Source source) {
    const std::size_t equals = pair.find('=');
    const std::string_view key = pair.substr(0, equals);
    if (equals != std::string_view::npos) return set(key, pair.substr(equals + 1), source);
    const auto index = table::find(key);
    if (!index) return unknownKey(key);
    const table::Row& row = table::rows()[*index];
    if (std::holds_alternative<bool Settings::*>(row.field)) return set(key, "true", source);
    return Error{"", std::string(key), "has no value", fmt::format("write {}={}", key, table::syntax(row))};
}

Result<bool> Settings::setOptions(std::string_view options, Source source) {
    Settings changed = *this;
    bool all = true;
    for (std::string_view word = nextWord(options); !word.empty(); word = nextWord(options)) {
        Result<bool> taken = changed.setPair(word, source);
        if (!taken) return taken;
        all = all && *taken;
    }
    *this = std::move(changed);
    return all;
}

Source Settings::origin(std::string_view key) const {
    const auto index = table::find(key);
    return index && *index < origins_.size() ? origins_[*index] : Source::Default;
}

std::string Settings::value(std::string_view key) const {
    const auto index = table::find(key);
    return index ? table::read(table::rows()[*index], *this) : std::string();
}

std::vector<std::string> Settings::effective(bool all) const {
    const Settings defaults;
    std::vector<std::string> lines;
    for (const table::Row& row : table::rows()) {
        const std::string now = table::read(row, *this);
        if (all || now != table::read(row, defaults))
            lines.push_back(fmt::format("{}={} ({})", row.key, now, sourceName(origin(row.key))));
    }
    return lines;
}

std::vector<std::string> Settings::warnings() const {
    std::vector<std::string> lines;
    const auto idle = [&](std::string_view key, bool does, std::string_view why) {
        if (origin(key) > Source::Level && !does) lines.push_back(fmt::format("{} has no effect: {}", key, why));
    };
    const bool roulette = scattering == photons::TracerOptions::Scattering::RussianRoulette;
    idle("diffuse_reflections", !roulette, "scattering is roulette");
    idle("max_search_radius", !useRadiusHeuristic, "use_radius_heuristic is on");
    idle("radius_heuristic_alpha", useRadiusHeuristic, "use_radius_heuristic is off");
    idle("snowball_radius", snowballSize > 1, "snowball_size is 1");
    idle("area", estimator == EstimatorKind::Nearest, "estimator is not nearest");
    idle("split_maps", estimator != EstimatorKind::Gather || finalGathering, "estimator = gather has no photon map");
    idle("progressive_alpha", searchRadius == gather::RadiusRule::Progressive, "search_radius is not progressive");
    idle("max_search_count", searchRadius != gather::RadiusRule::Fixed || useRadiusHeuristic, "search_radius is fixed");
    idle("use_sphere_slice", searchVolume == gather::SearchVolume::Slice, "search_volume is not slice");
    idle("sphere_slice", volume() != gather::SearchVolume::Sphere, "the search volume is a sphere");
    idle("use_incoming_direction", !usesTrueArea(), "true_area goes by normals");
    for (const std::string_view key : {"final_gathering_samples", "final_gathering_distance",
                                       "final_gathering_secondary", "precompute_irradiance", "irradiance_cache"})
        idle(key, finalGathering, "final_gathering is off");
    const bool gathers = estimator == EstimatorKind::Gather && !finalGathering;
    for (const std::string_view key :
         {"texel_size", "texel_light", "gather_rays", "refine_rays", "still_frames", "aimed_rays"})
        idle(key, gathers, "the estimator is not gather");
    if (gathers) idle("texel_light", directLight == DirectLight::ShadowRays, "direct_light is photons");
    idle("direct_samples", directLight == DirectLight::ShadowRays, "direct_light is photons");
    idle("direct_tolerance", directLight == DirectLight::ShadowRays, "direct_light is photons");
    idle("deluxe", view == View::Baked || viewsSwitch(), "view is not baked");
    if (view > View::Light && renderer == Renderer::Fixed)
        lines.push_back(fmt::format("view = {} needs renderer = glsl; lit is shown", value("view")));
    if (storeDirectLight && directLight == DirectLight::ShadowRays && !finalGathering)
        lines.emplace_back("store_direct_light costs time and shows nothing: direct_light is shadow_rays");
    if (storesDirectLight() && origin("store_direct_light") != Source::Default && !storeDirectLight)
        lines.push_back(fmt::format("store_direct_light is on in spite of the setting: {}",
                                    finalGathering ? "final_gathering needs it" : "direct_light is photons"));
    return lines;
}

std::span<const SettingInfo> describe() {
    static const std::vector<SettingInfo> infos = [] {
        const Settings defaults;
        std::vector<SettingInfo> all;
        for (const table::Row& row : table::rows())
            all.push_back({row.key, row.group, table::syntax(row), table::read(row, defaults), row.unit,
                           table::range(row), row.consequence, row.paper});
        return all;
    }();
    return infos;
}

std::string settingsPage() {
    std::string page =
        "# Settings\n\n"
        "Every parameter, as `key=value` after `-O` in an OSG program, after `--set` in ours, or as `key = value` in "
        "a TOML file\nthat `config=FILE` names (there, text stands in quotes). The command line wins over the option "
        "string, that over the file.\nNames follow the pi-engine paper (6.1) where it has one. Lengths are in level "
        "units; light is in lightmap units, of which\n64 show a texture as it is.\n";
    std::string_view group;
    for (const SettingInfo& info : describe()) {
        if (info.group != group) {
            group = info.group;
            page += fmt::format("\n## {}\n\n| key | values | default | what it does and costs | paper |\n"
                                "|---|---|---|---|---|\n",
                                group);
        }
        std::string values = fmt::format("`{}`", cell(info.syntax));
        if (!info.range.empty()) values += " " + info.range;
        if (!info.unit.empty()) values += fmt::format(" ({})", info.unit);
        const std::string initial = info.defaultValue.empty() ? "" : "`" + info.defaultValue + "`";
        page += fmt::format("| `{}` | {} | {} | {} | {} |\n", info.key, values, initial, info.consequence, info.paper);
    }
    return page;
}

} // namespace pie::engine
