#pragma once
// One call of the program on one level: reads what the folder keeps, measures what is missing, keeps it.

#include "apps/pietrade/arguments.h"
#include "apps/pietrade/kept.h"
#include "apps/pietrade/measure.h"
#include "apps/pietrade/plan.h"
#include "apps/pietrade/progress.h"
#include "apps/pietrade/subject.h"

#include <string>
#include <utility>
#include <vector>

namespace pietrade {

/// All that a report is made from.
struct Findings {
    Identity identity;
    std::string level, lights, machine;
    std::string levelArgument; ///< as the user named it
    pie::engine::Settings base;
    std::vector<Sweep> sweeps;
    std::vector<Measurement> measurements; ///< in the order in which they were made
    std::size_t points = 0, vertices = 0;  ///< of the sample, that count
    double truthDeviation = unknown;       ///< mean relative standard error of the reference
    double loadMs = 0;
    bool processorTime = false;
    std::size_t planned = 0; ///< settings, with those measured
    bool complete = false;
    std::string why; ///< it is not complete
};

class Session {
public:
    /// Reads level and folder; throws Stop.
    explicit Session(const Arguments& arguments);
    /// Measures until all is there, or until it is told to end.
    void measureAll();
    [[nodiscard]] const Findings& findings() const { return found_; }
    [[nodiscard]] Progress& progress() { return progress_; }

private:
    void makeScenery();
    void findTruth();
    [[nodiscard]] bool measureList(const std::vector<std::pair<std::string, std::string>>& list);
    [[nodiscard]] std::vector<std::pair<std::string, std::string>> planned() const;
    [[nodiscard]] std::vector<std::pair<std::string, std::string>> nearPlanned() const;
    [[nodiscard]] const Measurement* known(const std::string& settings) const;
    [[nodiscard]] bool late() const;
    void keep();

    const Arguments& a_;
    Progress progress_;
    Findings found_;
    Subject subject_;
    Ground ground_;
    Scenery scenery_;
    std::vector<pie::scene::Receiver> where_; ///< vertices, then points
    std::vector<Truth> truth_;
    pie::Clock::time_point start_ = pie::Clock::now();
};

} // namespace pietrade
