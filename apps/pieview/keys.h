#pragma once
// Every key of the window: one table, which the window obeys, `?` shows and doc/manual.md repeats (a test compares).

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pieview {

enum class Command : std::uint8_t {
    None, ///< keys that are held, and what the mouse does
    Help,
    Panel,
    FullScreen,
    Quit,
    Reload,
    Cancel,
    Fly,
    Walk,
    Orbit,
    NextStart,
    Faster,
    Slower,
    SetBookmark, ///< of the digit pressed
    GoToBookmark,
    AddPathKey,
    PlayPath,
    ClearPath,
    ViewLit,
    ViewLight,
    ViewFullbright,
    ViewBaked,
    ViewLightmap,
    ViewSplit,
    ViewDifference,
    ViewNormals,
    ViewTriangles,
    ViewCoarseTriangles,
    ViewPhotons,
    ViewSamples,
    SplitLeft,
    SplitRight,
    Brighter,
    Darker,
    ResetExposure,
    Overbright,
    ColorSpace,
    Time,
    Flashlight,
    LightIcons,
    NextLight,
    PreviousLight,
    SwitchLight,
    SwitchGroup,
    AllLightsOn,
    LightBrighter,
    LightDarker,
    LightHue,
    LightHueBack,
    LightPaler,
    LightStronger,
    UndoLight,
    UndoLights,
    GoToLight,
    SaveLights,
    Statistics,
    Screenshot,
    ScreenshotExr,
    VerticalSync,
};

struct Binding {
    Command command = Command::None;
    int key = 0;       ///< of GLFW; 0: the mouse, or a character
    int modifiers = 0; ///< of GLFW: shift, control and alt
    std::string_view keys;
    std::string_view group; ///< "Moving", "Looking", …
    std::string_view what;
};

/// In the order in which they are shown; those of a group together.
[[nodiscard]] std::span<const Binding> bindings();
/// What a key means; digits are bookmarks.
[[nodiscard]] Command commandOf(int key, int modifiers);
/// What is written beside a button of the panel: the keys of a command.
[[nodiscard]] std::string_view keysOf(Command command);
/// The table as it stands in doc/manual.md.
[[nodiscard]] std::string keysPage();

} // namespace pieview
