#include "apps/pieview/headless.h"

#include "apps/pieview/frame.h"
#include "apps/pieview/session.h"
#include "apps/support/virtual_display.h"
#include "pie/core/clock.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

namespace pieview {
namespace {

int fail(const std::string& message) {
    fmt::print(stderr, "pieview: {}\n", message);
    return 1;
}

/// All but the last frame, which is the picture: so many, or one that says what is in view and then its light,
/// finished.
void light(Frame& frame, Session& session, const std::optional<int>& frames) {
    for (int i = 0; i < frames.value_or(2) - 1; ++i) {
        frame.draw(0);
        session.frameDrawn(0);
        session.step(0, {});
    }
    while (!frames && !session.settled()) frame.update(0);
}

std::string numbered(const std::string& file, int number) {
    const std::filesystem::path path(file);
    return (path.parent_path() / fmt::format("{}-{:04}{}", path.stem().string(), number, path.extension().string()))
        .string();
}

std::optional<pie::Error> takePictures(Frame& frame, Session& session, const Arguments& arguments,
                                       const apps::Lens& lens) {
    const bool floats = std::filesystem::path(arguments.screenshot).extension() != ".png";
    if (arguments.pathPictures == 0) return apps::writePicture(arguments.screenshot, frame.picture(0, floats));
    const CameraPath path(session.notes().path);
    if (path.empty())
        return pie::Error{session.levelName(), "", "no path is recorded", "in the window, K adds places to it"};
    for (int i = 0; i < arguments.pathPictures; ++i) {
        const float share = static_cast<float>(i) / static_cast<float>(arguments.pathPictures - 1);
        frame.look(path.at(share * path.length()), lens);
        light(frame, session, arguments.frames);
        if (auto error = apps::writePicture(numbered(arguments.screenshot, i + 1), frame.picture(0, floats)))
            return error;
    }
    return std::nullopt;
}

} // namespace

int runHeadless(const Arguments& arguments) {
    std::optional<apps::VirtualDisplay> display;
    const char* shown = std::getenv("DISPLAY");
    if (!shown || !*shown) {
        auto started = apps::VirtualDisplay::start(64, 64);
        if (!started) return fail(started.error().message());
        display.emplace(std::move(*started));
    }
    Session session(arguments.level, arguments.settings, arguments.camera);
    while (session.loading()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        session.step(0, {});
    }
    if (!session.error().empty()) return fail(session.error());
    auto frame = Frame::inMemory(*session.scene());
    if (!frame) return fail(frame.error().message());
    const apps::Lens lens{arguments.fieldOfView, arguments.width, arguments.height};
    (*frame)->look(session.camera(), lens);
    const auto start = pie::Clock::now();
    light(**frame, session, arguments.frames);
    const double lightMs = pie::millisecondsSince(start);
    if (!arguments.screenshot.empty())
        if (const auto error = takePictures(**frame, session, arguments, lens)) return fail(error->message());
    if (arguments.statistics)
        fmt::print("{{\"load_ms\":{:.3f},\"light_ms\":{:.3f},{}\n", session.loadMilliseconds(), lightMs,
                   session.level()->engine().statistics().json().substr(1));
    return 0;
}

} // namespace pieview
