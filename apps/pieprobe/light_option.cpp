#include "apps/pieprobe/light_option.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

namespace pieprobe {
namespace {

using pie::Error;
using pie::Result;
using pie::Rgb;
using pie::Vec3;
using pie::lights::Light;

constexpr float degrees = std::numbers::pi_v<float> / 180;
constexpr const char* pointForm = "point x y z r g b";
constexpr const char* sphereForm = "sphere x y z radius r g b";
constexpr const char* spotForm = "spot x y z dx dy dz degrees r g b";
constexpr const char* sunForm = "sun dx dy dz r g b [degrees]";
constexpr const char* areaForm = "area x1 y1 z1 x2 y2 z2 x3 y3 z3 … r g b";

std::vector<std::string_view> words(std::string_view text) {
    std::vector<std::string_view> result;
    constexpr std::string_view space = " \t\n\r,";
    for (std::size_t at = text.find_first_not_of(space); at != std::string_view::npos;
         at = text.find_first_not_of(space, at)) {
        const std::size_t end = std::min(text.find_first_of(space, at), text.size());
        result.push_back(text.substr(at, end - at));
        at = end;
    }
    return result;
}

/// The numbers behind the kind, and what is wrong with the first that is none.
struct Numbers {
    std::string_view text;
    const char* form = "";
    std::vector<float> values;

    [[nodiscard]] Error error(const std::string& reason) const {
        return {fmt::format("--light \"{}\"", text), "", reason, fmt::format("use \"{}\"", form)};
    }
    [[nodiscard]] Vec3 at(std::size_t first) const { return {values[first], values[first + 1], values[first + 2]}; }
    [[nodiscard]] std::optional<Error> read(const std::vector<std::string_view>& words) {
        for (std::size_t i = 1; i < words.size(); ++i) {
            float value = 0;
            const auto [end, problem] = std::from_chars(words[i].begin(), words[i].end(), value);
            if (problem != std::errc() || end != words[i].end() || !std::isfinite(value))
                return error(fmt::format("number {} is \"{}\"", i, words[i]));
            values.push_back(value);
        }
        return {};
    }
    [[nodiscard]] std::optional<Error> expect(std::size_t count) const {
        if (values.size() == count) return {};
        return error(fmt::format("has {} numbers, not {}", values.size(), count));
    }
    /// Watts, or irradiance of a sun.
    [[nodiscard]] std::optional<Error> checkColour(std::size_t first) const {
        for (std::size_t i = first; i < first + 3; ++i)
            if (values[i] < 0.0F) return error(fmt::format("number {} is negative, but light is not", i + 1));
        return {};
    }
    [[nodiscard]] std::optional<Error> checkDirection(std::size_t first) const {
        if (glm::length(at(first)) > 1e-30F) return {};
        return error("the direction is zero");
    }
};

Result<Light> point(const Numbers& n) {
    if (const auto wrong = n.expect(6)) return *wrong;
    if (const auto wrong = n.checkColour(3)) return *wrong;
    pie::lights::PointLight light;
    light.position = n.at(0);
    light.power = n.at(3);
    light.falloff.minDistance = 0;
    return Light(light);
}

Result<Light> sphere(const Numbers& n) {
    if (const auto wrong = n.expect(7)) return *wrong;
    if (const auto wrong = n.checkColour(4)) return *wrong;
    if (!(n.values[3] > 0.0F)) return n.error("the radius is not above zero");
    pie::lights::SphereLight light;
    light.position = n.at(0);
    light.radius = n.values[3];
    light.power = n.at(4);
    light.falloff.minDistance = 0;
    return Light(light);
}

Result<Light> spot(const Numbers& n) {
    if (const auto wrong = n.expect(10)) return *wrong;
    if (const auto wrong = n.checkColour(7)) return *wrong;
    if (const auto wrong = n.checkDirection(3)) return *wrong;
    if (!(n.values[6] > 0.0F && n.values[6] < 90.0F)) return n.error("the angle is not between 0 and 90 degrees");
    pie::lights::SpotLight light;
    light.position = n.at(0);
    light.direction = glm::normalize(n.at(3));
    light.slope = std::tan(n.values[6] * degrees);
    light.rim = 0;
    light.falloff.minDistance = 0;
    // The light's power is that of a full sphere as bright as the cone.
    const double half = std::sin(0.5 * static_cast<double>(n.values[6] * degrees));
    light.power = n.at(7) / static_cast<float>(half * half);
    return Light(light);
}

Result<Light> sun(const Numbers& n) {
    if (n.values.size() != 7)
        if (const auto wrong = n.expect(6)) return *wrong;
    if (const auto wrong = n.checkColour(3)) return *wrong;
    if (const auto wrong = n.checkDirection(0)) return *wrong;
    pie::lights::SunLight light;
    light.towards = glm::normalize(n.at(0));
    light.irradiance = n.at(3);
    if (n.values.size() == 7) {
        if (!(n.values[6] >= 0.0F && n.values[6] <= 90.0F)) return n.error("the angle is not between 0 and 90 degrees");
        light.devianceRadians = n.values[6] * degrees;
    }
    return Light(light);
}

Result<Light> area(const Numbers& n) {
    const std::size_t corners = n.values.size() / 3;
    if (n.values.size() % 3 != 0 || corners < 4)
        return n.error(fmt::format(
            "has {} numbers, not three for each of three corners or more and three for the watts", n.values.size()));
    if (const auto wrong = n.checkColour(n.values.size() - 3)) return *wrong;
    std::vector<Vec3> outline;
    for (std::size_t i = 0; i + 1 < corners; ++i) outline.push_back(n.at(3 * i));
    pie::lights::AreaLight light = pie::lights::makeAreaLight(outline, Rgb(0.0F));
    if (!(light.area > 0.0)) return n.error("the corners span no area");
    float size = 0;
    for (const Vec3& corner : outline) size = std::max(size, glm::length(corner - outline[0]));
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec3& here = outline[i];
        const Vec3& next = outline[(i + 1) % outline.size()];
        const Vec3& after = outline[(i + 2) % outline.size()];
        if (std::abs(glm::dot(here - outline[0], light.normal)) > 1e-3F * size)
            return n.error("the corners are not in a plane");
        if (glm::dot(glm::cross(next - here, after - next), light.normal) < -1e-4F * size * size)
            return n.error("the corners go inwards: cut the polygon into convex ones");
    }
    light.radiosity = n.at(n.values.size() - 3) / static_cast<float>(light.area);
    return Light(light);
}

} // namespace

std::string lightHelp() {
    return fmt::format("Lights, watts per channel r g b that leave the source:\n"
                       "  {:<50} in all directions\n"
                       "  {:<50} a sphere that shines as its centre would, with soft shadows\n"
                       "  {:<50} a cone of that half angle about d\n"
                       "  {:<50} parallel, from d: watts per square unit that faces it, through\n"
                       "  {:<50} sky surfaces; a disc of that half angle\n"
                       "  {:<50} a flat convex polygon, counter-clockwise from the side it lights\n",
                       pointForm, sphereForm, spotForm, sunForm, "", areaForm);
}

Result<Light> parseLight(std::string_view text) {
    struct Kind {
        std::string_view name;
        const char* form;
        Result<Light> (*read)(const Numbers&);
    };
    static constexpr Kind kinds[] = {{"point", pointForm, point},
                                     {"sphere", sphereForm, sphere},
                                     {"spot", spotForm, spot},
                                     {"sun", sunForm, sun},
                                     {"area", areaForm, area}};
    const auto parts = words(text);
    for (const Kind& kind : kinds) {
        if (parts.empty() || parts[0] != kind.name) continue;
        Numbers numbers{text, kind.form, {}};
        if (const auto wrong = numbers.read(parts)) return *wrong;
        return kind.read(numbers);
    }
    return Error{fmt::format("--light \"{}\"", text), "", "no such kind of light",
                 "use point, sphere, spot, sun or area"};
}

} // namespace pieprobe
