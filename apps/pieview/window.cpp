#include "apps/pieview/window.h"

#include "apps/pieview/frame.h"
#include "apps/pieview/light_picking.h"
#include "apps/pieview/panel.h"
#include "apps/pieview/session.h"
#include "pie/core/clock.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

namespace pieview {
namespace {

int fail(const std::string& message) {
    fmt::print(stderr, "pieview: {}\n", message);
    return 1;
}

class Window {
public:
    Window(GLFWwindow* window, const Arguments& arguments)
        : window_(window), fieldOfView_(arguments.fieldOfView),
          session_(arguments.level, arguments.settings, arguments.camera, [] { glfwPostEmptyEvent(); }) {
        glfwSetWindowUserPointer(window, this);
        glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
            self(w).onKey(key, action, modifiers);
        });
        glfwSetCharCallback(window, [](GLFWwindow* w, unsigned code) { self(w).onCharacter(code); });
        glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
            self(w).onButton(button, action, modifiers);
        });
        glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) { self(w).onMove(x, y); });
        glfwSetScrollCallback(window, [](GLFWwindow* w, double, double y) { self(w).onWheel(y); });
        glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { self(w).stir(); });
        glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { self(w).stir(); });
        glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int) { self(w).stir(); });
        glfwSwapInterval(1);
        updateLens();
        frame_ = Frame::inWindow(*session_.scene(), lens_.width, lens_.height);
        float scaleX = 1;
        glfwGetWindowContentScale(window, &scaleX, nullptr);
        panelScale_ = std::max(1.0F, scaleX);
        IMGUI_CHECKVERSION();
        ImGui::CreateContext();
        ImGui_ImplGlfw_InitForOpenGL(window, true);
        ImGui_ImplOpenGL3_Init("#version 130");
        styleForPanel(panelScale_);
    }
    ~Window() {
        frame_->releaseObjects();
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    int run() {
        double last = glfwGetTime();
        while (!session_.ended()) {
            waitForWork();
            if (glfwWindowShouldClose(window_) != 0) {
                glfwSetWindowShouldClose(window_, GLFW_FALSE); // what is not saved is asked about
                session_.run(Command::Quit);
            }
            const double now = glfwGetTime();
            const double seconds = now - last;
            last = now;
            session_.step(seconds, held());
            obey(session_.takeWindowCommand());
            // Windows of the panel that appear are measured in one frame and shown in the next.
            if (std::exchange(seenLoads_, session_.loads()) != session_.loads()) stir();
            if (session_.looks().timeRuns) levelTime_ += seconds;
            if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) != 0) continue;
            if (session_.needsFrame() || session_.loading() || stirred_ > 0) drawFrame();
        }
        return 0;
    }

private:
    static Window& self(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

    /// Something happened: the panel needs a few frames to follow.
    void stir() { stirred_ = 3; }

    void waitForWork() {
        constexpr double hidden = 0.25;
        constexpr double still = 0.1; // how soon a save is seen
        if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED) != 0)
            glfwWaitEventsTimeout(hidden);
        else if (session_.needsFrame() || stirred_ > 0 || moving())
            glfwPollEvents();
        else
            glfwWaitEventsTimeout(still);
    }

    void updateLens() {
        int width = 1;
        int height = 1;
        glfwGetFramebufferSize(window_, &width, &height);
        lens_ = {fieldOfView_, std::max(1, width), std::max(1, height)};
    }

    void drawFrame() {
        const auto start = pie::Clock::now();
        updateLens();
        frame_->look(session_.camera(), lens_);
        frame_->draw(levelTime_);
        if (const auto name = session_.takePictureName()) takePicture(*name);
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        drawPanel(session_, {lens_, panelScale_, pixelsPerPoint()});
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
        glfwSwapBuffers(window_);
        if (stirred_ > 0) --stirred_;
        session_.frameDrawn(pie::millisecondsSince(start));
        title();
    }

    void takePicture(const std::string& name) {
        const bool floats = std::filesystem::path(name).extension() != ".png";
        const auto error = apps::writePicture(name, frame_->picture(levelTime_, floats));
        session_.say(error ? error->message() : name);
        frame_->draw(levelTime_); // the panel is drawn over the window again
    }

    void title() {
        std::string text = fmt::format("{} - pieview", std::filesystem::path(session_.levelName()).filename().string());
        if (text == title_) return;
        glfwSetWindowTitle(window_, text.c_str());
        title_ = std::move(text);
    }

    // Input
    [[nodiscard]] bool down(int key) const { return glfwGetKey(window_, key) == GLFW_PRESS; }
    [[nodiscard]] bool controlDown() const { return down(GLFW_KEY_LEFT_CONTROL) || down(GLFW_KEY_RIGHT_CONTROL); }
    [[nodiscard]] bool shiftDown() const { return down(GLFW_KEY_LEFT_SHIFT) || down(GLFW_KEY_RIGHT_SHIFT); }

    [[nodiscard]] Held held() const {
        Held result;
        if (ImGui::GetIO().WantTextInput || controlDown()) return result;
        const auto axis = [this](int more, int less) {
            return (down(more) ? 1.0F : 0.0F) - (down(less) ? 1.0F : 0.0F);
        };
        result.push = {axis(GLFW_KEY_D, GLFW_KEY_A), axis(GLFW_KEY_W, GLFW_KEY_S), axis(GLFW_KEY_SPACE, GLFW_KEY_C)};
        result.fast = shiftDown();
        return result;
    }
    [[nodiscard]] bool moving() const { return held().push != Vec3(0.0F) || session_.playing(); }

    void onKey(int key, int action, int modifiers) {
        stir();
        if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
        const bool shift = (modifiers & GLFW_MOD_SHIFT) != 0;
        if ((modifiers & GLFW_MOD_CONTROL) == 0) {
            constexpr float step = 8;
            if (key == GLFW_KEY_LEFT) return session_.nudge(-step, 0, false);
            if (key == GLFW_KEY_RIGHT) return session_.nudge(step, 0, false);
            if (key == GLFW_KEY_UP) return session_.nudge(0, step, shift);
            if (key == GLFW_KEY_DOWN) return session_.nudge(0, -step, shift);
        }
        const Command command = commandOf(key, modifiers);
        if (command != Command::None) session_.run(command, key - GLFW_KEY_0);
    }

    void onCharacter(unsigned code) {
        stir();
        if (code == '?' && !ImGui::GetIO().WantTextInput) session_.run(Command::Help);
    }

    /// Window coordinates are points; a picture has pixels.
    [[nodiscard]] float pixelsPerPoint() const {
        int width = 0;
        glfwGetWindowSize(window_, &width, nullptr);
        return width > 0 ? static_cast<float>(lens_.width) / static_cast<float>(width) : 1.0F;
    }
    [[nodiscard]] Vec2 pixelUnderMouse() const {
        std::array<double, 2> at{};
        glfwGetCursorPos(window_, at.data(), &at[1]);
        return Vec2(static_cast<float>(at[0]), static_cast<float>(at[1])) * pixelsPerPoint();
    }
    [[nodiscard]] float dividerPixel() { return (session_.looks().split + 1) * 0.5F * static_cast<float>(lens_.width); }

    void onButton(int button, int action, int /*modifiers*/) {
        stir();
        const Vec2 pixel = pixelUnderMouse();
        if (action == GLFW_RELEASE) {
            if (button == GLFW_MOUSE_BUTTON_RIGHT) looking_ = false;
            if (button == GLFW_MOUSE_BUTTON_LEFT) drag_ = Drag::None;
            return;
        }
        if (ImGui::GetIO().WantCaptureMouse) return;
        lastPixel_ = pixel;
        if (button == GLFW_MOUSE_BUTTON_RIGHT) looking_ = true;
        if (button == GLFW_MOUSE_BUTTON_LEFT) grab(pixel);
    }

    void grab(const Vec2& pixel) {
        const float reach = 10 * panelScale_ * pixelsPerPoint();
        if (session_.looks().view == pie::engine::View::Split && std::abs(pixel.x - dividerPixel()) < reach) {
            drag_ = Drag::Divider;
            return;
        }
        if (!session_.looks().lightIcons) return;
        session_.select(pickLight(session_.lights(), session_.camera(), lens_, pixel, 1.4F * reach));
        if (!session_.selected()) return;
        const auto place = positionOf(session_.lights().light(*session_.selected()));
        if (!place) return;
        drag_ = Drag::Light;
        grabbedPixel_ = pixel;
        grabbedPlace_ = *place;
    }

    void onMove(double /*x*/, double /*y*/) {
        stir();
        const Vec2 pixel = pixelUnderMouse();
        if (looking_) session_.look((pixel - lastPixel_) / pixelsPerPoint());
        lastPixel_ = pixel;
        if (drag_ == Drag::Divider)
            session_.looks().split = std::clamp(2 * pixel.x / static_cast<float>(lens_.width) - 1, -1.0F, 1.0F);
        if (drag_ != Drag::Light || !session_.selected()) return;
        const DragAlong along = shiftDown()     ? DragAlong::Vertical
                                : controlDown() ? DragAlong::Axis
                                                : DragAlong::Picture;
        const std::size_t number = *session_.selected();
        const Vec3 place = dragged(grabbedPlace_, session_.camera(), lens_, grabbedPixel_, pixel, along);
        session_.lights().set(number, movedTo(session_.lights().light(number), place));
    }

    void onWheel(double notches) {
        stir();
        if (!ImGui::GetIO().WantCaptureMouse) session_.wheel(static_cast<float>(notches));
    }

    void obey(Command command) {
        if (command == Command::VerticalSync) {
            verticalSync_ = !verticalSync_;
            glfwSwapInterval(verticalSync_ ? 1 : 0);
            session_.say(verticalSync_ ? "waits for the screen" : "draws as fast as it goes");
        }
        if (command != Command::FullScreen) return;
        stir();
        if (glfwGetWindowMonitor(window_)) {
            glfwSetWindowMonitor(window_, nullptr, placeBefore_[0], placeBefore_[1], placeBefore_[2], placeBefore_[3],
                                 GLFW_DONT_CARE);
            return;
        }
        glfwGetWindowPos(window_, placeBefore_.data(), &placeBefore_[1]);
        glfwGetWindowSize(window_, &placeBefore_[2], &placeBefore_[3]);
        GLFWmonitor* monitor = glfwGetPrimaryMonitor();
        const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
        if (mode) glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
    }

    enum class Drag : std::uint8_t { None, Divider, Light };

    GLFWwindow* window_;
    float fieldOfView_;
    Session session_;
    std::unique_ptr<Frame> frame_;
    apps::Lens lens_;
    float panelScale_ = 1;
    double levelTime_ = 0;
    int stirred_ = 3;
    unsigned seenLoads_ = 0;
    bool looking_ = false, verticalSync_ = true;
    Drag drag_ = Drag::None;
    Vec2 lastPixel_{0.0F}, grabbedPixel_{0.0F};
    Vec3 grabbedPlace_{0.0F};
    std::array<int, 4> placeBefore_{};
    std::string title_;
};

/// GLFW's own library lives as long as this.
class Library {
public:
    Library() : works_(glfwInit() == GLFW_TRUE) {}
    ~Library() {
        if (works_) glfwTerminate();
    }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    [[nodiscard]] bool works() const { return works_; }

private:
    bool works_;
};

} // namespace

int runWindow(const Arguments& arguments) {
    std::error_code error;
    if (arguments.settings.game.empty() && !std::filesystem::exists(filesOfLevel(arguments.level).front(), error))
        return fail(arguments.level + ": no such file");
    glfwSetErrorCallback([](int, const char*) {}); // said below, in one line
    const Library library;
    if (!library.works()) return fail("no display (set DISPLAY, or take a picture with --screenshot OUT.png)");
    glfwWindowHint(GLFW_SAMPLES, 4);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    GLFWwindow* window = glfwCreateWindow(arguments.width, arguments.height, "pieview", nullptr, nullptr);
    if (!window) {
        glfwWindowHint(GLFW_SAMPLES, 0);
        window = glfwCreateWindow(arguments.width, arguments.height, "pieview", nullptr, nullptr);
    }
    if (!window) return fail("no OpenGL window (are Mesa's drivers installed: package libgl1-mesa-dri?)");
    glfwMakeContextCurrent(window);
    const int status = Window(window, arguments).run();
    glfwDestroyWindow(window);
    return status;
}

} // namespace pieview
