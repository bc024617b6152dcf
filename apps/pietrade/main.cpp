// pietrade: what speed costs in accuracy on a level, measured, with a report.

#include "apps/pietrade/arguments.h"
#include "apps/pietrade/report.h"
#include "apps/pietrade/session.h"
#include "apps/pietrade/stop.h"
#include "pie/core/whole_file.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>

namespace {

void write(const std::filesystem::path& file, const std::string& content) {
    if (const auto wrong = pie::writeWhole(file, content)) throw pietrade::Stop{wrong->message(), pietrade::Failed};
}

int trade(const pietrade::Arguments& arguments) {
    pietrade::catchInterrupts();
    pietrade::Session session(arguments);
    session.measureAll();
    const pietrade::Findings& found = session.findings();
    const pietrade::Analysis analysis = pietrade::analyse(found);
    write(arguments.out / "report.json", pietrade::reportJson(found, analysis));
    write(arguments.out / "report.html", pietrade::reportHtml(found, analysis));
    if (!arguments.quiet)
        for (const std::string& line : pietrade::advice(found, analysis)) fmt::print("{}\n", line);
    session.progress().say((arguments.out / "report.html").string());
    if (found.complete) return pietrade::Done;
    session.progress().say(fmt::format("ended early, {} of {} settings measured; the same command goes on",
                                       found.measurements.size(), found.planned));
    return pietrade::Incomplete;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return trade(pietrade::parseArguments(argc, argv));
    } catch (const pietrade::Stop& stop) {
        if (!stop.message.empty()) fmt::print(stderr, "pietrade: {}\n", stop.message);
        return stop.status;
    } catch (const std::exception& problem) {
        fmt::print(stderr, "pietrade: {}\n", problem.what());
        return pietrade::Failed;
    }
}
