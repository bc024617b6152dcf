// pieshot: a picture of a level, rendered through the plug-in as any OSG program would, with or without a display.
#include "apps/support/camera.h"
#include "apps/support/picture_file.h"
#include "apps/support/virtual_display.h"
#include "pie/core/clock.h"
#include "pie/engine/settings.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <osg/CameraView>
#include <osg/ValueObject>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/Registry>
#include <osgUtil/Optimizer>
#include <osgViewer/Viewer>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace {

namespace fs = std::filesystem;

struct Arguments {
    std::string level, output;
    std::optional<int> frames;
    int width = 1024, height = 768, samples = 4;
    double fieldOfView = 90;
    std::string camera, game, map, threading = "SingleThreaded";
    std::vector<std::string> settings;
    bool stats = false, optimize = false;
};

[[noreturn]] void fail(const std::string& message) {
    fmt::print(stderr, "pieshot: {}\n", message);
    std::exit(1);
}

/// The plug-in of the build or installation this program belongs to, before any other. OSG_LIBRARY_PATH still comes
/// first.
void preferOwnPlugin() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error) return;
    const fs::path library = program.parent_path().parent_path() / "lib";
    auto& paths = osgDB::Registry::instance()->getLibraryFilePathList();
    if (!std::getenv("OSG_LIBRARY_PATH") && fs::is_directory(library, error)) paths.push_front(library.string());
}

/// Key=value pairs as an option string. A value with a space cannot pass through OSG's options.
std::string optionString(const Arguments& arguments) {
    std::string options;
    const auto add = [&](const std::string& pair) {
        if (pair.find_first_of(" \t") != std::string::npos)
            fail(fmt::format("--set {}: a value with spaces cannot pass through OSG's option string (put it in a TOML "
                             "file: --set config=FILE)",
                             pair));
        options += (options.empty() ? "" : " ") + pair;
    };
    for (const std::string& pair : arguments.settings) add(pair);
    if (!arguments.game.empty()) add("game=" + arguments.game);
    if (arguments.stats) add("stats=true");
    return options;
}

/// Frames without drawing until the light of what the last drawn frame showed stands still.
void settle(osgViewer::Viewer& viewer, const osg::Node& level) {
    bool settled = false;
    while (level.getUserValue("pie.settled", settled) && !settled) {
        viewer.advance();
        viewer.updateTraversal();
    }
}

/// The level's own starting view, which the plug-in adds as a CameraView.
struct FindStart : osg::NodeVisitor {
    FindStart() : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN) {}
    void apply(osg::CameraView& view) override {
        if (!start) start = &view;
    }
    osg::ref_ptr<osg::CameraView> start;
};

osg::Vec3d vector(const pie::Vec3& v) { return {double{v.x}, double{v.y}, double{v.z}}; }

osg::Matrixd viewMatrix(const Arguments& arguments, osg::Node& scene) {
    if (!arguments.camera.empty()) {
        const auto camera = apps::parseCamera(arguments.camera);
        if (!camera) fail(fmt::format(R"(--camera "{}": expected "x y z yaw pitch")", arguments.camera));
        return osg::Matrixd::lookAt(vector(camera->eye), vector(camera->eye + apps::ahead(*camera)),
                                    vector(apps::above(*camera)));
    }
    FindStart find;
    scene.accept(find);
    if (!find.start) {
        const osg::BoundingSphere& bound = scene.getBound();
        const osg::Vec3d centre(bound.center());
        const osg::Vec3d back(0, -2.5 * static_cast<double>(bound.radius()), 0);
        return osg::Matrixd::lookAt(centre + back, centre, osg::Vec3d(0, 0, 1));
    }
    osg::Matrixd matrix;
    find.start->computeWorldToLocalMatrix(matrix, nullptr);
    return matrix;
}

osg::ref_ptr<osg::GraphicsContext> makeContext(const Arguments& arguments, int samples) {
    osg::ref_ptr traits = new osg::GraphicsContext::Traits;
    traits->readDISPLAY();
    traits->width = arguments.width;
    traits->height = arguments.height;
    traits->windowDecoration = false;
    traits->doubleBuffer = true;
    traits->samples = static_cast<unsigned>(samples);
    traits->sampleBuffers = samples > 0 ? 1 : 0;
    return osg::GraphicsContext::createGraphicsContext(traits);
}

/// Copies the finished frame.
struct Capture : osg::Camera::DrawCallback {
    explicit Capture(osg::Image* target) : image(target) {}
    void operator()(osg::RenderInfo& info) const override {
        const osg::Viewport* viewport = info.getCurrentCamera()->getViewport();
        image->readPixels(0, 0, static_cast<int>(viewport->width()), static_cast<int>(viewport->height()), GL_RGB,
                          GL_UNSIGNED_BYTE, 1);
    }
    osg::ref_ptr<osg::Image> image;
};

osgViewer::ViewerBase::ThreadingModel threadingModel(const std::string& name) {
    using Viewer = osgViewer::ViewerBase;
    if (name == "CullDrawThreadPerContext") return Viewer::CullDrawThreadPerContext;
    if (name == "DrawThreadPerContext") return Viewer::DrawThreadPerContext;
    if (name == "CullThreadPerCameraDrawThreadPerContext") return Viewer::CullThreadPerCameraDrawThreadPerContext;
    return Viewer::SingleThreaded;
}

void writePicture(const osg::Image& image, const std::string& output) {
    apps::FloatPicture picture{image.s(), image.t(), {}};
    for (int row = image.t() - 1; row >= 0; --row)
        for (int i = 0; i < 3 * image.s(); ++i)
            picture.rgb.push_back(static_cast<float>(image.data(0, static_cast<unsigned>(row))[i]) / 255.0F);
    if (const auto error = apps::writePicture(output, picture)) fail(error->message());
}

osg::ref_ptr<osg::Node> readLevel(const Arguments& arguments, const std::string& options) {
    osg::ref_ptr readOptions = new osgDB::Options(options);
    const std::string name = arguments.map.empty()
                                 ? arguments.level
                                 : arguments.map + (osgDB::getLowerCaseFileExtension(arguments.map) == "bsp" ||
                                                            osgDB::getLowerCaseFileExtension(arguments.map) == "map"
                                                        ? ""
                                                        : ".bsp");
    auto result = osgDB::Registry::instance()->readNode(name, readOptions);
    if (!result.validNode()) {
        if (!result.message().empty()) fail(result.message());
        fail(result.notFound() ? fmt::format("{}: no such file", name)
                               : fmt::format("{}: no level; .bsp and .map files are, on disk or inside a pk3", name));
    }
    return result.getNode();
}

void render(const Arguments& arguments) {
    const std::string options = optionString(arguments);
    // By default a first frame says what is in view; the second, once its light is settled, is the picture.
    const int frames = arguments.frames.value_or(2);
    std::optional<apps::VirtualDisplay> display;
    const char* shown = std::getenv("DISPLAY");
    if (!shown || !*shown) {
        auto started = apps::VirtualDisplay::start(arguments.width, arguments.height);
        if (!started) fail(started.error().message());
        display.emplace(std::move(*started));
    }
    const auto start = pie::Clock::now();
    const osg::ref_ptr<osg::Node> scene = readLevel(arguments, options);
    const double readMs = pie::millisecondsSince(start);
    double firstFrameMs = 0;
    if (arguments.optimize) osgUtil::Optimizer().optimize(scene);

    osg::ref_ptr<osg::GraphicsContext> context = makeContext(arguments, arguments.samples);
    if (!context && arguments.samples > 0) context = makeContext(arguments, 0);
    if (!context)
        fail("no OpenGL context (is DISPLAY right, and are Mesa's drivers installed: package libgl1-mesa-dri?)");

    osgViewer::Viewer viewer;
    osg::Camera& camera = *viewer.getCamera();
    camera.setGraphicsContext(context);
    camera.setViewport(new osg::Viewport(0, 0, arguments.width, arguments.height));
    const double aspect = static_cast<double>(arguments.width) / arguments.height;
    const double half = std::atan(std::tan(osg::DegreesToRadians(arguments.fieldOfView) / 2.0) / aspect);
    camera.setProjectionMatrixAsPerspective(osg::RadiansToDegrees(2.0 * half), aspect, 1.0, 10000.0);
    camera.setViewMatrix(viewMatrix(arguments, *scene));
    camera.setClearColor({0, 0, 0, 1});
    osg::ref_ptr image = new osg::Image;
    viewer.setLightingMode(osg::View::NO_LIGHT);
    viewer.setThreadingModel(threadingModel(arguments.threading));
    viewer.setSceneData(scene);
    viewer.realize();
    for (int i = 0; i < frames; ++i) {
        if (i + 1 == frames) {
            if (!arguments.frames) settle(viewer, *scene);
            viewer.stopThreading(); // the frame that is captured is whole when frame() returns
            viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
            camera.setFinalDrawCallback(new Capture(image));
        }
        const auto frame = pie::Clock::now();
        viewer.frame();
        if (i == 0) firstFrameMs = pie::millisecondsSince(frame);
    }
    if (arguments.stats) {
        viewer.advance();
        viewer.updateTraversal(); // the plug-in writes its statistics in the update stage
        std::string statistics;
        if (!scene->getUserValue("pie.statistics", statistics)) fail("the reader of this level keeps no statistics");
        fmt::print("{{\"read_ms\":{:.3f},\"first_frame_ms\":{:.3f},{}\n", readMs, firstFrameMs, statistics.substr(1));
    }
    writePicture(*image, arguments.output);
}

int run(int argc, char** argv) {
    Arguments arguments;
    CLI::App app{"A picture of a Quake 3 level, lit by photons.\n\n"
                 "  pieshot maps/oa_dm1.bsp out.png\n"
                 "  pieshot pak1-maps.pk3/maps/oa_dm1.bsp out.png --camera \"0 0 64 90 0\" --set view=baked\n"
                 "  pieshot --game baseoa --map oa_dm1 out.png --stats"};
    std::vector<std::string> places;
    app.add_option("LEVEL OUT.png", places,
                   "level (a .bsp or .map on disk or inside a pk3; not with --map) and picture")
        ->expected(1, 2)
        ->required();
    app.add_option("--frames", arguments.frames,
                   "frames before the picture is taken (default: until its light is settled)")
        ->check(CLI::Range(1, 1'000'000));
    app.add_option("--width", arguments.width, "pixels")->check(CLI::Range(16, 8192))->capture_default_str();
    app.add_option("--height", arguments.height, "pixels")->check(CLI::Range(16, 8192))->capture_default_str();
    app.add_option("--fov", arguments.fieldOfView, "horizontal field of view, degrees")
        ->check(CLI::Range(1.0, 170.0))
        ->capture_default_str();
    app.add_option(
        "--camera", arguments.camera,
        "\"x y z yaw pitch\" in units and degrees, pitch positive downwards (default: the first player start)");
    app.add_option("--samples", arguments.samples, "antialiasing samples per pixel")
        ->check(CLI::Range(0, 16))
        ->capture_default_str();
    app.add_option("--game", arguments.game, "game directory (with *.pk3 or maps/)");
    app.add_option("--map", arguments.map, "name of a map in the game directory");
    app.add_option("--set", arguments.settings, "key=value, any setting of doc/settings.md; may be repeated")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--threading", arguments.threading, "threading model of the viewer")
        ->check(CLI::IsMember({"SingleThreaded", "CullDrawThreadPerContext", "DrawThreadPerContext",
                               "CullThreadPerCameraDrawThreadPerContext"}))
        ->capture_default_str();
    app.add_flag("--optimize", arguments.optimize, "run OSG's optimizer on the level first, as osgviewer does");
    app.add_flag("--stats", arguments.stats, "print what was done as one line of JSON");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const bool named = !arguments.map.empty();
    if (places.size() != (named ? 1U : 2U))
        fail(named ? "with --map only the picture is named" : "a level and a picture are needed; see --help");
    arguments.output = places.back();
    if (!named) arguments.level = places.front();
    if (osgDB::getLowerCaseFileExtension(arguments.output) != "png")
        fail(fmt::format("{}: the picture's name must end in .png", arguments.output));
    preferOwnPlugin();
    render(arguments);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "pieshot: %s\n", error.what());
        return 1;
    }
}
