#include "apps/pietrade/subject.h"

#include "pie/brushes/load.h"
#include "pie/core/clock.h"
#include "pie/engine/options.h"
#include "pie/gather/texels.h"
#include "pie/lights/import.h"
#include "pie/lights/light_set.h"
#include "pie/sampling/sequence.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <filesystem>
#include <fstream>
#include <span>
#include <thread>

namespace pietrade {
namespace {

namespace fs = std::filesystem;

/// FNV-1a, 64 bits.
class Hash {
public:
    void bytes(std::span<const char> all) {
        for (const char c : all) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    }
    void number(std::uint32_t n) { bytes(std::bit_cast<std::array<char, sizeof n>>(n)); }
    void number(float n) { number(std::bit_cast<std::uint32_t>(n)); }
    void vector(const pie::Vec3& v) {
        for (int i = 0; i < 3; ++i) number(v[i]);
    }
    [[nodiscard]] std::string text() const { return fmt::format("{:016x}", value_); }

private:
    std::uint64_t value_ = 0xcbf29ce484222325U;
};

} // namespace

pie::Result<Subject> readSubject(const std::string& level, const pie::engine::Settings& settings) {
    const auto start = pie::Clock::now();
    const double cpu = pie::processorMilliseconds();
    const std::vector<fs::path> folders(settings.textures.begin(), settings.textures.end());
    auto location = pie::level::locate(level, settings.game, folders);
    if (!location) return location.error();
    pie::level::LoadOptions options;
    options.patchTolerance = settings.patchTolerance;
    options.deluxe = settings.deluxe;
    auto read = pie::brushes::loadLevel(std::move(*location), options);
    if (!read) return read.error();
    Subject subject;
    subject.level = std::make_shared<const pie::level::Level>(std::move(*read));
    subject.loadMs = pie::millisecondsSince(start);
    subject.loadProcessorMs = pie::processorMilliseconds() - cpu;
    subject.scene = std::make_shared<const pie::scene::Scene>(
        pie::scene::makeScene(*subject.level, pie::engine::sceneOptions(settings)));
    auto imported = pie::lights::importLights(*subject.level, *subject.scene, pie::engine::importOptions(settings));
    subject.lightSummary = imported.summary();
    subject.lights = std::move(imported.lights);
    subject.texelEdge = double{pie::gather::SurfaceTexels::automaticEdge(*subject.scene)};
    return subject;
}

std::string contentHash(const Subject& subject, const pie::engine::Settings& settings) {
    Hash hash;
    for (const pie::level::Vertex& v : subject.level->vertices) {
        hash.vector(v.position);
        hash.vector(v.normal);
    }
    for (const std::uint32_t index : subject.level->indices) hash.number(index);
    const pie::scene::Scene& scene = *subject.scene;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        for (int i = 0; i < 3; ++i) hash.vector(scene.corner(t, i));
        hash.vector(scene.material(t).reflectance);
        hash.number(static_cast<std::uint32_t>(scene.material(t).interaction));
    }
    // Lights by what they send out.
    const pie::lights::LightSet lights(subject.lights, subject.scene);
    const pie::sampling::Sequence sequence = pie::sampling::makeSequence(settings.lightDistribution, {});
    for (std::uint64_t i = 0; i < 4096 && !lights.empty(); ++i) {
        const pie::lights::Emission e = lights.emit(sequence, i);
        hash.vector(e.origin);
        hash.vector(e.direction);
        hash.vector(e.flux);
    }
    return hash.text();
}

std::string programVersion() {
    Hash hash;
    std::ifstream self("/proc/self/exe", std::ios::binary);
    std::vector<char> block(1 << 16);
    while (self) {
        self.read(block.data(), static_cast<std::streamsize>(block.size()));
        hash.bytes(std::span(block).first(static_cast<std::size_t>(self.gcount())));
    }
    return fmt::format("{} build {}", PIE_VERSION, hash.text());
}

std::string machine() {
    std::string model = "unknown processor";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos) {
            model = line.substr(line.find(": ") + 2);
            break;
        }
    return fmt::format("{}, {} threads", model, std::thread::hardware_concurrency());
}

} // namespace pietrade
