#pragma once
// POINTS.csv and OUT.csv.

#include "pie/core/result.h"
#include "pie/core/vec.h"

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace pieprobe {

/// A line of POINTS, with its numbers as they were written.
struct Point {
    pie::Vec3 position{0.0F}, normal{0.0F};
    std::array<std::string, 6> text;
    std::size_t line = 0; ///< in the file, from 1
};
struct Points {
    std::vector<Point> points;
    std::vector<std::string> ignored; ///< columns that mean nothing here
};
/// A header with columns x, y, z, nx, ny, nz in any order, then a point a line. Errors name line and column.
[[nodiscard]] pie::Result<Points> readPoints(const std::filesystem::path& file);

enum class Status { Ok, OffSurface, BadNormal, NotFinite, TargetNotReached };
[[nodiscard]] const char* statusName(Status status);

/// What is said about a point; nothing where there is no answer.
struct Answer {
    Status status = Status::Ok;
    bool known = false;
    double irradiance[3]{}; ///< watts per square unit
    double standardError = 0, bias = 0;
    std::uint64_t photons = 0;
    double radius = 0;
};

/// A file that appears whole or not at all: written beside its target and renamed.
class OutFile {
public:
    /// Makes sure that the place can be written before anything is computed.
    [[nodiscard]] std::optional<pie::Error> open(const std::filesystem::path& target);
    [[nodiscard]] std::optional<pie::Error> write(const std::string& content);
    ~OutFile();

private:
    std::filesystem::path target_, part_;
};

[[nodiscard]] std::string outText(const std::vector<Point>& points, const std::vector<Answer>& answers);

} // namespace pieprobe
