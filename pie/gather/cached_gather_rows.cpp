// How rows are made: which texels and points the rays of a receiver, or of a texel's point, meet.

#include "pie/gather/cached_gather.h"

#include "pie/core/parallel.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace pie::gather {
namespace {

constexpr std::size_t receiversPerTask = 32; // receivers a thread takes at once
constexpr unsigned largeShare = 32;          // a texel that more than one ray in so many meets gathers itself

bool differ(const TexelHit& a, const TexelHit& b) { return a.texel != b.texel || a.weight != b.weight; }

} // namespace

/// Texel by texel. Those that weigh at least `large` are taken by their own gather, point by point.
CachedGather::Row CachedGather::makeRow(std::span<const TexelHit> hits, unsigned n, float large) const {
    const float each = 1.0F / static_cast<float>(n);
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < hits.size(); ++i)
        if (hits[i].texel != SurfaceTexels::none) order.push_back(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return hits[a].texel < hits[b].texel; });
    std::vector<std::uint32_t> entries;
    std::vector<std::uint32_t> weighted;
    const auto add = [&](std::uint32_t number, std::uint32_t rays, float weight) {
        for (; rays > 0; rays -= std::min(rays, mostRays))
            entries.push_back(number << countBits | (std::min(rays, mostRays) - 1));
        if (weight > 0.0F) weighted.insert(weighted.end(), {number, std::bit_cast<std::uint32_t>(weight)});
    };
    struct Met {
        std::uint32_t rays = 0;
        float weight = 0;
        void by(const TexelHit& hit, float plain) {
            if (hit.weight == plain)
                ++rays;
            else
                weight += hit.weight;
        }
    };
    const unsigned points = texels_.pointsPerTexel();
    std::vector<Met> ofPoint;
    for (auto first = order.begin(); first != order.end();) {
        const std::uint32_t texel = hits[*first].texel;
        const auto last = std::find_if(first, order.end(), [&](std::uint32_t i) { return hits[i].texel != texel; });
        Met all;
        for (auto i = first; i != last; ++i) all.by(hits[*i], each);
        if (all.weight + each * static_cast<float>(all.rays) >= large) {
            ofPoint.assign(points, {});
            for (auto i = first; i != last; ++i) ofPoint[nearestPoint(texel, hits[*i].point)].by(hits[*i], each);
            for (std::uint32_t k = 0; k < points; ++k)
                add(texelCount() + texel * points + k, ofPoint[k].rays, ofPoint[k].weight);
        } else {
            add(texel, all.rays, all.weight);
        }
        first = last;
    }
    Row row;
    row.size = static_cast<std::uint32_t>(entries.size());
    row.weighted = static_cast<std::uint32_t>(weighted.size() / 2);
    entries.insert(entries.end(), weighted.begin(), weighted.end());
    row.entries = std::make_unique<std::uint32_t[]>(entries.size());
    std::copy(entries.begin(), entries.end(), row.entries.get());
    return row;
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
        rows_[r].forEach(n, [&](std::uint32_t number, float /*weight*/) {
            if (number >= texelCount())
                gathering.push_back((number - texelCount()) / texels_.pointsPerTexel());
            else
                seen.push_back(number);
        });
    }
    light_.direct(seen);
    makeTexelRows(std::move(gathering));
    for (const std::uint32_t r : which) numberPoints(rows_[r]);
}

void CachedGather::numberPoints(Row& row) const {
    const auto placed = [&](std::uint32_t number) {
        const std::uint32_t point = number - texelCount();
        const unsigned points = texels_.pointsPerTexel();
        return texelCount() + placeOf_[point / points] * points + point % points;
    };
    for (std::uint32_t i = 0; i < row.size; ++i) {
        const std::uint32_t number = row.entries[i] >> countBits;
        if (number >= texelCount()) row.entries[i] = placed(number) << countBits | (row.entries[i] & (mostRays - 1));
    }
    for (std::uint32_t i = row.size; i < row.size + 2 * row.weighted; i += 2)
        if (row.entries[i] >= texelCount()) row.entries[i] = placed(row.entries[i]);
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

void CachedGather::makeTexelRows(std::vector<std::uint32_t> texels) {
    std::erase_if(texels, [&](std::uint32_t t) { return placeOf_[t] != SurfaceTexels::none; });
    std::sort(texels.begin(), texels.end());
    texels.erase(std::unique(texels.begin(), texels.end()), texels.end());
    const unsigned points = texels_.pointsPerTexel();
    const unsigned n = raysOfPoint();
    const std::size_t firstRow = pointRows_.size();
    for (const std::uint32_t t : texels) {
        placeOf_[t] = static_cast<std::uint32_t>(gatheringTexels_.size());
        gatheringTexels_.push_back(t);
    }
    pointRows_.resize(gatheringTexels_.size() * points);
    if (options_.standardErrors) pointPairs_.resize(pointRows_.size());
    parallelChunks(
        texels.size(), std::max<std::size_t>(1, receiversPerTask / points), [&](std::size_t begin, std::size_t end) {
            std::vector<TexelHit> hits;
            for (std::size_t i = begin * points; i < end * points; ++i) {
                const auto point = static_cast<std::uint32_t>(std::size_t{texels[i / points]} * points + i % points);
                hits.clear();
                texelGatherRays_.shoot(std::span(&point, 1), n, hits);
                pointRows_[firstRow + i] = makeRow(hits, n, std::numeric_limits<float>::infinity());
                if (pointPairs_.empty()) continue;
                for (std::size_t k = 0; k + 1 < hits.size(); k += 2)
                    if (differ(hits[k], hits[k + 1]))
                        pointPairs_[firstRow + i].push_back(
                            {{hits[k].texel, hits[k + 1].texel}, {hits[k].weight, hits[k + 1].weight}});
            }
        });
    for (const std::uint32_t t : texels) rays_ += points * texelGatherRays_.count(t * points, n);
    std::vector<std::uint32_t> seen = texels;
    for (std::size_t p = firstRow; p < pointRows_.size(); ++p)
        pointRows_[p].forEach(n, [&](std::uint32_t number, float /*weight*/) { seen.push_back(number); });
    light_.direct(seen);
    if (!texelDirect_) return;
    std::vector<std::uint32_t> which;
    for (const std::uint32_t t : texels)
        for (unsigned k = 0; k < points; ++k) which.push_back(t * points + k);
    pointDirect_.resize(pointRows_.size());
    texelDirect_->estimate(which, std::span(pointDirect_).subspan(firstRow));
}

} // namespace pie::gather
