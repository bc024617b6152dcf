#include "apps/pietrade/kept.h"

#include "apps/pietrade/csv.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

namespace pietrade {
namespace {

namespace fs = std::filesystem;
using pie::Error;
using pie::Result;

constexpr const char* remedy = "name another folder with --out, or remove this one";

std::string headed(const char* title, const Identity& identity) {
    std::string text = fmt::format("# {}\n", title);
    for (const auto& [name, value] : identity) text += fmt::format("# {}: {}\n", name, value);
    return text;
}

/// Lines of a file one by one, with what to say about them.
class Lines {
public:
    explicit Lines(const fs::path& file) : name_(file.string()), stream_(file, std::ios::binary) {}

    [[nodiscard]] bool readable() const { return static_cast<bool>(stream_); }
    /// False at the end. A last line without an end was cut off and is damaged.
    [[nodiscard]] bool next() {
        if (!std::getline(stream_, text)) return false;
        ++number_;
        whole = !stream_.eof();
        return true;
    }
    [[nodiscard]] Error damaged(const std::string& why) const {
        return {name_, fmt::format("line {}", number_), why, remedy};
    }
    [[nodiscard]] Error foreign(const std::string& why) const { return {name_, "", why, remedy}; }

    std::string text;
    bool whole = true;

private:
    std::string name_;
    std::ifstream stream_;
    std::size_t number_ = 0;
};

/// The title, what the file was made of, and the line of column names.
Result<bool> readHead(Lines& lines, const char* title, const Identity& identity, std::string_view columnLine) {
    if (!lines.next() || lines.text != fmt::format("# {}", title))
        return lines.foreign(fmt::format("is no file of {}", title));
    for (const auto& [name, value] : identity) {
        const std::string front = fmt::format("# {}: ", name);
        if (!lines.next() || !lines.text.starts_with(front))
            return lines.damaged(fmt::format("does not say its {}", name));
        const std::string there = lines.text.substr(front.size());
        if (there != value)
            return lines.foreign(fmt::format(R"(was made with another {} ("{}", now "{}"))", name, there, value));
    }
    if (!lines.next() || lines.text != columnLine) return lines.damaged("does not name the columns of this version");
    return true;
}

std::string measurementColumns() {
    std::string line = "settings,stage";
    for (const Column& column : columns()) line += fmt::format(",{}", column.name);
    return line;
}

constexpr const char* measurementTitle = "pietrade measurements 1";
constexpr const char* truthTitle = "pietrade reference 1";
constexpr std::string_view truthColumns = "irradiance,stderr";

} // namespace

std::string measurementsText(const Identity& identity, const std::vector<Measurement>& all) {
    std::string text = headed(measurementTitle, identity) + measurementColumns() + '\n';
    for (const Measurement& m : all) {
        text += csvCell(m.settings) + ',' + csvCell(m.stage);
        for (const Column& column : columns()) text += ',' + csvNumber(m.*column.value);
        text += '\n';
    }
    return text;
}

Result<std::vector<Measurement>> readMeasurements(const fs::path& file, const Identity& identity) {
    std::vector<Measurement> all;
    std::error_code problem;
    if (!fs::exists(file, problem)) return all;
    Lines lines(file);
    if (!lines.readable() || fs::is_directory(file, problem)) return lines.foreign("cannot be read");
    if (auto head = readHead(lines, measurementTitle, identity, measurementColumns()); !head) return head.error();
    std::set<std::string> settings;
    while (lines.next()) {
        const auto cells = csvCells(lines.text);
        if (!lines.whole) return lines.damaged("is cut off");
        if (!cells || cells->size() != columns().size() + 2)
            return lines.damaged(fmt::format("has {} cells, not {}", cells ? cells->size() : 0, columns().size() + 2));
        Measurement& m = all.emplace_back();
        m.settings = (*cells)[0];
        m.stage = (*cells)[1];
        if (!settings.insert(m.settings).second) return lines.damaged("repeats the settings of another line");
        for (std::size_t i = 0; i < columns().size(); ++i) {
            const auto value = readNumber((*cells)[i + 2]);
            if (!value) return lines.damaged(fmt::format("\"{}\" is no {}", (*cells)[i + 2], columns()[i].name));
            m.*columns()[i].value = *value;
        }
    }
    return all;
}

std::string truthText(const Identity& identity, const std::vector<Truth>& all) {
    std::string text = headed(truthTitle, identity) + std::string(truthColumns) + '\n';
    for (const Truth& t : all) text += csvNumber(t.irradiance) + ',' + csvNumber(t.standardError) + '\n';
    return text;
}

Result<std::vector<Truth>> readTruth(const fs::path& file, const Identity& identity, std::size_t most) {
    std::vector<Truth> all;
    std::error_code problem;
    if (!fs::exists(file, problem)) return all;
    Lines lines(file);
    if (!lines.readable() || fs::is_directory(file, problem)) return lines.foreign("cannot be read");
    if (auto head = readHead(lines, truthTitle, identity, truthColumns); !head) return head.error();
    while (lines.next()) {
        const auto cells = csvCells(lines.text);
        if (!lines.whole) return lines.damaged("is cut off");
        if (!cells || cells->size() != 2 || (*cells)[0].empty() || (*cells)[1].empty())
            return lines.damaged("is not two numbers");
        const auto irradiance = readNumber((*cells)[0]);
        const auto standardError = readNumber((*cells)[1]);
        if (!irradiance || !standardError) return lines.damaged("is not two numbers");
        if (all.size() == most) return lines.damaged("is one too many");
        all.push_back({*irradiance, *standardError});
    }
    return all;
}

} // namespace pietrade
