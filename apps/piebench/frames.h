#pragma once
// One way from lights to vertex colours, frame by frame, with the time of each stage: what the ways have in common.
//
// A frame traces photons, builds what is searched, answers every question of the subject and copies the answers into
// vertex colours as the draw callback does; there is no OpenGL here, so sending them to a card is not in it. All ways
// trace the same photons: frame n has the indices n · emitted to (n + 1) · emitted − 1.

#include "apps/piebench/subject.h"

#include <glm/vec4.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace piebench {

/// Milliseconds of wall clock; `processor` is that of all threads together.
struct Stages {
    double trace = 0, build = 0, estimate = 0, upload = 0, total = 0, processor = 0;
};

struct Memory {
    double perVertex = 0; ///< bytes per receiver: receiver, what the estimator and direct light hold for it
    double perPhoton = 0; ///< bytes per photon in use
};

enum class Estimator : std::uint8_t { Gather, Nearest, TrueArea, Nanoflann };
[[nodiscard]] std::string_view name(Estimator estimator);

struct Schedule {
    std::uint64_t emitted = 0; ///< a frame
    std::size_t frames = 1;    ///< whose photons are kept together
};

class Frames {
public:
    virtual ~Frames() = default;
    virtual Stages next() = 0;
    /// What the last frame answered, in the order of Subject::which; watts per square unit.
    [[nodiscard]] virtual std::span<const pie::Rgb> answers() const = 0;
    [[nodiscard]] virtual std::uint64_t photons() const = 0;    ///< that the last frame answered from
    [[nodiscard]] virtual std::uint64_t photonsNew() const = 0; ///< that the last frame stored
    [[nodiscard]] virtual Memory memory() const = 0;
    [[nodiscard]] virtual double prepareMs() const = 0; ///< once for a still scene
};

/// The settings that an estimator is measured with where nothing was set: those of the paper for Nearest and Nanoflann.
[[nodiscard]] pie::engine::Settings settingsFor(Estimator estimator, const pie::engine::Settings& settings);

/// The subject must outlive it. `options` say which photons are traced; a gather derives the same from its settings.
[[nodiscard]] std::unique_ptr<Frames> makeFrames(Estimator estimator, const Subject& subject,
                                                 const pie::engine::Settings& settings,
                                                 const pie::photons::TracerOptions& options, const Schedule& schedule);

/// Vertex colours, as the draw callback fills them.
class Colours {
public:
    explicit Colours(const Subject& subject);
    /// Returns milliseconds.
    double fill(std::span<const pie::Rgb> answers);

private:
    const std::vector<std::uint32_t>& answerOfVertex_;
    std::vector<glm::vec4> colours_;
};

/// Of numbers; not empty.
[[nodiscard]] double median(std::vector<double> values);

// The two kinds behind makeFrames.
[[nodiscard]] std::unique_ptr<Frames> makeGatherFrames(const Subject& subject, const pie::engine::Settings& settings,
                                                       const Schedule& schedule);
[[nodiscard]] std::unique_ptr<Frames> makeMapFrames(Estimator estimator, const Subject& subject,
                                                    const pie::engine::Settings& settings,
                                                    const pie::photons::TracerOptions& options,
                                                    const Schedule& schedule);

} // namespace piebench
