#include "apps/pieprobe/points.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

namespace pieprobe {
namespace {

namespace fs = std::filesystem;
using pie::Error;
using pie::Result;

constexpr std::array<std::string_view, 6> columnNames{"x", "y", "z", "nx", "ny", "nz"};

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view blank = " \t\r\"";
    const std::size_t first = text.find_first_not_of(blank);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string_view> cells(std::string_view line) {
    std::vector<std::string_view> result;
    for (;;) {
        const std::size_t comma = line.find(',');
        result.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return result;
        line.remove_prefix(comma + 1);
    }
}

/// Numbers of the six columns, from the header.
Result<std::array<std::size_t, 6>> placesOf(const std::string& file, const std::vector<std::string_view>& header,
                                            std::vector<std::string>& ignored) {
    std::array<std::size_t, 6> places{};
    std::array<bool, 6> found{};
    for (std::size_t c = 0; c < header.size(); ++c) {
        const auto name = std::find(columnNames.begin(), columnNames.end(), header[c]);
        if (name == columnNames.end()) {
            ignored.emplace_back(header[c]);
            continue;
        }
        const auto i = static_cast<std::size_t>(name - columnNames.begin());
        if (found[i])
            return Error{file, fmt::format("line 1, column {}", c + 1), fmt::format("a second {}", *name), ""};
        found[i] = true;
        places[i] = c;
    }
    for (std::size_t i = 0; i < 6; ++i)
        if (!found[i])
            return Error{file, "line 1", fmt::format("there is no column {}", columnNames[i]),
                         "the first line names the columns, with x,y,z,nx,ny,nz among them"};
    return places;
}

/// strtod's grammar without its locale; "nan" and "inf" are numbers that are refused later, per point.
bool readNumber(std::string_view text, float& value) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    double wide = 0;
    const auto [end, problem] = std::from_chars(text.begin(), text.end(), wide);
    if (end != text.end() || (problem != std::errc() && problem != std::errc::result_out_of_range)) return false;
    value = problem == std::errc() ? static_cast<float>(wide) : std::numeric_limits<float>::infinity();
    return true;
}

} // namespace

Result<Points> readPoints(const fs::path& file) {
    const std::string name = file.string();
    std::ifstream stream(file, std::ios::binary);
    if (!stream || fs::is_directory(file)) return Error{name, "", "cannot be read", "is it there?"};
    Points result;
    std::string line;
    std::size_t number = 0;
    std::optional<std::array<std::size_t, 6>> places;
    std::size_t width = 0;
    while (std::getline(stream, line)) {
        ++number;
        std::string_view text = line;
        if (number == 1 && text.substr(0, 3) == "\xef\xbb\xbf") text.remove_prefix(3);
        if (trimmed(text).empty()) continue;
        const auto columns = cells(text);
        if (!places) {
            auto header = placesOf(name, columns, result.ignored);
            if (!header) return header.error();
            places = *header;
            width = columns.size();
            continue;
        }
        if (columns.size() != width)
            return Error{name, fmt::format("line {}", number),
                         fmt::format("has {} columns, the header {}", columns.size(), width), ""};
        Point point;
        point.line = number;
        for (std::size_t i = 0; i < 6; ++i) {
            const std::string_view cell = columns[(*places)[i]];
            float& value = i < 3 ? point.position[static_cast<int>(i)] : point.normal[static_cast<int>(i) - 3];
            if (!readNumber(cell, value))
                return Error{name, fmt::format("line {}, column {} ({})", number, (*places)[i] + 1, columnNames[i]),
                             fmt::format("\"{}\" is not a number", cell), ""};
            point.text[i] = cell;
        }
        result.points.push_back(std::move(point));
    }
    if (!places) return Error{name, "", "is empty", "the first line names the columns: x,y,z,nx,ny,nz"};
    return result;
}

const char* statusName(Status status) {
    switch (status) {
    case Status::Ok: return "ok";
    case Status::OffSurface: return "off_surface";
    case Status::BadNormal: return "bad_normal";
    case Status::NotFinite: return "not_finite";
    case Status::TargetNotReached: return "target_not_reached";
    }
    return "";
}

std::optional<Error> OutFile::open(const fs::path& target) {
    target_ = target;
    if (fs::is_directory(target)) return Error{target.string(), "", "is a folder", ""};
    part_ = target.string() + fmt::format(".{}.part", getpid());
    const std::ofstream file(part_);
    if (file) return {};
    const std::string place = target.string();
    part_.clear();
    return Error{place, "", "cannot be written", "is the folder there, and is it yours?"};
}

std::optional<Error> OutFile::write(const std::string& content) {
    std::ofstream file(part_, std::ios::binary);
    file << content;
    file.close();
    if (!file) return Error{target_.string(), "", "cannot be written", "is the disk full?"};
    std::error_code error;
    fs::rename(part_, target_, error);
    if (error) {
        const Error problem{target_.string(), "", error.message(), "the result lies in " + part_.string()};
        part_.clear();
        return problem;
    }
    part_.clear();
    return {};
}

OutFile::~OutFile() {
    std::error_code ignored;
    if (!part_.empty()) fs::remove(part_, ignored);
}

std::string outText(const std::vector<Point>& points, const std::vector<Answer>& answers) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    fmt::format_to(to, "x,y,z,nx,ny,nz,Er,Eg,Eb,stderr,photons,radius,bias,status\n");
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (const std::string& number : points[i].text) fmt::format_to(to, "{},", number);
        const Answer& a = answers[i];
        if (a.known)
            fmt::format_to(to, "{:.9g},{:.9g},{:.9g},{:.4g},{},{:.6g},{:.4g},", a.irradiance[0], a.irradiance[1],
                           a.irradiance[2], a.standardError, a.photons, a.radius, a.bias);
        else
            fmt::format_to(to, ",,,,,,,");
        fmt::format_to(to, "{}\n", statusName(a.status));
    }
    return fmt::to_string(text);
}

} // namespace pieprobe
