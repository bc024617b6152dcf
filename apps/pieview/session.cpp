#include "apps/pieview/session.h"

#include "pie/engine/options.h"

#include <fmt/format.h>

#include <osg/ValueObject>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>

namespace pieview {

using pie::engine::Source;

namespace {

namespace fs = std::filesystem;

/// What is watched before anything was loaded.
fs::path fileOf(const std::string& level, const pie::engine::Settings& settings) {
    std::error_code error;
    if (settings.game.empty() || fs::exists(level, error)) return fs::absolute(level, error);
    return fs::absolute(fs::path(settings.game) / "maps" / fs::path(level).filename(), error);
}

std::vector<Camera> startsOf(const pie::level::Level& level) {
    const auto first = level.firstView();
    std::vector<Camera> starts{{first.eye, first.yaw, 0}};
    for (const auto& entity : level.entities) {
        const auto className = entity.value("classname");
        if (className.find("info_player") != 0) continue;
        std::istringstream origin{std::string(entity.value("origin"))};
        Vec3 place(0.0F);
        if (!(origin >> place.x >> place.y >> place.z)) continue;
        float yaw = 0;
        std::istringstream(std::string(entity.value("angle"))) >> yaw;
        constexpr float eyeOverOrigin = 26;
        const Camera start{place + Vec3(0, 0, eyeOverOrigin), yaw, 0};
        if (glm::length(start.eye - starts.front().eye) > 1.0F) starts.push_back(start);
    }
    return starts;
}

std::vector<std::string> groupsOf(const pie::level::Level& level, const std::vector<Light>& lights) {
    std::vector<std::string> groups;
    for (const Light& light : lights) {
        std::string group(pie::lights::kindName(light));
        if (const auto* area = std::get_if<pie::lights::AreaLight>(&light))
            if (area->surface < level.surfaces.size())
                group += " " + level.shaders[level.surfaces[area->surface].shader].name;
        groups.push_back(std::move(group));
    }
    return groups;
}

} // namespace

Session::Session(std::string level, pie::engine::Settings settings, std::optional<Camera> start,
                 std::function<void()> wake)
    : level_(std::move(level)), settings_(std::move(settings)), scene_(new osg::Group),
      watch_(filesOfLevel(fileOf(level_, settings_))), notesFile_(notesFile(fileOf(level_, settings_))),
      loader_(std::move(wake)) {
    looks_.view = settings_.view;
    looks_.exposure = settings_.exposure;
    looks_.flashlight = settings_.flashlight;
    looks_.timeRuns = settings_.origin("animate") != Source::Default && settings_.animate;
    settings_.switchViews = true;
    if (start) setCamera(*start);
    auto notes = readNotes(notesFile_);
    notesDamaged_ = !notes;
    if (notes)
        notes_ = std::move(*notes);
    else
        say(notes.error().message());
    reload();
}

void Session::reload() { loader_.request(level_, settings_); }

std::optional<pie::Error> Session::change(const std::string& key, const std::string& value) {
    pie::engine::Settings changed = settings_;
    if (const auto set = changed.set(key, value, Source::CommandLine); !set) return set.error();
    changed.switchViews = true;
    settings_ = std::move(changed);
    reload();
    return std::nullopt;
}

void Session::show(LoadedLevel loaded) {
    ++loads_;
    changed_ = true;
    if (loaded.error) {
        std::error_code ignored;
        // As the user named it.
        if (fs::path(loaded.error->file) == fs::absolute(level_, ignored)) loaded.error->file = level_;
        error_ = loaded.error->message();
        return;
    }
    error_.clear();
    loadMs_ = loaded.milliseconds;
    trace_ = std::move(loaded.trace);
    watch_.add(filesAround(loaded.node->level()));
    scene_->removeChildren(0, scene_->getNumChildren());
    node_ = loaded.node;
    scene_->addChild(node_);
    const auto& found = node_->engine().lights().lights;
    lights_.carryOver(found);
    groups_ = groupsOf(node_->level(), found);
    if (selected_ && *selected_ >= lights_.size()) selected_.reset();
    starts_ = startsOf(node_->level());
    if (!placed_) setCamera(starts_.front());
    times_.restart();
    shown_ = looks_;
    showLooks();
    // Behind what is said still: what was saved, for one, which is why it is read again.
    if (loads_ > 1) say(fmt::format("{}{}read again in {:.2f} s", note_, note_.empty() ? "" : "; ", loadMs_ / 1000));
}

void Session::showLooks() {
    osgpie::ViewSwitch* views = node_ ? node_->views() : nullptr;
    if (!views) return;
    views->setView(looks_.view);
    views->setSplit(looks_.split);
    views->setExposure(looks_.exposure);
    views->setFlashlight(looks_.flashlight);
}

void Session::applyLights() {
    if (!node_) return;
    const std::vector<std::size_t> changed = lights_.takeChanged();
    if (changed.empty()) return;
    for (const std::size_t number : changed)
        node_->engine().setLight(number, shownLight(lightSource(), lights_, number));
    warned_ = false;
    if (node_->views()) node_->views()->renewOverlay();
    changed_ = true;
}

LightSource Session::lightSource() const {
    const pie::engine::Engine& engine = node_->engine();
    return {engine.level(), engine.lights(), pie::engine::importOptions(engine.settings())};
}

std::size_t Session::unsavedLights() const { return node_ ? lightsToSave(lightSource(), lights_).edits.size() : 0; }

void Session::saveLights() {
    if (!node_) return;
    const LightsToSave plan = lightsToSave(lightSource(), lights_);
    const auto count = [](std::size_t number) { return fmt::format("{} light{}", number, number == 1 ? "" : "s"); };
    std::string more;
    if (plan.ofShaders != 0) more += fmt::format("; {} in shader scripts not saved", count(plan.ofShaders));
    if (plan.switchedOff != 0)
        more += fmt::format("; {} switched off, but left on in the level", count(plan.switchedOff));
    if (plan.edits.empty()) return say("no light entity is edited" + more);
    const auto file = node_->level().lightEntityFile();
    if (!file) return say(file.error().message());
    if (const auto error = pie::level::saveEntities(*file, plan.edits)) return say(error->message());
    say(fmt::format("{} saved to {}; {}.before has what was there{}", count(plan.edits.size()), file->string(),
                    file->filename().string(), more));
}

void Session::quit() {
    const std::size_t unsaved = warned_ ? 0 : unsavedLights();
    ended_ = unsaved == 0;
    warned_ = true;
    if (!ended_)
        say(fmt::format("{} edited light{} not saved: {} saves, once more ends", unsaved, unsaved == 1 ? "" : "s",
                        keysOf(Command::SaveLights)));
}

void Session::step(double seconds, const Held& held) {
    if (watch_.changed()) reload();
    if (auto loaded = loader_.take()) show(std::move(*loaded));
    if (looks_ != shown_) {
        shown_ = looks_;
        showLooks();
        changed_ = true;
    }
    applyLights();
    if (noteSeconds_ > 0 && (noteSeconds_ -= seconds) <= 0) {
        note_.clear();
        changed_ = true;
    }
    const Camera before = camera_;
    const auto time = static_cast<float>(std::min(seconds, 0.1)); // a hitch is no leap
    const float speed = speed_ * (held.fast ? 4.0F : 1.0F);
    if (playing_) {
        playPath(seconds);
    } else if (motion_ == Motion::Walk && trace_) {
        if (held.push.z > 0.0F) jump(walker_);
        camera_ = walked(camera_, walker_, trace_, held.push, speed, time);
    } else {
        camera_ = apps::flown(camera_, held.push, speed * time);
    }
    if (held.push != Vec3(0.0F)) placed_ = true;
    if (before != camera_) changed_ = true;
}

void Session::playPath(double seconds) {
    playedUnits_ += speed_ * static_cast<float>(std::min(seconds, 0.1));
    camera_ = playing_->at(playedUnits_);
    changed_ = true;
    if (playedUnits_ >= playing_->length()) playing_.reset();
}

bool Session::settled() const {
    bool still = false;
    return node_ && node_->getUserValue("pie.settled", still) && still;
}

bool Session::needsFrame() const { return changed_ || (node_ && (!settled() || looks_.timeRuns)); }

void Session::frameDrawn(double milliseconds) {
    changed_ = false;
    if (node_) times_.add(milliseconds, node_->engine().statistics());
}

void Session::say(std::string note) {
    note_ = std::move(note);
    noteSeconds_ = 4;
    changed_ = true;
}

void Session::setCamera(const Camera& camera) {
    camera_ = camera;
    placed_ = true;
    walker_ = {};
    changed_ = true;
}

void Session::look(const pie::Vec2& pixels) {
    constexpr float degreesPerPixel = 0.2F;
    const float yaw = -pixels.x * degreesPerPixel;
    const float pitch = pixels.y * degreesPerPixel;
    camera_ = motion_ == Motion::Orbit ? apps::orbited(camera_, orbitDistance_, yaw, pitch)
                                       : apps::turned(camera_, yaw, pitch);
    placed_ = changed_ = true;
}

void Session::wheel(float notches) {
    if (motion_ == Motion::Orbit) {
        const float distance = std::clamp(orbitDistance_ * std::pow(0.85F, notches), 8.0F, 16'384.0F);
        camera_.eye += apps::ahead(camera_) * (orbitDistance_ - distance);
        orbitDistance_ = distance;
        changed_ = true;
        return;
    }
    speed_ = std::clamp(speed_ * std::pow(1.25F, notches), 4.0F, 8'192.0F);
    say(fmt::format("{:.0f} units a second", speed_));
}

bool Session::hidden(const Vec3& point) const {
    const Vec3 way = point - camera_.eye;
    const float distance = glm::length(way);
    constexpr float inFront = 4; // lights lie on what they shine from
    if (!trace_ || distance <= inFront) return false;
    return trace_(camera_.eye, way / distance, distance - inFront).has_value();
}

void Session::namePicture(const char* ending) {
    const std::string stem = fs::path(level_).stem().string();
    std::error_code error;
    for (int number = 1; number < 10'000; ++number) {
        std::string name = fmt::format("{}-{:03}.{}", stem, number, ending);
        if (fs::exists(name, error)) continue;
        pictureName_ = std::move(name);
        changed_ = true;
        return;
    }
}

void Session::nextStart() {
    if (starts_.empty()) return;
    setCamera(starts_[nextStart_ % starts_.size()]);
    ++nextStart_;
}

} // namespace pieview
