#include "apps/piebench/reference.h"

#include "apps/piebench/frames.h"
#include "pie/core/clock.h"
#include "pie/core/whole_file.h"
#include "pie/intersect/intersector.h"
#include "pie/reference/path_tracer.h"
#include "pie/sampling/hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <sstream>
#include <string>
#include <variant>

namespace piebench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t version = 1; // of what is computed and how it is written

/// A hash of numbers in order.
class Key {
public:
    void add(std::uint64_t number) { state_ = pie::sampling::mix(state_ ^ number); }
    void add(float number) { add(std::uint64_t{std::bit_cast<std::uint32_t>(number)}); }
    void add(double number) { add(std::bit_cast<std::uint64_t>(number)); }
    void add(const pie::Vec3& vector) {
        for (int c = 0; c < 3; ++c) add(vector[c]);
    }
    void add(const pie::lights::Falloff& falloff) {
        for (const float number :
             {falloff.extraDistance, falloff.minDistance, falloff.angleScale, falloff.linearIntensity, falloff.fade})
            add(number);
        add(std::uint64_t{falloff.noCosine} * 2 + std::uint64_t{falloff.linear});
    }
    void add(const pie::lights::PointLight& light) {
        add(light.position);
        add(light.power);
        add(light.falloff);
    }
    void add(const pie::lights::SphereLight& light) {
        add(light.position);
        add(light.power);
        add(light.radius);
        add(light.falloff);
    }
    void add(const pie::lights::SpotLight& light) {
        add(light.position);
        add(light.direction);
        add(light.power);
        add(light.slope);
        add(light.rim);
        add(light.falloff);
    }
    void add(const pie::lights::SunLight& light) {
        add(light.towards);
        add(light.irradiance);
        add(light.devianceRadians);
    }
    void add(const pie::lights::AreaLight& light) {
        for (const pie::Vec3& corner : light.corners) add(corner);
        add(light.radiosity);
        add(std::uint64_t{light.twoSided});
    }
    void add(const pie::lights::SkyLight& light) {
        for (const pie::Vec3& towards : light.towards) add(towards);
        add(light.irradiance);
    }
    void add(const pie::scene::Material& material) {
        add(material.reflectance);
        add(static_cast<std::uint64_t>(material.interaction) * 4 + std::uint64_t{material.twoSided} * 2 +
            std::uint64_t{material.alphaOnly});
        if (material.filter == nullptr) return;
        add(static_cast<std::uint64_t>(material.filter->width));
        add(static_cast<std::uint64_t>(material.filter->height));
        for (const pie::Rgba8& pixel : material.filter->pixels)
            for (int c = 0; c < 4; ++c) add(std::uint64_t{pixel[c]});
    }
    void add(const pie::scene::Scene& scene) {
        for (const pie::Vec3& position : scene.positions) add(position);
        for (const pie::scene::Triangle& triangle : scene.triangles) {
            for (const std::uint32_t vertex : triangle.vertices) add(std::uint64_t{vertex});
            add(std::uint64_t{triangle.material});
        }
        for (const pie::scene::Material& material : scene.materials) add(material);
    }
    [[nodiscard]] std::string text() const { return fmt::format("{:016x}", state_); }

private:
    std::uint64_t state_ = version;
};

/// Spread over the receivers in the order of the mesh, the same for the same receivers.
std::vector<std::uint32_t> sampled(std::size_t receivers, std::size_t wanted) {
    std::vector<std::uint32_t> chosen(std::min(receivers, wanted));
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        const std::size_t first = i * receivers / chosen.size();
        const std::size_t next = (i + 1) * receivers / chosen.size();
        chosen[i] = static_cast<std::uint32_t>(first + pie::sampling::mix(i) % (next - first));
    }
    return chosen;
}

std::string keyOf(const Subject& subject, const std::vector<std::uint32_t>& receivers,
                  const ReferenceOptions& options) {
    Key key;
    key.add(*subject.of->scene);
    for (const pie::lights::Light& light : subject.of->lights) {
        key.add(std::uint64_t{light.index()});
        std::visit([&](const auto& kind) { key.add(kind); }, light);
    }
    for (const std::uint32_t r : receivers) {
        const pie::scene::Receiver& at = subject.receivers.points[r];
        key.add(at.position);
        key.add(at.normal);
        key.add(at.inset);
        key.add(std::uint64_t{at.twoSided});
    }
    key.add(options.target);
    key.add(options.mostPaths);
    return key.text();
}

std::string headOf(const std::string& key, std::size_t count) {
    return fmt::format("piebench reference {} {} {}", version, key, count);
}

/// False where the file is missing or is not what was written.
bool read(Reference& reference, const std::string& head) {
    std::ifstream file(reference.file);
    std::string line;
    if (!std::getline(file, line) || line != head) return false;
    file >> reference.seconds >> reference.reached;
    for (std::size_t i = 0; i < reference.receivers.size(); ++i) {
        double irradiance = 0;
        double error = 0;
        if (!(file >> irradiance >> error) || !std::isfinite(irradiance) || !std::isfinite(error)) return false;
        reference.irradiance.push_back(irradiance);
        reference.standardError.push_back(error);
    }
    std::string end;
    return file >> end && end == "end";
}

std::optional<pie::Error> write(const Reference& reference, const std::string& head) {
    std::error_code ignored;
    fs::create_directories(reference.file.parent_path(), ignored);
    std::string text = fmt::format("{}\n{:.3f} {}\n", head, reference.seconds, reference.reached);
    for (std::size_t i = 0; i < reference.receivers.size(); ++i)
        text += fmt::format("{:.17g} {:.9g}\n", reference.irradiance[i], reference.standardError[i]);
    if (!pie::writeWhole(reference.file, text + "end\n")) return {};
    return pie::Error{reference.file.string(), "", "cannot be written", "--cache names another folder"};
}

} // namespace

fs::path defaultFolder() {
    const auto variable = [](const char* name) {
        const char* const value = std::getenv(name); // NOLINT(concurrency-mt-unsafe): nothing sets it
        return fs::path(value != nullptr ? value : "");
    };
    if (const fs::path cache = variable("XDG_CACHE_HOME"); cache.is_absolute()) return cache / "piebench";
    if (const fs::path home = variable("HOME"); home.is_absolute()) return home / ".cache" / "piebench";
    std::error_code ignored;
    return fs::temp_directory_path(ignored) / "piebench";
}

pie::Result<Reference> reference(const Subject& subject, const pie::engine::Settings& settings,
                                 const ReferenceOptions& options,
                                 const std::function<void(std::size_t, std::size_t)>& progress) {
    Reference reference;
    reference.receivers = sampled(subject.receivers.points.size(), options.sample);
    const std::string key = keyOf(subject, reference.receivers, options);
    reference.file =
        (options.folder.empty() ? defaultFolder() : options.folder) / fmt::format("{}-{}.txt", subject.of->name, key);
    const std::string head = headOf(key, reference.receivers.size());
    if (read(reference, head)) {
        reference.kept = true;
        return reference;
    }
    reference.irradiance.clear();
    reference.standardError.clear();
    reference.reached = 0;
    const auto start = pie::Clock::now();
    const auto intersector =
        pie::intersect::makeIntersector(settings.intersector, *subject.of->scene, subject.of->level->tree);
    pie::reference::Options tracing;
    tracing.target = options.target;
    tracing.mostPaths = options.mostPaths;
    const pie::reference::PathTracer tracer(subject.of->scene, subject.of->lights, *intersector, tracing);
    std::vector<pie::scene::Receiver> points;
    for (const std::uint32_t r : reference.receivers) points.push_back(subject.receivers.points[r]);
    std::vector<pie::reference::Value> values(points.size());
    tracer.trace(points, values, [&](std::size_t count) { progress(count, points.size()); });
    for (const pie::reference::Value& value : values) {
        reference.irradiance.push_back((value.irradiance.x + value.irradiance.y + value.irradiance.z) / 3);
        reference.standardError.push_back(value.meanError);
        reference.reached += value.reached ? 1 : 0;
    }
    reference.seconds = pie::millisecondsSince(start) / 1000;
    if (auto problem = write(reference, head)) return *problem;
    return reference;
}

namespace {

/// Mean E over the points that see light, and how many those are.
std::pair<double, std::size_t> meanOf(const Reference& reference) {
    double sum = 0;
    std::size_t points = 0;
    for (const double e : reference.irradiance)
        if (e > 0) {
            sum += e;
            ++points;
        }
    return {points > 0 ? sum / static_cast<double>(points) : 0, points};
}

} // namespace

Errors errors(const Reference& reference, std::span<const pie::Rgb> answers) {
    Errors found;
    const auto [mean, points] = meanOf(reference);
    found.points = points;
    if (points == 0) return found;
    std::vector<double> relative;
    std::vector<double> squares;
    double sum = 0;
    for (std::size_t i = 0; i < reference.receivers.size(); ++i) {
        const double e = reference.irradiance[i];
        if (!(e > 0)) continue;
        const pie::Rgb& rgb = answers[reference.receivers[i]];
        const double answer = (double{rgb.x} + double{rgb.y} + double{rgb.z}) / 3;
        squares.push_back(std::pow((answer - e) / (e + 0.1 * mean), 2));
        relative.push_back(std::abs(answer / e - 1));
        sum += answer;
    }
    const auto count = static_cast<double>(points);
    std::sort(squares.begin(), squares.end());
    const auto mostOf = static_cast<std::ptrdiff_t>(points - points / 100);
    const double most = std::accumulate(squares.begin(), squares.begin() + mostOf, 0.0);
    found.rms99 = std::sqrt(most / static_cast<double>(mostOf));
    found.rms = std::sqrt(std::accumulate(squares.begin() + mostOf, squares.end(), most) / count);
    found.median = median(std::move(relative));
    found.mean = sum / count / mean - 1;
    return found;
}

double ownError(const Reference& reference) {
    const auto [mean, points] = meanOf(reference);
    double squares = 0;
    for (std::size_t i = 0; i < reference.receivers.size(); ++i)
        if (const double e = reference.irradiance[i]; e > 0)
            squares += std::pow(reference.standardError[i] / (e + 0.1 * mean), 2);
    return points > 0 ? std::sqrt(squares / static_cast<double>(points)) : 0;
}

} // namespace piebench
