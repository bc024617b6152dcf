// How the rows of the table turn text into fields and back.

#include "pie/engine/settings_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace pie::engine::table {
namespace {

template <class... Ts> struct Overloaded : Ts... { using Ts::operator()...; };
template <class... Ts> Overloaded(Ts...) -> Overloaded<Ts...>;

using Bool = bool Settings::*;
using Int = int Settings::*;
using Float = float Settings::*;
using Seed = std::uint64_t Settings::*;
using List = std::vector<std::string> Settings::*;

/// The whole text as a number.
template <class T> std::optional<T> number(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    T value{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end) return std::nullopt;
    return value;
}

std::optional<bool> truth(std::string_view text) {
    for (const std::string_view yes : {"true", "on", "yes", "1"})
        if (text == yes) return true;
    for (const std::string_view no : {"false", "off", "no", "0"})
        if (text == no) return false;
    return std::nullopt;
}

Error bad(const Row& row, std::string_view text) {
    const std::string allowed = range(row);
    return {"", std::string(row.key), fmt::format("cannot be \"{}\"", text.substr(0, 80)),
            "use " + syntax(row) + (allowed.empty() ? "" : ", " + allowed)};
}

template <class T> bool within(const Row& row, T value) {
    return static_cast<double>(value) >= row.lowest && static_cast<double>(value) <= row.highest;
}

std::vector<std::string> split(std::string_view text) {
    std::vector<std::string> parts;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(':'), text.size());
        if (end > 0) parts.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return parts;
}

} // namespace

Result<bool> write(const Row& row, std::string_view text, Settings& settings) {
    const auto assign = [&](auto member, const auto& parsed) -> Result<bool> {
        if (!parsed) return bad(row, text);
        settings.*member = *parsed;
        return true;
    };
    return std::visit(
        Overloaded{
            [&](Bool member) { return assign(member, truth(text)); },
            [&](Int member) {
                auto value = number<int>(text);
                if (value && !within(row, *value)) value.reset();
                return assign(member, value);
            },
            [&](Float member) {
                auto value = number<float>(text);
                // The bounds are compared as floats: 0.001 is allowed where the lowest is 0.001.
                if (value && !(*value >= static_cast<float>(row.lowest) && *value <= static_cast<float>(row.highest)))
                    value.reset();
                return assign(member, value);
            },
            [&](Seed member) { return assign(member, number<std::uint64_t>(text)); },
            [&](List member) {
                settings.*member = split(text);
                return Result<bool>(true);
            },
            [&](const Path& path) {
                settings.*path.field = text;
                return Result<bool>(true);
            },
            [&](const Choice& choice) -> Result<bool> {
                const auto found = std::find(choice.names.begin(), choice.names.end(), text);
                if (found == choice.names.end()) return bad(row, text);
                choice.write(settings, static_cast<std::size_t>(found - choice.names.begin()));
                return true;
            },
        },
        row.field);
}

std::string read(const Row& row, const Settings& settings) {
    return std::visit(Overloaded{
                          [&](Bool member) -> std::string { return settings.*member ? "true" : "false"; },
                          [&](List member) { return fmt::format("{}", fmt::join(settings.*member, ":")); },
                          [&](const Path& path) { return settings.*path.field; },
                          [&](const Choice& choice) { return std::string(choice.names[choice.read(settings)]); },
                          [&](auto member) { return fmt::format("{}", settings.*member); },
                      },
                      row.field);
}

std::string syntax(const Row& row) {
    return std::visit(Overloaded{
                          [](Bool) -> std::string { return "true|false"; },
                          [](Int) -> std::string { return "<integer>"; },
                          [](Seed) -> std::string { return "<integer>"; },
                          [](Float) -> std::string { return "<number>"; },
                          [](List) -> std::string { return "<folder>:<folder>"; },
                          [](const Path& path) -> std::string { return path.folder ? "<folder>" : "<file>"; },
                          [](const Choice& choice) { return fmt::format("{}", fmt::join(choice.names, "|")); },
                      },
                      row.field);
}

std::string range(const Row& row) {
    if (std::holds_alternative<Seed>(row.field)) return "0 or more";
    if (!std::holds_alternative<Int>(row.field) && !std::holds_alternative<Float>(row.field)) return {};
    const bool open = row.highest >= std::numeric_limits<int>::max();
    return open ? fmt::format("{} or more", row.lowest) : fmt::format("{} to {:.10g}", row.lowest, row.highest);
}

} // namespace pie::engine::table
