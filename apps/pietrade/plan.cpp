#include "apps/pietrade/plan.h"

#include "pie/sampling/hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace pietrade {
namespace {

using pie::engine::Settings;
using pie::engine::Source;

bool fixed(const Settings& base, std::string_view key) { return base.origin(key) >= Source::File; }

/// Few digits, so that a settings line can be read and typed.
std::string number(double value, bool whole) {
    const double digits = std::pow(10.0, std::floor(std::log10(value)) - 1);
    const double rounded = std::round(value / digits) * digits;
    return fmt::format("{:.6g}", whole ? std::max(1.0, std::round(rounded)) : rounded);
}

double baseNumber(const Ground& ground, std::string_view key) {
    if (key == "texel_size" && ground.base.texelSize == 0.0F) return ground.texelEdge;
    return std::strtod(ground.base.value(key).c_str(), nullptr);
}

// Sweeps

struct Wanted {
    const char* key;
    const char* with;
    std::vector<std::string> values;
};

std::vector<std::string> multiples(const Ground& ground, std::string_view key, const std::vector<double>& factors) {
    std::vector<std::string> values;
    for (const double factor : factors) {
        const std::string base = ground.base.value(key);
        values.push_back(factor == 1.0 ? base : number(factor * baseNumber(ground, key), false));
    }
    return values;
}

std::vector<Wanted> allSweeps(const Ground& g) {
    std::vector<std::string> threads;
    for (unsigned t = 1; t < g.cores; t *= 2) threads.push_back(std::to_string(t));
    threads.push_back(std::to_string(g.cores));
    return {{"estimator", "", {"gather", "true_area", "nearest"}},
            {"photons_from_light", "", {"1000", "2500", "10000", "25000", g.quick ? "50000" : "100000"}},
            {"gather_rays", "", {"32", "64", "128", "256", "512", "1024"}},
            {"texel_size", "", multiples(g, "texel_size", {0.25, 0.5, 1, 2})},
            {"still_frames", "", {"3", "10", "30", "100", "300"}},
            {"refine_rays", "", {"50000", "200000", "1000000"}},
            {"accumulation_frames", "estimator=true_area", {"1", "3", "10", "30"}},
            {"max_search_count", "estimator=true_area", {"25", "50", "100", "200", "400"}},
            {"direct_tolerance", "", {"0.1", "0.5", "2", "8"}},
            {"direct_samples", "", {"4", "16", "64", "256"}},
            {"direct_light", "", {"shadow_rays", "photons"}},
            {"direct_light", "estimator=true_area", {"shadow_rays", "photons"}},
            {"texel_light", "", {"auto", "shadow_rays", "photons"}},
            {"max_edge", "", multiples(g, "max_edge", {0.5, 0.71, 1, 2, 4})},
            {"threads", "", std::move(threads)}};
}

bool isNumber(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789.e+-") == std::string::npos;
}

/// By size, and the base's own value among them.
void complete(const Ground& ground, Wanted& sweep) {
    const std::string own = ground.base.value(sweep.key);
    const bool threads = std::string_view(sweep.key) == "threads";
    const bool there = threads ? true : std::find(sweep.values.begin(), sweep.values.end(), own) != sweep.values.end();
    if (!there) sweep.values.push_back(own);
    if (std::string_view(sweep.key).ends_with("_frames"))
        std::erase_if(sweep.values, [&](const std::string& value) {
            return value != own && std::strtod(value.c_str(), nullptr) > static_cast<double>(ground.mostFrames);
        });
    const auto size = [&](const std::string& value) {
        return value == own ? baseNumber(ground, sweep.key) : std::strtod(value.c_str(), nullptr);
    };
    if (std::all_of(sweep.values.begin(), sweep.values.end(), isNumber))
        std::stable_sort(sweep.values.begin(), sweep.values.end(),
                         [&](const std::string& a, const std::string& b) { return size(a) < size(b); });
    sweep.values.erase(std::unique(sweep.values.begin(), sweep.values.end()), sweep.values.end());
    if (!ground.quick || sweep.values.size() <= 3 || !isNumber(own)) return;
    // Quick: the ends and the base, or the middle where that is an end.
    std::vector<std::string> few{sweep.values.front(), own, sweep.values.back()};
    if (own == few.front() || own == few.back()) few[1] = sweep.values[sweep.values.size() / 2];
    sweep.values = few;
}

// Random settings

struct Axis {
    std::string key;
    double low = 1, high = 1; ///< both included, evenly spread in the logarithm
    enum class Kind : std::uint8_t { Real, Whole, PowerOfTwo } kind = Kind::Real;

    [[nodiscard]] std::string at(double share) const {
        const double value = low * std::pow(high / low, share);
        if (kind == Kind::PowerOfTwo) return fmt::format("{:.0f}", std::exp2(std::round(std::log2(value))));
        return number(value, kind == Kind::Whole);
    }
};

std::vector<Axis> axes(const Ground& g, bool gathers) {
    using Kind = Axis::Kind;
    const double edge = baseNumber(g, "max_edge");
    std::vector<Axis> all{{"photons_from_light", 1000, 100'000, Kind::Whole},
                          {"max_edge", 0.5 * edge, 4 * edge, Kind::Real},
                          {"direct_tolerance", 0.25, 8, Kind::Real},
                          {"direct_samples", 4, 64, Kind::PowerOfTwo}};
    if (gathers) {
        const double texel = baseNumber(g, "texel_size");
        all.insert(all.end(), {{"gather_rays", 32, 1024, Kind::PowerOfTwo},
                               {"texel_size", 0.25 * texel, 2 * texel, Kind::Real},
                               {"still_frames", 8, 300, Kind::Whole}});
    } else {
        all.insert(all.end(),
                   {{"max_search_count", 25, 400, Kind::Whole}, {"accumulation_frames", 1, 30, Kind::Whole}});
    }
    std::erase_if(all, [&](const Axis& axis) { return fixed(g.base, axis.key); });
    return all;
}

Settings valid(const Settings& base, const std::vector<std::string>& pairs) {
    Settings settings = base;
    for (const std::string& pair : pairs) (void)settings.setPair(pair, Source::CommandLine); // out of range: the base's
    return settings;
}

std::vector<std::string> hypercube(const Ground& ground, const char* estimator, std::size_t count, std::uint64_t salt) {
    const bool gathers = std::string_view(estimator) == "gather";
    const std::vector<Axis> all = axes(ground, gathers);
    std::vector<std::string> result;
    for (std::uint64_t i = 0; i < count; ++i) {
        std::vector<std::string> pairs{fmt::format("estimator={}", estimator)};
        for (std::uint64_t a = 0; a < all.size(); ++a) {
            const std::uint64_t key = pie::sampling::mix(ground.seed ^ salt) + a;
            const auto span = static_cast<double>(pie::sampling::permuted(i, count, pie::sampling::mix(key)));
            const double share = (span + double{pie::sampling::hash01(key, i)}) / static_cast<double>(count);
            pairs.push_back(all[a].key + '=' + all[a].at(share));
        }
        result.push_back(difference(ground.base, valid(ground.base, pairs)));
    }
    return result;
}

} // namespace

std::vector<Sweep> sweeps(const Ground& ground) {
    std::vector<Sweep> result;
    for (Wanted& wanted : allSweeps(ground)) {
        if (fixed(ground.base, wanted.key)) continue;
        if (*wanted.with != '\0' && fixed(ground.base, "estimator")) continue;
        complete(ground, wanted);
        Sweep sweep{wanted.key, wanted.with, wanted.values, {}};
        for (const std::string& value : wanted.values) {
            std::vector<std::string> pairs{std::string(wanted.key) + '=' + value};
            if (*wanted.with != '\0') pairs.emplace_back(wanted.with);
            sweep.settings.push_back(difference(ground.base, valid(ground.base, pairs)));
        }
        result.push_back(std::move(sweep));
    }
    return result;
}

std::vector<std::string> randomSettings(const Ground& ground) {
    if (fixed(ground.base, "estimator"))
        return hypercube(ground, ground.base.value("estimator").c_str(), ground.random, 1);
    // The photon map is seldom on the front, but where it is the user should know.
    const std::size_t map = ground.random / 5;
    std::vector<std::string> result = hypercube(ground, "gather", ground.random - map, 1);
    const std::vector<std::string> more = hypercube(ground, "true_area", map, 2);
    result.insert(result.end(), more.begin(), more.end());
    return result;
}

std::vector<std::string> nearSettings(const Ground& ground, const std::vector<std::string>& best,
                                      const std::vector<std::string>& known, std::size_t count) {
    std::vector<std::string> result;
    for (std::uint64_t turn = 0; result.size() < count && turn < 8 * count; ++turn) {
        const Settings from = changed(ground.base, best[turn % best.size()]);
        const std::vector<Axis> all = axes(ground, from.estimator == pie::engine::EstimatorKind::Gather);
        if (all.empty()) break;
        const std::uint64_t draw = pie::sampling::mix(ground.seed ^ (turn + 77));
        const Axis& axis = all[draw % all.size()];
        double value = std::strtod(from.value(axis.key).c_str(), nullptr);
        if (value == 0.0) value = baseNumber(ground, axis.key);
        const double step = std::pow(axis.high / axis.low, 0.2);
        const double moved = std::clamp(value * ((draw >> 32U & 1U) != 0 ? step : 1 / step), axis.low, axis.high);
        const double share = std::log(moved / axis.low) / std::log(axis.high / axis.low);
        const std::string candidate = difference(ground.base, valid(from, {axis.key + '=' + axis.at(share)}));
        const auto in = [&](const std::vector<std::string>& list) {
            return std::find(list.begin(), list.end(), candidate) != list.end();
        };
        if (!in(known) && !in(result)) result.push_back(candidate);
    }
    return result;
}

Settings changed(const Settings& base, std::string_view difference) {
    Settings settings = base;
    (void)settings.setOptions(difference, Source::CommandLine);
    return settings;
}

std::string difference(const Settings& base, const Settings& settings) {
    std::string text;
    for (const pie::engine::SettingInfo& info : pie::engine::describe()) {
        const std::string value = settings.value(info.key);
        if (value == base.value(info.key)) continue;
        text += fmt::format("{}{}={}", text.empty() ? "" : " ", info.key, value);
    }
    return text;
}

std::string optionString(const Settings& settings) { return difference(Settings(), settings); }

} // namespace pietrade
