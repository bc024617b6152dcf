#include "apps/pieview/keys.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <array>

namespace pieview {
namespace {

constexpr int shift = GLFW_MOD_SHIFT;
constexpr int control = GLFW_MOD_CONTROL;
constexpr int alt = GLFW_MOD_ALT;

using enum Command;

// clang-format off: one row is one line
constexpr std::array table{
    Binding{None, 0, 0, "W A S D", "Moving", "ahead, left, back, right; keys are where they are on a US keyboard"},
    Binding{None, 0, 0, "Space, C", "Moving", "up and down; walking, Space jumps"},
    Binding{None, 0, 0, "Shift, held", "Moving", "four times as fast"},
    Binding{None, 0, 0, "right button, dragged", "Moving", "look around; orbiting, turn about the point ahead"},
    Binding{None, 0, 0, "wheel", "Moving", "speed; orbiting, nearer and farther"},
    Binding{Faster, GLFW_KEY_PAGE_UP, 0, "Page Up", "Moving", "faster"},
    Binding{Slower, GLFW_KEY_PAGE_DOWN, 0, "Page Down", "Moving", "slower"},
    Binding{Fly, GLFW_KEY_F, 0, "F", "Moving", "fly"},
    Binding{Walk, GLFW_KEY_G, 0, "G", "Moving", "walk on the ground"},
    Binding{Orbit, GLFW_KEY_O, 0, "O", "Moving", "orbit about the point ahead"},
    Binding{NextStart, GLFW_KEY_HOME, 0, "Home", "Moving", "to the next player start"},
    Binding{GoToBookmark, 0, 0, "0 to 9", "Moving", "to a bookmark"},
    Binding{SetBookmark, 0, 0, "Ctrl+0 to 9", "Moving", "set a bookmark; kept with the level"},
    Binding{AddPathKey, GLFW_KEY_K, 0, "K", "Moving", "add this place to the camera's path"},
    Binding{PlayPath, GLFW_KEY_K, shift, "Shift+K", "Moving", "go along the path, or stop"},
    Binding{ClearPath, GLFW_KEY_K, control, "Ctrl+K", "Moving", "forget the path"},

    Binding{ViewLit, GLFW_KEY_F1, 0, "F1", "Looking", "lit"},
    Binding{ViewLight, GLFW_KEY_F2, 0, "F2", "Looking", "our light alone"},
    Binding{ViewFullbright, GLFW_KEY_F3, 0, "F3", "Looking", "textures alone"},
    Binding{ViewBaked, GLFW_KEY_F4, 0, "F4", "Looking", "the level's own lightmaps"},
    Binding{ViewLightmap, GLFW_KEY_F5, 0, "F5", "Looking", "lightmaps alone"},
    Binding{ViewSplit, GLFW_KEY_F6, 0, "F6", "Looking", "baked on the left, ours on the right"},
    Binding{ViewDifference, GLFW_KEY_F7, 0, "F7", "Looking", "ours less baked, in false colour"},
    Binding{ViewNormals, GLFW_KEY_F8, 0, "F8", "Looking", "normals"},
    Binding{ViewTriangles, GLFW_KEY_F9, 0, "F9", "Looking", "edges of what is drawn"},
    Binding{ViewCoarseTriangles, GLFW_KEY_F9, shift, "Shift+F9", "Looking", "edges of the file's triangles"},
    Binding{ViewPhotons, GLFW_KEY_F10, 0, "F10", "Looking", "photons where they land"},
    Binding{ViewSamples, GLFW_KEY_F11, 0, "F11", "Looking", "rays spent on each vertex"},
    Binding{None, 0, 0, "left button on the divider", "Looking", "drag it (F6)"},
    Binding{SplitLeft, GLFW_KEY_LEFT, control, "Ctrl+Left", "Looking", "the divider to the left"},
    Binding{SplitRight, GLFW_KEY_RIGHT, control, "Ctrl+Right", "Looking", "the divider to the right"},
    Binding{Brighter, GLFW_KEY_RIGHT_BRACKET, 0, "]", "Looking", "exposure up by a tenth"},
    Binding{Darker, GLFW_KEY_LEFT_BRACKET, 0, "[", "Looking", "exposure down"},
    Binding{ResetExposure, GLFW_KEY_BACKSPACE, 0, "Backspace", "Looking", "the game's exposure"},
    Binding{Overbright, GLFW_KEY_B, 0, "B", "Looking",
            "brightest light 1, 2 or 4 times the texture; the level is read again"},
    Binding{ColorSpace, GLFW_KEY_B, shift, "Shift+B", "Looking",
            "colours as the game's or linear; the level is read again"},
    Binding{Time, GLFW_KEY_T, 0, "T", "Looking", "let textures move, or stop them"},
    Binding{Flashlight, GLFW_KEY_L, 0, "L", "Looking", "flashlight"},

    Binding{LightIcons, GLFW_KEY_I, 0, "I", "Lights", "show lights in the view"},
    Binding{None, 0, 0, "left button on a light", "Lights",
            "choose it, drag it: facing you, with Shift up and down, with Ctrl along x or y"},
    Binding{NextLight, GLFW_KEY_N, 0, "N", "Lights", "choose the next light"},
    Binding{PreviousLight, GLFW_KEY_N, shift, "Shift+N", "Lights", "choose the one before"},
    Binding{GoToLight, GLFW_KEY_N, control, "Ctrl+N", "Lights", "look at the light from near by"},
    Binding{None, 0, 0, "arrows", "Lights", "move it by 8 units, as you see it; with Shift up and down"},
    Binding{SwitchLight, GLFW_KEY_X, 0, "X", "Lights", "switch it on or off"},
    Binding{SwitchGroup, GLFW_KEY_X, shift, "Shift+X", "Lights", "switch its group"},
    Binding{AllLightsOn, GLFW_KEY_X, control, "Ctrl+X", "Lights", "switch all on"},
    Binding{LightBrighter, GLFW_KEY_EQUAL, 0, "=", "Lights", "brighter by a tenth"},
    Binding{LightDarker, GLFW_KEY_MINUS, 0, "-", "Lights", "darker"},
    Binding{LightHue, GLFW_KEY_H, 0, "H", "Lights", "hue on by 15 degrees"},
    Binding{LightHueBack, GLFW_KEY_H, shift, "Shift+H", "Lights", "hue back"},
    Binding{LightStronger, GLFW_KEY_J, 0, "J", "Lights", "colour stronger"},
    Binding{LightPaler, GLFW_KEY_J, shift, "Shift+J", "Lights", "colour paler"},
    Binding{UndoLight, GLFW_KEY_U, 0, "U", "Lights", "as it is in the level"},
    Binding{UndoLights, GLFW_KEY_U, shift, "Shift+U", "Lights", "all as they are in the level"},
    Binding{SaveLights, GLFW_KEY_S, control, "Ctrl+S", "Lights",
            "save them to the .map; what was there stays beside it"},

    Binding{Help, 0, 0, "?", "Window", "all keys"},
    Binding{Panel, GLFW_KEY_TAB, 0, "Tab", "Window", "panel"},
    Binding{Statistics, GLFW_KEY_P, 0, "P", "Window", "statistics and plots"},
    Binding{Reload, GLFW_KEY_R, 0, "R", "Window", "read the level again"},
    Binding{Cancel, GLFW_KEY_ESCAPE, 0, "Esc", "Window", "give up reading; else let go of the light, close the help"},
    Binding{Screenshot, GLFW_KEY_F12, 0, "F12", "Window", "picture as PNG, in the working folder"},
    Binding{ScreenshotExr, GLFW_KEY_F12, shift, "Shift+F12", "Window", "picture as EXR"},
    Binding{FullScreen, GLFW_KEY_ENTER, alt, "Alt+Enter", "Window", "full screen"},
    Binding{VerticalSync, GLFW_KEY_V, 0, "V", "Window", "wait for the screen, or draw as fast as it goes"},
    Binding{Quit, GLFW_KEY_Q, control, "Ctrl+Q", "Window", "end"},
};
// clang-format on

} // namespace

std::span<const Binding> bindings() { return table; }

Command commandOf(int key, int modifiers) {
    modifiers &= shift | control | alt;
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9 && (modifiers == 0 || modifiers == control))
        return modifiers == control ? SetBookmark : GoToBookmark;
    for (const Binding& binding : table)
        if (binding.key != 0 && binding.key == key && binding.modifiers == modifiers) return binding.command;
    return None;
}

std::string_view keysOf(Command command) {
    for (const Binding& binding : table)
        if (binding.command == command) return binding.keys;
    return {};
}

std::string keysPage() {
    std::string page;
    std::string_view group;
    for (const Binding& binding : table) {
        if (binding.group != group) {
            page += fmt::format("{}| {} | |\n|---|---|\n", group.empty() ? "" : "\n", binding.group);
            group = binding.group;
        }
        page += fmt::format("| `{}` | {} |\n", binding.keys, binding.what);
    }
    return page;
}

} // namespace pieview
