// How rows are made: which texels and points the rays of a receiver, or of a texel's point, meet.

#include "pie/gather/cached_gather.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace pie::gather {
namespace {

constexpr std::size_t receiversPerTask = 32; // receivers a thread takes at once
constexpr unsigned largeShare = 32;          // a texel that more than one ray in so many meets gathers itself

bool differ(const TexelHit& a, const TexelHit& b) { return a.texel != b.texel || a.weight != b.weight; }

} // namespace

/// Texel by texel. Those that weigh at least `large` are taken by their own gather, point by point.
GatherRow CachedGather::makeRow(std::span<const TexelHit> hits, unsigned n, float large) const {
    const auto rays = static_cast<float>(n);
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < hits.size(); ++i)
        if (hits[i].texel != SurfaceTexels::none) order.push_back(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return hits[a].texel < hits[b].texel; });
    std::vector<GatherRow::Part> parts;
    // Rays of the hemisphere all weigh 1/n: counted, they are exact.
    const auto met = [&](const TexelHit& hit) { return hit.weight == 1.0F / rays ? 1.0F : rays * hit.weight; };
    const unsigned points = texels_.pointsPerTexel();
    std::vector<float> ofPoint;
    for (auto first = order.begin(); first != order.end();) {
        const std::uint32_t texel = hits[*first].texel;
        const auto last = std::find_if(first, order.end(), [&](std::uint32_t i) { return hits[i].texel != texel; });
        float all = 0;
        for (auto i = first; i != last; ++i) all += met(hits[*i]);
        if (all >= rays * large) {
            ofPoint.assign(points, 0.0F);
            for (auto i = first; i != last; ++i) ofPoint[nearestPoint(texel, hits[*i].point)] += met(hits[*i]);
            for (std::uint32_t k = 0; k < points; ++k)
                if (ofPoint[k] > 0.0F) parts.push_back({firstPoint() + texel * points + k, ofPoint[k]});
        } else if (all > 0.0F) {
            parts.push_back({texel, all});
        }
        first = last;
    }
    return {parts, dark()};
}

void CachedGather::makeRows(std::span<const std::uint32_t> which, unsigned n) {
    const float large = options_.reflections < 2
                            ? std::numeric_limits<float>::infinity()
                            : static_cast<float>(std::max(2U, n / largeShare)) / static_cast<float>(n);
    parallelChunks(which.size(), receiversPerTask, [&](std::size_t begin, std::size_t end) {
        std::vector<TexelHit> hits;
        gatherRays_.shoot(which.subspan(begin, end - begin), n, hits);
        std::size_t at = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t count = gatherRays_.count(which[i], n);
            rows_[which[i]] = makeRow(std::span(hits).subspan(at, count), n, large);
            at += count;
        }
    });
    std::vector<std::uint32_t> seen;
    std::vector<std::uint32_t> gathering;
    for (const std::uint32_t r : which) {
        rays_ += gatherRays_.count(r, n);
        rows_[r].forEach(1.0F, [&](std::uint32_t number, float /*weight*/) {
            if (number >= firstPoint())
                gathering.push_back(number - firstPoint());
            else
                seen.push_back(number);
        });
    }
    light_.direct(seen);
    makePointRows(std::move(gathering));
    for (const std::uint32_t r : which) numberPoints(rows_[r]);
    GatherRow::pack(which, rows_);
}

void CachedGather::numberPoints(GatherRow& row) const {
    row.renumber([&](std::uint32_t number) {
        return number < firstPoint() ? number : firstPoint() + placeOf_[number - firstPoint()];
    });
}

std::uint32_t CachedGather::nearestPoint(std::uint32_t texel, const Vec3& at) const {
    const unsigned points = texels_.pointsPerTexel();
    std::uint32_t best = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::uint32_t k = 0; k < points; ++k) {
        const Vec3 d = texels_.points().points[std::size_t{texel} * points + k].position - at;
        if (glm::dot(d, d) >= least) continue;
        least = glm::dot(d, d);
        best = k;
    }
    return best;
}

void CachedGather::makePointRows(std::vector<std::uint32_t> points) {
    if (placeOf_.empty() && !points.empty()) placeOf_.assign(texels_.points().points.size(), SurfaceTexels::none);
    std::erase_if(points, [&](std::uint32_t p) { return placeOf_[p] != SurfaceTexels::none; });
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.empty()) return;
    const unsigned n = raysOfPoint();
    const std::size_t firstRow = pointRows_.size();
    for (const std::uint32_t p : points) {
        placeOf_[p] = static_cast<std::uint32_t>(gatheringPoints_.size());
        gatheringPoints_.push_back(p);
    }
    pointRows_.resize(gatheringPoints_.size());
    if (options_.standardErrors) pointPairs_.resize(pointRows_.size());
    parallelChunks(points.size(), receiversPerTask, [&](std::size_t begin, std::size_t end) {
        std::vector<TexelHit> hits;
        for (std::size_t i = begin; i < end; ++i) {
            hits.clear();
            texelGatherRays_.shoot(std::span(&points[i], 1), n, hits);
            pointRows_[firstRow + i] = makeRow(hits, n, std::numeric_limits<float>::infinity());
            if (pointPairs_.empty()) continue;
            for (std::size_t k = 0; k + 1 < hits.size(); k += 2)
                if (differ(hits[k], hits[k + 1]))
                    pointPairs_[firstRow + i].push_back(
                        {{hits[k].texel, hits[k + 1].texel}, {hits[k].weight, hits[k + 1].weight}});
        }
    });
    std::vector<std::uint32_t> places(points.size());
    std::iota(places.begin(), places.end(), static_cast<std::uint32_t>(firstRow));
    GatherRow::pack(places, pointRows_);
    for (const std::uint32_t p : points) rays_ += texelGatherRays_.count(p, n);
    std::vector<std::uint32_t> seen;
    for (const std::uint32_t p : points) seen.push_back(p / texels_.pointsPerTexel());
    for (std::size_t p = firstRow; p < pointRows_.size(); ++p)
        pointRows_[p].forEach(1.0F, [&](std::uint32_t number, float /*weight*/) { seen.push_back(number); });
    light_.direct(seen);
    if (!texelDirect_) return;
    pointDirect_.resize(pointRows_.size());
    texelDirect_->estimate(points, std::span(pointDirect_).subspan(firstRow));
}

} // namespace pie::gather
