// Frames of the engine's gather, through Transport, and what all ways share.

#include "apps/piebench/frames.h"
#include "pie/core/clock.h"
#include "pie/engine/transport.h"

#include <algorithm>

namespace piebench {
namespace {

using pie::Clock;
using pie::engine::Settings;
using pie::engine::Statistics;

class GatherFrames final : public Frames {
public:
    GatherFrames(const Subject& subject, const Settings& settings, const Schedule& schedule)
        : subject_(subject), colours_(subject), answers_(subject.which.size()) {
        const auto start = Clock::now();
        Settings own = settings;
        own.photonsFromLight = static_cast<int>(schedule.emitted);
        own.stillFrames = 1'000'000; // as many as are asked for
        transport_ = std::make_unique<pie::engine::Transport>(
            pie::engine::makeSurroundings(subject.of->scene, subject.of->level->tree, own), subject.of->lights,
            subject.of->level->tree, subject.receivers, own);
        transport_->finish(subject.which);
        prepareMs_ = pie::millisecondsSince(start);
    }

    Stages next() override {
        const Statistics before = transport_->statistics();
        const auto start = Clock::now();
        const double processor = pie::processorMilliseconds();
        transport_->advance();
        transport_->irradiance(subject_.which, answers_);
        Stages stages;
        stages.upload = colours_.fill(answers_);
        stages.processor = pie::processorMilliseconds() - processor;
        stages.total = pie::millisecondsSince(start);
        const Statistics after = transport_->statistics();
        stages.trace = after.traceMs - before.traceMs;
        stages.build = after.buildMs - before.buildMs;
        stages.estimate = after.estimateMs - before.estimateMs + after.directMs - before.directMs;
        photonsNew_ = after.photonsStored - before.photonsStored;
        photons_ = after.photonsInMap;
        return stages;
    }
    [[nodiscard]] std::span<const pie::Rgb> answers() const override { return answers_; }
    [[nodiscard]] std::uint64_t photons() const override { return photons_; }
    [[nodiscard]] std::uint64_t photonsNew() const override { return photonsNew_; }
    [[nodiscard]] Memory memory() const override {
        const Statistics s = transport_->statistics();
        // Photons of a frame are summed up and then overwritten by those of the next.
        return {static_cast<double>(s.receiverBytes + s.estimatorBytes + s.directBytes) /
                    static_cast<double>(std::max<std::size_t>(1, s.receivers)),
                static_cast<double>(sizeof(pie::photons::Photon))};
    }
    [[nodiscard]] double prepareMs() const override { return prepareMs_; }

private:
    const Subject& subject_;
    Colours colours_;
    std::unique_ptr<pie::engine::Transport> transport_;
    std::vector<pie::Rgb> answers_;
    std::uint64_t photons_ = 0, photonsNew_ = 0;
    double prepareMs_ = 0;
};

} // namespace

std::string_view name(Estimator estimator) {
    switch (estimator) {
    case Estimator::Gather: return "gather";
    case Estimator::Nearest: return "nearest";
    case Estimator::TrueArea: return "true_area";
    case Estimator::Nanoflann: return "nanoflann";
    }
    return "";
}

Settings settingsFor(Estimator estimator, const Settings& settings) {
    Settings own = settings;
    const bool paper = estimator == Estimator::Nearest || estimator == Estimator::Nanoflann;
    own.finalGathering = false;
    own.estimator = estimator == Estimator::Gather     ? pie::engine::EstimatorKind::Gather
                    : estimator == Estimator::TrueArea ? pie::engine::EstimatorKind::TrueArea
                                                       : pie::engine::EstimatorKind::Nearest;
    constexpr auto untouched = pie::engine::Source::Default;
    if (paper && settings.origin("max_search_count") == untouched) own.maxSearchCount = 50;
    if (paper && settings.origin("kernel") == untouched) own.kernel = pie::gather::Kernel::Constant;
    return own;
}

std::unique_ptr<Frames> makeGatherFrames(const Subject& subject, const Settings& settings, const Schedule& schedule) {
    return std::make_unique<GatherFrames>(subject, settings, schedule);
}

std::unique_ptr<Frames> makeFrames(Estimator estimator, const Subject& subject, const Settings& settings,
                                   const pie::photons::TracerOptions& options, const Schedule& schedule) {
    if (estimator == Estimator::Gather) return makeGatherFrames(subject, settingsFor(estimator, settings), schedule);
    return makeMapFrames(estimator, subject, settingsFor(estimator, settings), options, schedule);
}

Colours::Colours(const Subject& subject)
    : answerOfVertex_(subject.answerOfVertex), colours_(subject.answerOfVertex.size(), glm::vec4(1.0F)) {}

double Colours::fill(std::span<const pie::Rgb> answers) {
    constexpr float scale = 1.0F / 255.0F;
    const auto start = Clock::now();
    for (std::size_t i = 0; i < answerOfVertex_.size(); ++i) {
        const pie::Rgb light = answers[answerOfVertex_[i]] * scale;
        colours_[i] = glm::vec4(light.x, light.y, light.z, colours_[i].w);
    }
    return pie::millisecondsSince(start);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace piebench
