#include "pie/gather/texels.h"

#include "pie/core/flat_index.h"
#include "pie/core/parallel.h"
#include "pie/gather/area.h"
#include "pie/gather/texel_pieces.h"
#include "pie/sampling/directions.h"
#include "pie/sampling/hash.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace pie::gather {
namespace {

constexpr double largestCoordinate = 1U << 19U; // cells: 20 bits a coordinate
constexpr std::size_t mostLevels = 8;
constexpr std::size_t fewestTexels = 64; // a level with so few is the last
constexpr float smallestCoverage = 1.0F / 16;
// Walls stand on round numbers, so the grid does not: a wall in the very border of two cells would be in either.
constexpr glm::dvec3 gridShift{0.3711, 0.4142, 0.4327};

std::uint64_t parentKey(std::uint64_t key) { return texelKey(texelCell(key) / 2, static_cast<unsigned>(key >> 60U)); }

/// Numbers in [0, 1) with an address.
float hashed(std::uint64_t key, std::uint64_t number) {
    std::uint64_t x = key * 0x9e3779b97f4a7c15ULL + number * 0xd1b54a32d192ed03ULL + 0x2545f4914f6cdd1dULL;
    x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
    return sampling::toUnit(x ^ x >> 31U);
}

} // namespace

namespace {

/// Keys of cells, numbered in the order they came in.
class Keys {
public:
    [[nodiscard]] std::uint32_t find(std::uint64_t key) const {
        return index_.find(mixBits(key), [&](std::uint32_t i) { return keys_[i] == key; });
    }
    /// Its number, new if there was none.
    std::uint32_t add(std::uint64_t key) {
        const std::uint32_t known = find(key);
        if (known != FlatIndex::none) return known;
        index_.insert(mixBits(key), static_cast<std::uint32_t>(keys_.size()));
        keys_.push_back(key);
        return static_cast<std::uint32_t>(keys_.size() - 1);
    }
    [[nodiscard]] std::size_t size() const { return keys_.size(); }
    [[nodiscard]] std::size_t bytes() const { return index_.bytes() + keys_.size() * sizeof(std::uint64_t); }

private:
    FlatIndex index_;
    std::vector<std::uint64_t> keys_;
};

} // namespace

struct SurfaceTexels::Index {
    glm::dvec3 origin{0};
    double scale = 1; ///< cells a unit
    Keys cells;
    std::vector<std::uint32_t> texelOfCell;
    /// Where a point lies between all cells by rounding: the texels of its triangle, front and back.
    std::vector<std::uint32_t> begin, ofTriangle;
    std::vector<std::uint8_t> direction; ///< per triangle: facing(); 255 for what keeps no light
    std::vector<std::uint8_t> texelDirection;

    [[nodiscard]] std::uint32_t texelAt(std::uint64_t key) const {
        const std::uint32_t cell = cells.find(key);
        return cell == FlatIndex::none ? none : texelOfCell[cell];
    }
    [[nodiscard]] glm::ivec3 cellAt(const Vec3& p) const {
        const glm::dvec3 at = (glm::dvec3(p) - origin) * scale;
        return glm::clamp(glm::floor(at), glm::dvec3(0), glm::dvec3(largestCoordinate));
    }
};

namespace {

/// What is summed up over a cell.
struct Sum {
    std::uint64_t key = 0;
    double area = 0;
    glm::dvec3 moment{0}, normal{0}, reflected{0};
};

/// Whether two neighbours are pieces of one plane.
bool samePlane(const Sum& a, const Sum& b, double edge) {
    const glm::dvec3 na = glm::normalize(a.normal);
    const glm::dvec3 nb = glm::normalize(b.normal);
    if (!(glm::dot(na, nb) > 0.9)) return false;
    const glm::dvec3 apart = b.moment / b.area - a.moment / a.area;
    return std::abs(glm::dot(apart, na)) < 0.25 * edge && std::abs(glm::dot(apart, nb)) < 0.25 * edge;
}

/// Joins small cells to a neighbour: the root of each.
std::vector<std::uint32_t> joinSmall(std::vector<Sum>& sums, const Keys& cells, double edge) {
    std::vector<std::uint32_t> root(sums.size());
    std::iota(root.begin(), root.end(), 0U);
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    std::vector<std::uint32_t> small;
    for (std::uint32_t i = 0; i < sums.size(); ++i)
        if (sums[i].area < static_cast<double>(SurfaceTexels::mergeBelow) * edge * edge) small.push_back(i);
    std::sort(small.begin(), small.end(), [&](std::uint32_t a, std::uint32_t b) {
        return sums[a].area < sums[b].area || (sums[a].area == sums[b].area && a < b);
    });
    for (const std::uint32_t i : small) {
        const std::uint32_t own = find(i);
        if (sums[own].area >= static_cast<double>(SurfaceTexels::mergeBelow) * edge * edge) continue;
        std::uint32_t best = own;
        const glm::ivec3 cell = texelCell(sums[i].key);
        const auto direction = static_cast<unsigned>(sums[i].key >> 60U);
        for (int n = 0; n < 27; ++n) {
            const glm::ivec3 beside = cell + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            const std::uint32_t found = cells.find(texelKey(beside, direction));
            if (found == FlatIndex::none) continue;
            const std::uint32_t other = find(found);
            if (other == own || !samePlane(sums[own], sums[other], edge)) continue;
            // Strips along borders join what lies beside them, not each other into longer strips.
            const glm::ivec3 apart = glm::abs(texelCell(sums[other].key) - cell);
            if (std::max({apart.x, apart.y, apart.z}) > 1) continue;
            if (best == own || sums[other].area > sums[best].area ||
                (sums[other].area == sums[best].area && other < best))
                best = other;
        }
        if (best == own) continue;
        root[own] = best;
        sums[best].area += sums[own].area;
        sums[best].moment += sums[own].moment;
        sums[best].normal += sums[own].normal;
        sums[best].reflected += sums[own].reflected;
    }
    for (std::uint32_t i = 0; i < root.size(); ++i) root[i] = find(i);
    return root;
}

/// Points spread evenly over the area of one texel.
void placePoints(const scene::Scene& scene, std::span<const TexelPiece* const> pieces, std::uint64_t key,
                 unsigned count, std::span<scene::Receiver> out, SurfaceTexels::Texel& texel) {
    double total = 0;
    for (const TexelPiece* piece : pieces) total += static_cast<double>(piece->area);
    double before = 0;
    std::size_t at = 0;
    std::size_t first = 0;
    double beforeFirst = 0;
    double stopped = 0;
    for (unsigned k = 0; k < count; ++k) {
        // Two independent points in every half, quarter … of the area: their difference tells the error of the mean.
        const unsigned strata = (count + 1) / 2;
        const unsigned stratum = k / 2;
        const std::uint64_t address = std::uint64_t{3} * k;
        const double target = (stratum + static_cast<double>(hashed(key, address))) / strata * total;
        if (k % 2 == 0) {
            first = at;
            beforeFirst = before;
        } else {
            at = first;
            before = beforeFirst;
        }
        while (at + 1 < pieces.size() && before + static_cast<double>(pieces[at]->area) <= target)
            before += static_cast<double>(pieces[at++]->area);
        const TexelPiece& piece = *pieces[at];
        const Vec2 w = sampling::uniformTriangle({hashed(key, address + 1), hashed(key, address + 2)});
        scene::Receiver& receiver = out[k];
        receiver.position = piece.corner + w.x * piece.side1 + w.y * piece.side2;
        receiver.inset = receiver.position;
        receiver.normal = piece.back ? -scene.normals[piece.triangle] : scene.normals[piece.triangle];
        if (scene.material(piece.triangle).interaction != scene::Interaction::Filter) {
            stopped += 1;
            continue;
        }
        // Barycentric weights in the whole triangle say what the filter lets through.
        const Vec3 a = scene.corner(piece.triangle, 0);
        const Vec3 e1 = scene.corner(piece.triangle, 1) - a;
        const Vec3 e2 = scene.corner(piece.triangle, 2) - a;
        const Vec3 normal = glm::cross(e1, e2);
        const float size = glm::dot(normal, normal);
        const Vec3 d = receiver.position - a;
        const float u = size > 0.0F ? glm::dot(glm::cross(d, e2), normal) / size : 0.0F;
        const float v = size > 0.0F ? glm::dot(glm::cross(e1, d), normal) / size : 0.0F;
        stopped += 1 - static_cast<double>(meanChannel(scene.transmittance(piece.triangle, u, v)));
    }
    texel.coverage = std::max(smallestCoverage, static_cast<float>(stopped / count));
}

} // namespace

float SurfaceTexels::automaticEdge(const scene::Scene& scene) {
    constexpr double texels = 4000;
    constexpr double mostTexels = 250'000;
    constexpr double largest = 64;
    // A level's texels need not be larger than its doors and crates, unless there would be too many; a small scene has
    // no unit to go by.
    const double edge = std::min(std::sqrt(scene.area / texels), largest);
    return static_cast<float>(std::max(edge, std::sqrt(scene.area / mostTexels)));
}

SurfaceTexels::SurfaceTexels(const scene::Scene& scene, const TexelOptions& options)
    : scene_(scene), pointsPerTexel_(std::clamp(options.points, 2U, 64U) / 2 * 2), index_(std::make_unique<Index>()) {
    Index& index = *index_;
    index.direction.assign(scene.triangles.size(), 255);
    for (std::size_t t = 0; t < scene.triangles.size(); ++t)
        if (keepsLight(scene, t)) index.direction[t] = static_cast<std::uint8_t>(facing(scene.normals[t]));
    edge_ = options.edge > 0.0F && std::isfinite(options.edge) ? options.edge : automaticEdge(scene);
    const double longest = scene.bounds.empty() ? 0 : static_cast<double>(maxChannel(scene.bounds.size()));
    if (!(edge_ > 0.0F)) edge_ = 1.0F;
    edge_ = std::max(edge_, static_cast<float>(longest / (0.5 * largestCoordinate)));
    // Cutting costs as much as there are cells, so the number of cells is bounded beforehand.
    while (scene.area / (static_cast<double>(edge_) * static_cast<double>(edge_)) >
           static_cast<double>(options.maxTexels))
        edge_ *= 2;
    std::vector<TexelPiece> pieces;
    for (;;) {
        index.scale = 1 / static_cast<double>(edge_);
        index.origin =
            (scene.bounds.empty() ? glm::dvec3(0) : glm::dvec3(scene.bounds.lower)) - (1.0 + gridShift) / index.scale;
        if (cutAll(scene, index.origin, index.scale, index.direction, options.maxTexels, pieces) &&
            cellsOf(pieces) <= options.maxTexels)
            break;
        edge_ *= 2;
    }

    std::vector<Sum> sums;
    for (TexelPiece& piece : pieces) {
        piece.texel = index.cells.add(piece.key);
        if (piece.texel == sums.size()) sums.push_back({piece.key});
        Sum& sum = sums[piece.texel];
        const auto area = static_cast<double>(piece.area);
        sum.area += area;
        sum.moment += area * glm::dvec3(piece.corner + (piece.side1 + piece.side2) / 3.0F);
        sum.normal += area * glm::dvec3(scene.normals[piece.triangle]) * (piece.back ? -1.0 : 1.0);
        sum.reflected += area * glm::dvec3(scene.material(piece.triangle).reflectance);
    }
    const std::vector<std::uint32_t> root = joinSmall(sums, index.cells, static_cast<double>(edge_));
    std::vector<std::uint32_t> number(sums.size(), none);
    std::vector<std::uint64_t> keys;
    levels_.emplace_back();
    for (std::uint32_t i = 0; i < sums.size(); ++i) {
        if (root[i] != i) continue;
        number[i] = static_cast<std::uint32_t>(levels_[0].size());
        keys.push_back(sums[i].key);
        index.texelDirection.push_back(static_cast<std::uint8_t>(sums[i].key >> 60U));
        Texel texel;
        texel.area = static_cast<float>(sums[i].area);
        texel.centre = Vec3(sums[i].moment / sums[i].area);
        texel.reflectance = Rgb(sums[i].reflected / sums[i].area);
        levels_[0].push_back(texel);
    }
    for (const std::uint32_t cell : root) index.texelOfCell.push_back(number[cell]);
    for (TexelPiece& piece : pieces) piece.texel = index.texelOfCell[piece.texel];

    // Texels of every triangle, each once.
    index.begin.assign(scene.triangles.size() + 1, 0);
    std::size_t next = 0;
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        index.begin[t] = static_cast<std::uint32_t>(index.ofTriangle.size());
        for (; next < pieces.size() && pieces[next].triangle == t; ++next) {
            const auto first = index.ofTriangle.begin() + index.begin[t];
            // Neighbouring pieces mostly share their texel; the rest of the repetitions costs little.
            if (index.ofTriangle.end() - first < 1 || index.ofTriangle.back() != pieces[next].texel)
                index.ofTriangle.push_back(pieces[next].texel);
        }
    }
    index.begin.back() = static_cast<std::uint32_t>(index.ofTriangle.size());

    std::vector<const TexelPiece*> byTexel(pieces.size());
    std::vector<std::uint32_t> begin(keys.size() + 1, 0);
    for (const TexelPiece& piece : pieces) ++begin[piece.texel + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint32_t> place(begin.begin(), begin.end() - 1);
    for (const TexelPiece& piece : pieces) byTexel[place[piece.texel]++] = &piece;
    points_.points.resize(keys.size() * pointsPerTexel_);
    parallelChunks(keys.size(), 256, [&](std::size_t first, std::size_t last) {
        for (std::size_t t = first; t < last; ++t)
            placePoints(scene, std::span(byTexel).subspan(begin[t], begin[t + 1] - begin[t]), keys[t], pointsPerTexel_,
                        std::span(points_.points).subspan(t * pointsPerTexel_, pointsPerTexel_), levels_[0][t]);
    });

    while (levels_.size() < mostLevels && levels_.back().size() > fewestTexels) {
        std::vector<Texel>& fine = levels_.back();
        std::vector<Texel> coarse;
        std::vector<std::uint64_t> coarseKeys;
        Keys known;
        for (std::size_t t = 0; t < fine.size(); ++t) {
            const std::uint64_t key = parentKey(keys[t]);
            fine[t].parent = known.add(key);
            if (fine[t].parent == coarse.size()) {
                coarse.emplace_back();
                coarse.back().coverage = 0;
                coarseKeys.push_back(key);
            }
            Texel& sum = coarse[fine[t].parent];
            sum.area += fine[t].area;
            sum.centre += fine[t].area * fine[t].centre;
            sum.reflectance += fine[t].area * fine[t].reflectance;
            sum.coverage += fine[t].area * fine[t].coverage;
        }
        for (Texel& texel : coarse) {
            texel.centre /= texel.area;
            texel.reflectance /= texel.area;
            texel.coverage /= texel.area;
        }
        levels_.push_back(std::move(coarse));
        keys = std::move(coarseKeys);
    }
}

SurfaceTexels::~SurfaceTexels() = default;

std::uint32_t SurfaceTexels::find(std::uint32_t triangle, bool back, const Vec3& point) const {
    const Index& index = *index_;
    if (triangle >= index.direction.size() || index.direction[triangle] == 255) return none;
    if (back && !scene_.material(triangle).twoSided) return none;
    const unsigned direction = index.direction[triangle] ^ (back ? 1U : 0U);
    const std::uint32_t found = index.texelAt(texelKey(index.cellAt(point), direction));
    if (found != none) return found;
    std::uint32_t best = none;
    float least = std::numeric_limits<float>::infinity();
    for (std::uint32_t i = index.begin[triangle]; i < index.begin[triangle + 1]; ++i) {
        if (index.texelDirection[index.ofTriangle[i]] != direction) continue;
        const Vec3 d = levels_[0][index.ofTriangle[i]].centre - point;
        const float distance = glm::dot(d, d);
        if (distance < least) {
            least = distance;
            best = index.ofTriangle[i];
        }
    }
    return best;
}

std::uint32_t SurfaceTexels::find(const photons::Photon& photon) const {
    if (photon.triangle >= scene_.triangles.size()) return none;
    const bool back = glm::dot(scene_.normals[photon.triangle], photon.direction) > 0.0F;
    return find(photon.triangle, back && scene_.material(photon.triangle).twoSided, photon.position);
}

void SurfaceTexels::find(std::span<const photons::Photon> photons, std::vector<std::uint32_t>& found) const {
    found.resize(photons.size());
    parallelChunks(photons.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) found[i] = find(photons[i]);
    });
}

std::uint32_t SurfaceTexels::near(const Vec3& point, const Vec3& normal) const {
    const Index& index = *index_;
    const unsigned direction = facing(normal);
    const glm::ivec3 cell = index.cellAt(point);
    std::uint32_t best = none;
    float least = std::numeric_limits<float>::infinity();
    for (int n = 0; n < 27; ++n) {
        const std::uint32_t found =
            index.texelAt(texelKey(cell + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), direction));
        if (found == none) continue;
        const Vec3 d = levels_[0][found].centre - point;
        // Off the receiver's plane counts more than along it.
        const float off = glm::dot(d, normal);
        const float distance = glm::dot(d, d) + 8.0F * off * off;
        if (distance < least) {
            least = distance;
            best = found;
        }
    }
    return best;
}

std::size_t SurfaceTexels::bytes() const {
    std::size_t sum = points_.points.size() * sizeof(scene::Receiver);
    for (const auto& level : levels_) sum += level.size() * sizeof(Texel);
    sum += index_->cells.bytes() +
           (index_->texelOfCell.size() + index_->begin.size() + index_->ofTriangle.size()) * sizeof(std::uint32_t);
    return sum;
}

} // namespace pie::gather
