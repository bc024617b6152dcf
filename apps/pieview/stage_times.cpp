#include "apps/pieview/stage_times.h"

namespace pieview {

void StageTimes::add(double frameMs, const pie::engine::Statistics& now) {
    const auto since = [](double sum, double before) { return static_cast<float>(sum - before); };
    const Row row{static_cast<float>(frameMs),         since(now.traceMs, last_.traceMs),
                  since(now.buildMs, last_.buildMs),   since(now.directMs, last_.directMs),
                  since(now.refineMs, last_.refineMs), since(now.estimateMs, last_.estimateMs),
                  since(now.uploadMs, last_.uploadMs)};
    last_ = now;
    if (rows_.size() < kept) {
        rows_.push_back(row);
        return;
    }
    rows_[next_] = row;
    next_ = (next_ + 1) % kept;
}

std::vector<float> StageTimes::of(std::size_t stage) const {
    std::vector<float> values;
    for (std::size_t i = 0; i < rows_.size(); ++i) values.push_back(rows_[(next_ + i) % rows_.size()].at(stage));
    return values;
}

float StageTimes::latest(std::size_t stage) const {
    if (rows_.empty()) return 0;
    return rows_[(next_ + rows_.size() - 1) % rows_.size()].at(stage);
}

} // namespace pieview
