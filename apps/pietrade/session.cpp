#include "apps/pietrade/session.h"

#include "apps/pietrade/front.h"
#include "apps/pietrade/stop.h"
#include "apps/pietrade/truth.h"
#include "pie/core/parallel.h"
#include "pie/core/whole_file.h"
#include "pie/engine/engine.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>
#include <thread>

namespace pietrade {
namespace {

namespace fs = std::filesystem;
using Planned = std::vector<std::pair<std::string, std::string>>; // settings, stage

template <class T> T valueOr(pie::Result<T> result, Exit status) {
    if (!result) throw Stop{result.error().message(), status};
    return std::move(*result);
}

Progress::Kind kindFor(const Arguments& a) {
    if (a.quiet) return Progress::Kind::None;
    return ::isatty(STDERR_FILENO) != 0 ? Progress::Kind::Bar : Progress::Kind::Lines;
}

std::string cameraText(const Arguments& a) {
    if (a.everything) return "everything";
    if (!a.camera) return "first player start";
    const Camera& c = *a.camera;
    return fmt::format("{:g} {:g} {:g} {:g} {:g}", c.eye.x, c.eye.y, c.eye.z, c.yaw, c.pitch);
}

/// A folder with files of these names that this program did not write is somebody else's.
void refuseForeign(const fs::path& folder) {
    std::error_code problem;
    if (fs::exists(folder, problem) && !fs::is_directory(folder, problem))
        throw Stop{fmt::format("{}: is no folder (name another with --out)", folder.string()), Failed};
    const bool ours = fs::exists(folder / "reference.csv", problem) || fs::exists(folder / "measurements.csv", problem);
    for (const char* name : {"report.html", "report.json"})
        if (!ours && fs::exists(folder / name, problem))
            throw Stop{
                fmt::format("{}: is there, but no reference.csv beside it: it is not of this program (name another "
                            "folder with --out)",
                            (folder / name).string()),
                Failed};
}

std::string resultLine(const Measurement& m) {
    const auto number = [](double v, const char* unit, double scale) {
        return std::isnan(v) ? std::string("unknown") : fmt::format("{:.3g}{}", scale * v, unit);
    };
    return fmt::format("error {}, {} a frame", number(m.error, " %", 100), number(m.frameMs, " ms", 1));
}

} // namespace

Session::Session(const Arguments& arguments) : a_(arguments), progress_(kindFor(arguments)) {
    refuseForeign(a_.out);
    pie::setThreads(static_cast<unsigned>(a_.settings.threads));
    subject_ = valueOr(readSubject(a_.level, a_.settings), Failed);
    if (subject_.lights.empty()) throw Stop{a_.level + ": there is no light, so there is nothing to measure", Failed};
    found_.base = a_.settings;
    found_.levelArgument = a_.level;
    found_.level = subject_.level->name;
    found_.lights = subject_.lightSummary;
    found_.machine = machine();
    found_.loadMs = a_.processorTime ? subject_.loadProcessorMs : subject_.loadMs;
    found_.processorTime = a_.processorTime;
    found_.identity = {{"program", programVersion()},
                       {"level", fmt::format("{}, content {}", found_.level, contentHash(subject_, a_.settings))},
                       {"settings", optionString(a_.settings)},
                       {"view", cameraText(a_)},
                       {"points", std::to_string(a_.points)},
                       {"reference", fmt::format("standard error {:g}, {} paths", a_.target, a_.mostPaths)},
                       {"frames", fmt::format("{} at most", a_.mostFrames)},
                       {"time", a_.processorTime ? "processor" : "wall"},
                       {"machine", found_.machine}};
    found_.measurements = valueOr(readMeasurements(a_.out / "measurements.csv", found_.identity), Failed);
    truth_ = valueOr(readTruth(a_.out / "reference.csv", found_.identity, 2 * a_.points), Failed);
    std::error_code problem;
    fs::create_directories(a_.out, problem);
    if (problem) throw Stop{fmt::format("{}: {}", a_.out.string(), problem.message()), Failed};
    progress_.say(fmt::format("{}: light: {}", found_.level, found_.lights));

    ground_.base = a_.settings;
    ground_.texelEdge = subject_.texelEdge;
    ground_.cores = std::max(1U, std::thread::hardware_concurrency());
    ground_.quick = a_.quick;
    ground_.random = a_.random;
    ground_.mostFrames = a_.mostFrames;
    ground_.seed = a_.settings.seed;
    if (!a_.noSweeps) found_.sweeps = sweeps(ground_);
    makeScenery();
}

void Session::makeScenery() {
    scenery_.level = subject_.level;
    if (a_.camera) scenery_.camera = a_.camera;
    if (!a_.camera && !a_.everything) {
        const pie::level::Level::View first = subject_.level->firstView();
        scenery_.camera = Camera{first.eye, first.yaw, 0};
    }
    scenery_.loadMs = found_.loadMs;
    scenery_.processorTime = a_.processorTime;
    scenery_.mostFrames = a_.mostFrames;
    const pie::engine::Engine engine(subject_.level, a_.settings);
    const View view = seen(engine.mesh(), *subject_.level, engine.receivers(), scenery_.camera,
                           static_cast<std::size_t>(a_.settings.cellTriangles));
    scenery_.sample = draw(engine.mesh(), engine.receivers(), view, a_.points, a_.settings.seed);
    if (scenery_.sample.points.empty())
        throw Stop{a_.level + ": nothing that can be lit is in view (see --camera and --everything)", Failed};
    for (const std::uint32_t r : scenery_.sample.vertices) where_.push_back(engine.receivers().points[r]);
    for (const SurfacePoint& point : scenery_.sample.points) where_.push_back(point.receiver);
    if (truth_.size() > where_.size())
        throw Stop{fmt::format("{}: holds more points than there are", (a_.out / "reference.csv").string()), Failed};
}

bool Session::late() const { return a_.minutes && pie::millisecondsSince(start_) > 60'000 * *a_.minutes; }

void Session::findTruth() {
    progress_.begin(where_.size(), truth_.size());
    const auto& file = a_.out / "reference.csv";
    traceTruth(subject_.scene, subject_.lights, subject_.level->tree, a_.settings, {a_.target, a_.mostPaths}, where_,
               truth_, [&] {
                   if (const auto wrong = pie::writeWhole(file, truthText(found_.identity, truth_)))
                       throw Stop{wrong->message(), Failed};
                   progress_.reach(truth_.size(), "points of the reference");
                   return !interrupted() && !late();
               });
    if (truth_.size() < where_.size()) return;
    const auto border = truth_.begin() + static_cast<std::ptrdiff_t>(scenery_.sample.vertices.size());
    scenery_.vertexTruth.assign(truth_.begin(), border);
    scenery_.pointTruth.assign(border, truth_.end());
    const auto lit = [](const std::vector<Truth>& all) {
        return static_cast<std::size_t>(
            std::count_if(all.begin(), all.end(), [](const Truth& t) { return t.irradiance != 0.0; }));
    };
    found_.vertices = lit(scenery_.vertexTruth);
    found_.points = lit(scenery_.pointTruth);
    double sum = 0;
    for (const Truth& t : truth_)
        if (t.irradiance != 0.0) sum += t.standardError / std::abs(t.irradiance);
    if (found_.points + found_.vertices > 0)
        found_.truthDeviation = sum / static_cast<double>(found_.points + found_.vertices);
    if (found_.points == 0) throw Stop{a_.level + ": all that is in view is dark, so nothing can be compared", Failed};
}

Planned Session::planned() const {
    Planned list;
    const auto add = [&](const std::string& settings, const char* stage) {
        for (const auto& [there, why] : list)
            if (there == settings) return;
        list.emplace_back(settings, stage);
    };
    add("", "default");
    for (const std::string& pairs : a_.tried) add(difference(a_.settings, changed(a_.settings, pairs)), "tried");
    for (const Sweep& sweep : found_.sweeps)
        for (const std::string& settings : sweep.settings) add(settings, "sweep");
    for (const std::string& settings : randomSettings(ground_)) add(settings, "random");
    return list;
}

Planned Session::nearPlanned() const {
    std::vector<std::string> known;
    std::vector<std::string> names;
    std::vector<Cost> costs;
    for (const auto& [settings, stage] : planned()) {
        known.push_back(settings);
        const Measurement* const m = this->known(settings);
        // More threads than one are no other point of the trade.
        if (m == nullptr || settings.find("threads=") != std::string::npos) continue;
        names.push_back(settings);
        costs.push_back({m->error, m->frameMs});
    }
    std::vector<std::string> best;
    for (const std::size_t i : front(costs)) best.push_back(names[i]);
    Planned list;
    if (best.empty()) return list;
    for (std::string& settings : nearSettings(ground_, best, known, a_.random / 2))
        list.emplace_back(std::move(settings), "near");
    return list;
}

const Measurement* Session::known(const std::string& settings) const {
    for (const Measurement& m : found_.measurements)
        if (m.settings == settings) return &m;
    return nullptr;
}

void Session::keep() {
    if (const auto wrong =
            pie::writeWhole(a_.out / "measurements.csv", measurementsText(found_.identity, found_.measurements)))
        throw Stop{wrong->message(), Failed};
}

/// Returns false when it was told to end.
bool Session::measureList(const Planned& list) {
    for (const auto& [settings, stage] : list) {
        if (known(settings) != nullptr) continue;
        if (interrupted() || late()) return false;
        progress_.step(settings.empty() ? "default" : settings);
        auto m = measure(scenery_, a_.settings, changed(a_.settings, settings), interrupted);
        if (!m) return false;
        m->settings = settings;
        m->stage = stage;
        found_.measurements.push_back(std::move(*m));
        keep();
        progress_.done(resultLine(found_.measurements.back()));
    }
    return true;
}

void Session::measureAll() {
    const Planned first = planned();
    const std::size_t near = a_.random / 2;
    found_.planned = first.size() + near;
    findTruth();
    found_.why = "the reference is not complete";
    if (truth_.size() < where_.size()) return;
    keep();
    const auto before = static_cast<std::size_t>(
        std::count_if(first.begin(), first.end(), [&](const auto& p) { return known(p.first) != nullptr; }));
    found_.why = "not all settings were measured";
    progress_.begin(first.size() + near, before);
    if (!measureList(first)) return;
    const Planned second = nearPlanned();
    found_.planned = first.size() + second.size();
    progress_.begin(second.size());
    if (!measureList(second)) return;
    found_.complete = true;
    found_.why.clear();
}

} // namespace pietrade
