#include "apps/pietrade/front.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace pietrade {

std::vector<std::size_t> front(std::span<const Cost> costs) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < costs.size(); ++i)
        if (std::isfinite(costs[i].error) && std::isfinite(costs[i].time)) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::tuple(costs[a].time, costs[a].error, a) < std::tuple(costs[b].time, costs[b].error, b);
    });
    std::vector<std::size_t> result;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t i : order) {
        if (costs[i].error >= least) continue;
        least = costs[i].error;
        result.push_back(i);
    }
    return result;
}

std::optional<std::size_t> bestWithin(std::span<const Cost> costs, double time) {
    std::optional<std::size_t> best;
    for (const std::size_t i : front(costs)) // growing time, falling error
        if (costs[i].time <= time) best = i;
    return best;
}

std::optional<std::size_t> fastestWithin(std::span<const Cost> costs, double error) {
    for (const std::size_t i : front(costs))
        if (costs[i].error <= error) return i;
    return std::nullopt;
}

} // namespace pietrade
