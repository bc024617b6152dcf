#include "pie/engine/engine.h"

#include "pie/core/clock.h"
#include "pie/core/parallel.h"
#include "pie/engine/options.h"
#include "pie/engine/refine_by_light.h"
#include "pie/lights/light_set.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <optional>

namespace pie::engine {

struct Engine::State {
    std::shared_ptr<const level::Level> level;
    Settings settings;
    scene::Mesh mesh;
    scene::Receivers receivers;
    bool refined = false;
    std::once_flag surveyed, prepared;
    Surroundings around;                ///< written once, under `surveyed`; moved away by what `prepared` guards
    lights::ImportedLights imported;    ///< written once, under `surveyed`
    std::optional<Transport> transport; ///< written once, under `prepared`
    std::atomic<bool> ready{false};
    double surveyMs = 0, prepareMs = 0; ///< each written once, under its flag

    void survey();
    void split(const std::stop_token& stop);
};

/// All that does not depend on receivers.
void Engine::State::survey() {
    std::call_once(surveyed, [this] {
        const auto start = Clock::now();
        auto scene = std::make_shared<const scene::Scene>(scene::makeScene(*level, sceneOptions(settings)));
        imported = lights::importLights(*level, *scene, importOptions(settings));
        around = makeSurroundings(std::move(scene), level->tree, settings);
        surveyMs = millisecondsSince(start);
    });
}

void Engine::State::split(const std::stop_token& stop) {
    const bool byLight = settings.refineBy == RefineBy::Light && settings.meshRefinement > 0;
    if (!byLight) {
        scene::RefineOptions options = refineOptions(settings);
        options.stop = stop;
        scene::refine(mesh, options);
        return;
    }
    survey();
    scene::AdaptOptions options = adaptOptions(settings);
    options.stop = stop;
    const lights::LightSet lights(imported.lights, around.scene);
    refineByLight(mesh, *level, *around.scene, lights, *around.intersector, options, settings.seed);
}

Engine::Engine(std::shared_ptr<const level::Level> level, const Settings& settings, Refinement refinement)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.level = std::move(level);
    s.settings = chosen(settings);
    s.mesh = scene::makeMesh(*s.level);
    s.refined = !settings.showsOurLight();
    if (refinement == Refinement::AtOnce) refine();
}

void Engine::refine(const std::stop_token& stop) {
    State& s = *state_;
    if (s.refined) return;
    s.split(stop);
    if (stop.stop_requested()) return;
    s.receivers = scene::makeReceivers(s.mesh, *s.level);
    s.refined = true;
}

bool Engine::refined() const { return state_->refined; }

Engine::~Engine() = default;

const level::Level& Engine::level() const { return *state_->level; }
const std::shared_ptr<const level::Level>& Engine::sharedLevel() const { return state_->level; }
const Settings& Engine::settings() const { return state_->settings; }
const scene::Mesh& Engine::mesh() const { return state_->mesh; }
const scene::Receivers& Engine::receivers() const { return state_->receivers; }

void Engine::prepare() {
    State& s = *state_;
    std::call_once(s.prepared, [&s] {
        s.survey();
        const auto start = Clock::now();
        s.transport.emplace(std::move(s.around), s.imported.lights, s.level->tree, s.receivers, s.settings);
        s.prepareMs = s.surveyMs + millisecondsSince(start);
        s.ready = true;
    });
}

void Engine::complete(const std::stop_token& stop) {
    State& s = *state_;
    std::future<void> survey;
    if (threads() > 1) survey = std::async(std::launch::async, [&s] { s.survey(); });
    refine(stop);
    if (survey.valid()) survey.get();
    if (!stop.stop_requested()) prepare();
}

const lights::ImportedLights& Engine::lights() const {
    static const lights::ImportedLights none;
    return state_->ready ? state_->imported : none;
}

bool Engine::advance() {
    if (!state_->settings.showsOurLight()) return false;
    prepare();
    return state_->transport->advance();
}

void Engine::setLight(std::size_t number, std::optional<lights::Light> light) {
    if (!state_->settings.showsOurLight()) return;
    prepare();
    state_->transport->setLight(number, std::move(light));
}

std::size_t Engine::lightCount() {
    if (!state_->settings.showsOurLight()) return 0;
    prepare();
    return state_->transport->lightCount();
}

bool Engine::irradiance(std::span<const std::uint32_t> which, std::span<Rgb> out) {
    if (state_->ready) return state_->transport->irradiance(which, out);
    std::fill(out.begin(), out.end(), Rgb(0.0F));
    return true;
}

void Engine::finish(std::span<const std::uint32_t> which) {
    if (state_->ready) state_->transport->finish(which);
}

void Engine::samples(std::span<const std::uint32_t> which, std::span<std::uint32_t> out) {
    if (state_->ready) return state_->transport->samples(which, out);
    std::fill(out.begin(), out.end(), 0U);
}

std::vector<photons::Photon> Engine::photons(std::uint64_t count) {
    if (!state_->settings.showsOurLight()) return {};
    prepare();
    return state_->transport->photons(count);
}

std::uint64_t Engine::lightRevision() const { return state_->ready ? state_->transport->lightRevision() : 0; }

Statistics Engine::statistics() const {
    const State& s = *state_;
    Statistics statistics;
    if (s.ready) {
        statistics = s.transport->statistics();
        statistics.prepareMs = s.prepareMs;
    }
    statistics.drawnTriangles = s.mesh.triangles.size();
    statistics.receivers = s.receivers.points.size();
    return statistics;
}

void Engine::countUpload(double milliseconds) {
    if (state_->ready) state_->transport->countUpload(milliseconds);
}

} // namespace pie::engine
