// How far a receiver's direct light may be off, from the rays that were traced.
//
// Three parts, independent of each other:
// - a soft source with several rays: its visibility is a ratio of means over groups of consecutive points of its
//   sequence, each of which covers the source evenly (batch means);
// - a soft source with one ray: alone it says nothing about its variance; compared with its neighbour in space it does,
//   and what the two differ by counts as noise as well (collapsed strata: Cochran 1977, section 5A.12);
// - the tail, a systematic sample in spatial order: half the mean squared difference between successive draws (Wolter
//   2007, section 8.2), which holds what single rays to its soft sources add.

#include "pie/gather/direct_job.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace pie::gather {
namespace {

/// Groups of a soft source's rays. More would cover the source less evenly and overstate the noise, fewer would leave
/// the estimate too uncertain.
constexpr std::size_t mostGroups = 8;

double squared(double x) { return x * x; }

} // namespace

/// Of the mean of one soft source's rays; two at least.
double DirectJob::varianceWithin(std::span<const Drawn> drawn) {
    double contributions = 0;
    double through = 0;
    for (const Drawn& ray : drawn) {
        contributions += ray.contribution;
        through += ray.contribution * ray.through;
    }
    if (!(contributions > 0)) return 0;
    const double mean = through / contributions;
    const std::size_t groups = std::min(mostGroups, drawn.size());
    double sum = 0;
    for (std::size_t g = 0; g < groups; ++g) {
        double difference = 0;
        for (std::size_t i = g * drawn.size() / groups; i < (g + 1) * drawn.size() / groups; ++i)
            difference += drawn[i].contribution * (drawn[i].through - mean);
        sum += squared(difference);
    }
    const auto count = static_cast<double>(groups);
    return count / (count - 1) * sum / squared(contributions);
}

/// Of all soft sources of the head that have one ray each.
double DirectJob::varianceOfSingles(std::vector<Drawn> singles) const {
    if (singles.empty()) return 0;
    std::sort(singles.begin(), singles.end(), [&](const Drawn& a, const Drawn& b) {
        return context_.sources.rank(tested_[a.tested].source) < context_.sources.rank(tested_[b.tested].source);
    });
    const auto whole = [&](const Drawn& ray) {
        const Rgb& all = tested_[ray.tested].unoccluded;
        return (static_cast<double>(all.x) + static_cast<double>(all.y) + static_cast<double>(all.z)) / 3;
    };
    const auto share = [&](const Drawn& ray) { return whole(ray) != 0 ? ray.through / whole(ray) : 0; };
    // Nobody to compare with: as uncertain as can be.
    if (singles.size() == 1) return 0.25 * squared(whole(singles[0]));
    double sum = 0;
    for (std::size_t i = 0; i < singles.size(); ++i) {
        double difference = 0;
        if (i > 0) difference += squared(share(singles[i]) - share(singles[i - 1]));
        if (i + 1 < singles.size()) difference += squared(share(singles[i]) - share(singles[i + 1]));
        const double neighbours = i > 0 && i + 1 < singles.size() ? 2 : 1;
        sum += 0.5 * squared(whole(singles[i])) * difference / neighbours;
    }
    return sum;
}

double DirectJob::varianceOfTail() const {
    double sum = 0;
    double last = 0;
    unsigned count = 0;
    for (const Tested& tested : tested_) { // the tail was tested in spatial order
        if (tested.draws == 0) continue;
        const glm::dvec3 seen = tested.seen();
        const double each = (seen.x + seen.y + seen.z) / (3 * static_cast<double>(tested.draws));
        if (count > 0) sum += squared(each - last);
        last = each;
        count += tested.draws;
    }
    if (count == 0) return 0;
    if (count == 1) return squared(last); // at least: the mean square is the variance and more
    return count * sum / (2.0 * (count - 1));
}

double DirectJob::variance() const {
    // In the order of the rays, those of a source together.
    std::vector<Drawn> drawn = drawn_;
    std::stable_sort(drawn.begin(), drawn.end(), [](const Drawn& a, const Drawn& b) { return a.tested < b.tested; });
    std::vector<Drawn> singles;
    double sum = varianceOfTail();
    for (std::size_t begin = 0; begin < drawn.size();) {
        std::size_t end = begin + 1;
        while (end < drawn.size() && drawn[end].tested == drawn[begin].tested) ++end;
        const Tested& tested = tested_[drawn[begin].tested];
        if (end - begin > 1)
            sum += squared(tested.weight) * varianceWithin(std::span(drawn).subspan(begin, end - begin));
        else if (tested.draws == 0)
            singles.push_back(drawn[begin]);
        begin = end;
    }
    sum += varianceOfSingles(std::move(singles));
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::max();
}

} // namespace pie::gather
