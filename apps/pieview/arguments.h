#pragma once
// The command line.

#include "apps/support/camera.h"
#include "pie/core/result.h"
#include "pie/engine/settings.h"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace pieview {

struct Arguments {
    std::string level; ///< as osgpie::loadLevelNode takes it
    pie::engine::Settings settings;
    std::optional<apps::Camera> camera;
    int width = 1280, height = 800;
    float fieldOfView = 90;
    std::string screenshot; ///< empty: a window
    std::optional<int> frames;
    int pathPictures = 0; ///< along the recorded path
    bool statistics = false;
    [[nodiscard]] bool headless() const { return !screenshot.empty() || statistics; }
};

/// What to do, or the exit status of a program that is done: help was asked for (0), or the command line is wrong (2)
/// and standard error says how.
[[nodiscard]] std::variant<Arguments, int> readArguments(int argc, const char* const* argv);

} // namespace pieview
