#pragma once
// How long the last frames took, stage by stage: differences of the engine's running sums, for plots.

#include "pie/engine/statistics.h"

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

namespace pieview {

class StageTimes {
public:
    static constexpr std::array<std::string_view, 7> names{"frame",  "trace",    "build", "direct",
                                                           "refine", "estimate", "upload"};
    static constexpr std::size_t kept = 240; ///< frames

    /// `frameMs`: the whole of it, with drawing.
    void add(double frameMs, const pie::engine::Statistics& statistics);
    /// Another level's sums start again.
    void restart() { last_ = {}; }
    /// Milliseconds of stage `stage` in the frames kept, oldest first.
    [[nodiscard]] std::vector<float> of(std::size_t stage) const;
    [[nodiscard]] float latest(std::size_t stage) const;

private:
    using Row = std::array<float, names.size()>;
    std::vector<Row> rows_; ///< a ring
    std::size_t next_ = 0;
    pie::engine::Statistics last_;
};

} // namespace pieview
