// What commands do.

#include "apps/pieview/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace pieview {

using pie::engine::View;

namespace {

const std::map<Command, View>& viewCommands() {
    static const std::map<Command, View> views{
        {Command::ViewLit, View::Lit},
        {Command::ViewLight, View::Light},
        {Command::ViewFullbright, View::Fullbright},
        {Command::ViewBaked, View::Baked},
        {Command::ViewLightmap, View::Lightmap},
        {Command::ViewSplit, View::Split},
        {Command::ViewDifference, View::Difference},
        {Command::ViewNormals, View::Normals},
        {Command::ViewTriangles, View::Triangles},
        {Command::ViewCoarseTriangles, View::CoarseTriangles},
        {Command::ViewPhotons, View::Photons},
        {Command::ViewSamples, View::Samples},
    };
    return views;
}

/// A turn of the colour circle about grey, and back to positive channels.
Rgb hueTurned(const Rgb& colour, float degrees) {
    const float angle = degrees * std::numbers::pi_v<float> / 180.0F;
    const Rgb grey(1.0F / std::sqrt(3.0F));
    const Rgb turned = colour * std::cos(angle) + glm::cross(grey, colour) * std::sin(angle) +
                       grey * (glm::dot(grey, colour) * (1.0F - std::cos(angle)));
    return glm::max(turned, Rgb(0.0F));
}

/// 0 is grey, 1 as it is, more is stronger.
Rgb saturated(const Rgb& colour, float factor) {
    const Rgb grey(pie::meanChannel(colour));
    return glm::max(grey + (colour - grey) * factor, Rgb(0.0F));
}

/// White has no hue to make stronger: it starts as a lamp's.
Rgb coloured(const Rgb& colour) {
    const float spread = pie::maxChannel(colour) - std::min({colour.x, colour.y, colour.z});
    return spread > 0.02F ? colour : Rgb(1.0F, 0.85F, 0.7F);
}

} // namespace

void Session::run(Command command, int digit) {
    changed_ = true;
    if (const auto view = viewCommands().find(command); view != viewCommands().end()) {
        looks_.view = view->second;
        return;
    }
    switch (command) {
    case Command::Help: looks_.help = !looks_.help; break;
    case Command::Panel: looks_.panel = !looks_.panel; break;
    case Command::Statistics: looks_.statistics = !looks_.statistics; break;
    case Command::FullScreen:
    case Command::VerticalSync: windowCommand_ = command; break;
    case Command::Quit: quit(); break;
    case Command::SaveLights: saveLights(); break;
    case Command::Reload: reload(); break;
    case Command::Cancel:
        if (loader_.cancel())
            say("reading given up");
        else if (looks_.help)
            looks_.help = false;
        else
            select(std::nullopt);
        break;
    case Command::Fly: motion_ = Motion::Fly; break;
    case Command::Walk:
        motion_ = Motion::Walk;
        walker_ = {};
        break;
    case Command::Orbit: {
        motion_ = Motion::Orbit;
        constexpr float farthest = 8192;
        const auto hit = trace_ ? trace_(camera_.eye, apps::ahead(camera_), farthest) : std::nullopt;
        orbitDistance_ = hit ? std::max(8.0F, hit->distance) : 256.0F;
        break;
    }
    case Command::NextStart: nextStart(); break;
    case Command::Faster: wheel(motion_ == Motion::Orbit ? 0.0F : 1.0F); break;
    case Command::Slower: wheel(motion_ == Motion::Orbit ? 0.0F : -1.0F); break;
    case Command::SetBookmark:
    case Command::GoToBookmark: bookmark(command, digit); break;
    case Command::AddPathKey:
    case Command::PlayPath:
    case Command::ClearPath: pathCommand(command); break;
    case Command::SplitLeft: looks_.split = std::max(-1.0F, looks_.split - 0.05F); break;
    case Command::SplitRight: looks_.split = std::min(1.0F, looks_.split + 0.05F); break;
    case Command::Brighter: looks_.exposure = std::min(1000.0F, looks_.exposure * 1.1F); break;
    case Command::Darker: looks_.exposure = std::max(0.001F, looks_.exposure / 1.1F); break;
    case Command::ResetExposure: looks_.exposure = 1; break;
    case Command::Overbright: {
        const float next = settings_.overbrightClamp < 2 ? 2.0F : settings_.overbrightClamp < 4 ? 4.0F : 1.0F;
        if (const auto error = change("overbright_clamp", fmt::format("{}", next))) say(error->message());
        break;
    }
    case Command::ColorSpace: {
        const bool linear = settings_.colorSpace == pie::engine::ColorSpace::Srgb;
        if (const auto error = change("color_space", linear ? "quake3" : "srgb")) say(error->message());
        break;
    }
    case Command::Time: looks_.timeRuns = !looks_.timeRuns; break;
    case Command::Flashlight: looks_.flashlight = !looks_.flashlight; break;
    case Command::LightIcons: looks_.lightIcons = !looks_.lightIcons; break;
    case Command::Screenshot: namePicture("png"); break;
    case Command::ScreenshotExr: namePicture("exr"); break;
    case Command::None: break;
    default: lightCommand(command); break;
    }
}

void Session::bookmark(Command command, int digit) {
    auto& place = notes_.bookmarks.at(static_cast<std::size_t>(std::clamp(digit, 0, 9)));
    if (command == Command::GoToBookmark) {
        if (place)
            setCamera(*place);
        else
            say(fmt::format("no bookmark {0}; Ctrl+{0} sets it", digit));
        return;
    }
    place = camera_;
    say(fmt::format("bookmark {} set", digit));
    keepNotes();
}

void Session::pathCommand(Command command) {
    if (command == Command::AddPathKey) {
        notes_.path.push_back(camera_);
        say(fmt::format("path: {} {}", notes_.path.size(), notes_.path.size() == 1 ? "place" : "places"));
        keepNotes();
    } else if (command == Command::ClearPath) {
        notes_.path.clear();
        playing_.reset();
        say("path forgotten");
        keepNotes();
    } else if (playing_) {
        playing_.reset();
    } else if (notes_.path.size() < 2) {
        say("a path needs two places; K adds one");
    } else {
        playing_.emplace(notes_.path);
        playedUnits_ = 0;
    }
}

void Session::keepNotes() {
    if (notesDamaged_) return; // it was said, and the user's file stays as it is
    if (const auto error = writeNotes(notesFile_, notes_, level_)) say(error->message());
}

void Session::select(std::optional<std::size_t> light) {
    selected_ = light && *light < lights_.size() ? light : std::nullopt;
    changed_ = true;
}

void Session::stepLight(int by) {
    if (lights_.size() == 0) return say("this level has no lights");
    const auto count = static_cast<int>(lights_.size());
    const int from = selected_ ? static_cast<int>(*selected_) : by > 0 ? -1 : 0;
    select(static_cast<std::size_t>(((from + by) % count + count) % count));
}

void Session::switchGroup(const std::string& group, bool on) {
    for (std::size_t i = 0; i < lights_.size(); ++i)
        if (groups_[i] == group) lights_.setOn(i, on);
}

void Session::lightCommand(Command command) {
    switch (command) {
    case Command::NextLight: return stepLight(1);
    case Command::PreviousLight: return stepLight(-1);
    case Command::AllLightsOn:
        for (std::size_t i = 0; i < lights_.size(); ++i) lights_.setOn(i, true);
        return;
    case Command::UndoLights: return lights_.undoAll();
    default: break;
    }
    if (!selected_) return say("no light is chosen; N chooses one, or click on it");
    const std::size_t number = *selected_;
    const Light& light = lights_.light(number);
    const Rgb colour = colourOf(light);
    switch (command) {
    case Command::SwitchLight: return lights_.setOn(number, !lights_.isOn(number));
    case Command::SwitchGroup: return switchGroup(groups_[number], !lights_.isOn(number));
    case Command::LightBrighter: return lights_.set(number, withStrength(light, strengthOf(light) * 1.1F));
    case Command::LightDarker: return lights_.set(number, withStrength(light, strengthOf(light) / 1.1F));
    case Command::LightHue: return lights_.set(number, withColour(light, hueTurned(coloured(colour), 15)));
    case Command::LightHueBack: return lights_.set(number, withColour(light, hueTurned(coloured(colour), -15)));
    case Command::LightStronger: return lights_.set(number, withColour(light, saturated(coloured(colour), 1.25F)));
    case Command::LightPaler: return lights_.set(number, withColour(light, saturated(colour, 0.8F)));
    case Command::UndoLight: return lights_.undo(number);
    case Command::GoToLight:
        if (const auto position = positionOf(light)) {
            constexpr float away = 160;
            setCamera({*position - apps::ahead(camera_) * away, camera_.yaw, camera_.pitch});
        } else {
            say("a sun or a sky is nowhere");
        }
        return;
    default: return;
    }
}

void Session::nudge(float right, float up, bool vertical) {
    if (!selected_) return;
    const Light& light = lights_.light(*selected_);
    const auto position = positionOf(light);
    if (!position) return;
    const Vec3 way = vertical ? Vec3(0, 0, up) : apps::right(camera_) * right + apps::above(camera_) * up;
    lights_.set(*selected_, movedTo(light, *position + way));
}

} // namespace pieview
