// The report of `piebench frame` as tables.

#include "apps/piebench/frame.h"

#include <fmt/format.h>

#include <iterator>

namespace piebench {
namespace {

std::string percent(const Json& errors, const char* key) {
    return errors.is_object() ? fmt::format("{:.1f}", 100 * number(errors[key])) : "–";
}

void frameRow(fmt::memory_buffer& text, const Json& run, const char* kind) {
    const Json& f = run[kind];
    fmt::format_to(std::back_inserter(text),
                   "| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {} | {} | {} |\n",
                   run["estimator"].get<std::string>(), kind, number(f["trace_ms"]), number(f["build_ms"]),
                   number(f["estimate_ms"]), number(f["upload_ms"]), number(f["total_ms"]), number(f["processor_ms"]),
                   percent(f["error"], "rms"), percent(f["error"], "rms_99"), percent(f["error"], "median"));
}

} // namespace

double number(const Json& value) { return value.is_number() ? value.get<double>() : 0.0; }

std::string frameText(const Json& report) {
    fmt::memory_buffer text;
    const auto to = std::back_inserter(text);
    const Json& machine = report["machine"];
    fmt::format_to(to, "{}: {} triangles, {} receivers, {} lights, {} photons stored of {} emitted\n",
                   report["level"].get<std::string>(), number(report["triangles"]), number(report["receivers"]),
                   number(report["lights"]), number(report["photons"]["stored"]), number(report["photons"]["emitted"]));
    fmt::format_to(to, "{}, {} cores, {} thread(s), load {:.2f} before and {:.2f} after\n",
                   machine["processor"].get<std::string>(), number(machine["cores"]), number(report["threads"]),
                   number(machine["load"][0]), number(report["load_after"][0]));
    if (const Json& reference = report["reference"]; reference.is_object())
        fmt::format_to(to, "reference: {} vertices at {:.1f} % of their own, {}\n", number(reference["points"]),
                       100 * number(reference["own_error_rms"]),
                       reference["kept"].get<bool>() ? "kept from an earlier run" : "computed now and kept");
    bool headed = false;
    for (const Json& run : report["runs"]) {
        if (!run.contains("estimator")) continue;
        if (!headed)
            fmt::format_to(to,
                           "\nMilliseconds, medians; processor: of all threads together. Errors in %.\n\n"
                           "| estimator | frame | trace | build | estimate | upload | total | processor | error, rms "
                           "| rms of 99 % | error, median |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
        headed = true;
        for (const char* kind : {"full", "steady"}) frameRow(text, run, kind);
    }
    fmt::format_to(to, "\n");
    for (const Json& run : report["runs"]) {
        if (run.contains("estimator")) {
            fmt::format_to(to,
                           "{}: prepared in {:.0f} ms; {:.3g} photons stored and {:.3g} estimates a second; {:.0f} "
                           "bytes a vertex, {:.0f} a photon\n",
                           run["estimator"].get<std::string>(), number(run["prepare_ms"]),
                           number(run["full"]["photons_stored_per_second"]),
                           number(run["full"]["estimates_per_second"]), number(run["bytes_per_vertex"]),
                           number(run["bytes_per_photon"]));
        } else {
            const Json& rays = run["rays"];
            fmt::format_to(to, "bare Embree: {} rays in {:.2f} ms one by one, {:.2f} in packets; our tracer {:.2f}\n",
                           number(rays["rays"]), number(rays["single_ms"]), number(rays["packets_ms"]),
                           number(rays["tracer_ms"]));
        }
    }
    for (const auto& [other, ratios] : report["ratios"].items()) {
        fmt::format_to(to, "over {}:", other);
        for (const auto& [what, value] : ratios.items()) fmt::format_to(to, " {} {:.4g}", what, number(value));
        fmt::format_to(to, "\n");
    }
    if (const Json& scaling = report["scaling"]; scaling.is_object())
        fmt::format_to(to, "{} threads over one: full frame {:.2f}, steady {:.2f}\n", number(scaling["threads"]),
                       number(scaling["full"]), number(scaling["steady"]));
    for (const Json& target : report["targets"])
        fmt::format_to(to, "{}: {:.4g}, wanted {} {:.4g}: {}\n", target["what"].get<std::string>(),
                       number(target["value"]), target.contains("at_most") ? "at most" : "at least",
                       number(target.contains("at_most") ? target["at_most"] : target["at_least"]),
                       target["met"].get<bool>() ? "met" : "missed");
    return fmt::to_string(text);
}

} // namespace piebench
