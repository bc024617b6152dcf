#pragma once
// The truth at some vertices, by path tracing: computed once for a level and its lights and kept in a file, which is
// read again while nothing that matters has changed. The name of the file is a hash of all that goes in (positions,
// reflectances, lights, the sampled receivers, target), so that a changed level or setting has a file of its own; a
// file that is damaged is made anew. It appears whole or not at all.

#include "apps/piebench/subject.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace piebench {

struct ReferenceOptions {
    std::size_t sample = 300; ///< receivers, at most
    double target = 0.02;     ///< relative standard error of each
    std::uint64_t mostPaths = 1 << 16;
    std::filesystem::path folder; ///< of the files; empty: defaultFolder()
};

struct Reference {
    std::vector<std::uint32_t> receivers; ///< of the subject
    std::vector<double> irradiance;       ///< mean of the channels, watts per square unit
    std::vector<double> standardError;    ///< of it
    std::size_t reached = 0;              ///< how many reached the target
    bool kept = false;                    ///< read from the file
    double seconds = 0;                   ///< that it took to compute, now or then
    std::filesystem::path file;
};

/// $XDG_CACHE_HOME/piebench, else ~/.cache/piebench, else a folder for temporary files.
[[nodiscard]] std::filesystem::path defaultFolder();
/// `progress` is told how many of the sample are done. An error where the file cannot be written.
[[nodiscard]] pie::Result<Reference> reference(const Subject& subject, const pie::engine::Settings& settings,
                                               const ReferenceOptions& options,
                                               const std::function<void(std::size_t, std::size_t)>& progress);

/// How far answers are from the truth, in parts of one, where the truth is more than nothing.
struct Errors {
    double rms = 0; ///< of (answer − E) / (E + 0.1 mean E)
    /// The same without the worst hundredth: a vertex that lies on the edge of another surface may be on either side of
    /// it, and one such vertex outweighs all others.
    double rms99 = 0;
    double median = 0; ///< of |answer / E − 1|
    double mean = 0;   ///< mean answer / mean E − 1
    std::size_t points = 0;
};
/// `answers` of a subject that asks one question per receiver.
[[nodiscard]] Errors errors(const Reference& reference, std::span<const pie::Rgb> answers);
/// The same of the reference itself, by its standard errors: what Errors::rms would be for a perfect answer.
[[nodiscard]] double ownError(const Reference& reference);

} // namespace piebench
