#pragma once
// What the window shows and what commands do to it: the level with its views and edited lights, the camera, the user's
// notes about the level, what there is to say. Knows no window system and no panel, so tests drive it as keys would.
//
// Protocol, by one thread: construct; then per turn step(), and if needsFrame() draw scene() as camera() and lens say,
// then frameDrawn(). Commands come between turns.

#include "apps/pieview/camera_path.h"
#include "apps/pieview/file_watch.h"
#include "apps/pieview/keys.h"
#include "apps/pieview/level_notes.h"
#include "apps/pieview/light_edits.h"
#include "apps/pieview/loader.h"
#include "apps/pieview/save_lights.h"
#include "apps/pieview/stage_times.h"
#include "apps/pieview/walk.h"

#include <osg/Group>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pieview {

enum class Motion : std::uint8_t { Fly, Walk, Orbit };

/// Keys that are held: x right, y ahead, z up, each −1 to 1.
struct Held {
    Vec3 push{0.0F};
    bool fast = false;
};

/// What the user has chosen to see. The window and its panel read and write it; step() brings it to the level.
struct Looks {
    pie::engine::View view = pie::engine::View::Lit;
    float split = 0;    ///< divider, −1 left to 1 right
    float exposure = 1; ///< factor on our light
    bool flashlight = false, timeRuns = false, lightIcons = true;
    bool panel = true, help = false, statistics = false;
    bool operator==(const Looks&) const = default;
};

class Session {
public:
    /// `level` and `settings` as for osgpie::loadLevelNode. `start`: else the first player start. `wake` is called by
    /// another thread when there is something to show.
    Session(std::string level, pie::engine::Settings settings, std::optional<Camera> start = {},
            std::function<void()> wake = {});

    [[nodiscard]] const osg::ref_ptr<osg::Group>& scene() const { return scene_; }
    /// Null before the first level.
    [[nodiscard]] osgpie::LevelNode* level() { return node_.get(); }
    [[nodiscard]] const std::string& levelName() const { return level_; }
    [[nodiscard]] const pie::engine::Settings& settings() const { return settings_; }
    Looks& looks() { return looks_; }

    /// `digit`: of the bookmark commands.
    void run(Command command, int digit = 0);
    /// Takes what was loaded, looks for saves, moves the camera.
    void step(double seconds, const Held& held);
    /// Whether the picture may have changed since frameDrawn(), for other reasons than the user's input.
    [[nodiscard]] bool needsFrame() const;
    void frameDrawn(double milliseconds);
    /// Light stands still, and the level is there.
    [[nodiscard]] bool settled() const;

    // Loading
    [[nodiscard]] bool loading() const { return loader_.busy(); }
    /// What is wrong with the level as it was saved last; empty: nothing. The level before is still shown.
    [[nodiscard]] const std::string& error() const { return error_; }
    [[nodiscard]] double loadMilliseconds() const { return loadMs_; }
    [[nodiscard]] unsigned loads() const { return loads_; }
    /// A setting that needs the level to be read again; an error says why it was not taken.
    [[nodiscard]] std::optional<pie::Error> change(const std::string& key, const std::string& value);

    // Camera
    [[nodiscard]] const Camera& camera() const { return camera_; }
    void setCamera(const Camera& camera);
    [[nodiscard]] Motion motion() const { return motion_; }
    /// Pixels of the mouse with the button held, and notches of its wheel.
    void look(const pie::Vec2& pixels);
    void wheel(float notches);
    [[nodiscard]] float speed() const { return speed_; } ///< units per second
    [[nodiscard]] const LevelNotes& notes() const { return notes_; }
    [[nodiscard]] bool playing() const { return playing_.has_value(); }

    // Lights
    LightEdits& lights() { return lights_; }
    [[nodiscard]] const std::optional<std::size_t>& selected() const { return selected_; }
    void select(std::optional<std::size_t> light);
    /// "point", "spot", "area textures/lamp": lights that belong together.
    [[nodiscard]] const std::string& groupOf(std::size_t light) const { return groups_.at(light); }
    void switchGroup(const std::string& group, bool on);
    /// Edited light entities that the .map on disk does not have yet.
    [[nodiscard]] std::size_t unsavedLights() const;
    /// By arrow keys: units to the right and upwards of the picture, or straight up with `vertical`.
    void nudge(float right, float up, bool vertical);
    /// Whether something solid stands between the eye and the point.
    [[nodiscard]] bool hidden(const Vec3& point) const;

    // What there is to say
    void say(std::string note);
    [[nodiscard]] const std::string& note() const { return note_; }
    [[nodiscard]] const StageTimes& times() const { return times_; }
    /// File the next frame is to be written to.
    [[nodiscard]] std::optional<std::string> takePictureName() { return std::exchange(pictureName_, {}); }
    [[nodiscard]] bool ended() const { return ended_; }
    /// What only the window can do: full screen, vertical sync.
    [[nodiscard]] Command takeWindowCommand() { return std::exchange(windowCommand_, Command::None); }

private:
    void show(LoadedLevel loaded);
    void showLooks();
    void applyLights();
    void reload();
    void bookmark(Command command, int digit);
    void pathCommand(Command command);
    void lightCommand(Command command);
    void saveLights();
    void quit();
    [[nodiscard]] LightSource lightSource() const;
    void stepLight(int by);
    void keepNotes();
    void namePicture(const char* ending);
    void nextStart();
    void playPath(double seconds);

    std::string level_;
    pie::engine::Settings settings_;
    Looks looks_, shown_;
    osg::ref_ptr<osg::Group> scene_;
    osg::ref_ptr<osgpie::LevelNode> node_;
    Trace trace_;
    FileWatch watch_;
    std::string error_, note_;
    double noteSeconds_ = 0; ///< that the note is still shown
    double loadMs_ = 0;
    unsigned loads_ = 0;
    bool changed_ = true;

    Camera camera_;
    bool placed_ = false; ///< the camera has been somewhere of the user's choosing
    Motion motion_ = Motion::Fly;
    Walker walker_;
    float speed_ = 320, orbitDistance_ = 256;
    std::vector<Camera> starts_;
    std::size_t nextStart_ = 0;

    std::filesystem::path notesFile_;
    bool notesDamaged_ = false;
    LevelNotes notes_;
    std::optional<CameraPath> playing_;
    float playedUnits_ = 0;

    LightEdits lights_;
    std::vector<std::string> groups_;
    std::optional<std::size_t> selected_;

    StageTimes times_;
    std::optional<std::string> pictureName_;
    Command windowCommand_ = Command::None;
    bool ended_ = false;
    bool warned_ = false; ///< about lights that are not saved
    Loader loader_;       ///< last: it ends before what it wakes
};

} // namespace pieview
