#include "pie/level/patch.h"

#include <algorithm>
#include <cmath>

namespace pie::level {
namespace {

using Dvec3 = glm::dvec3;

/// Weights of the three control points at i/n. Swapping both ends swaps the outer two bit by bit, so a curve read from
/// its other end gives the same points; the sums below keep that by adding the outer two first.
struct Weights {
    double first, middle, last;
};

Weights weightsAt(int i, int n) {
    const double t = static_cast<double>(i) / n;
    const double s = static_cast<double>(n - i) / n;
    return {s * s, 2.0 * (s * t), t * t};
}

template <class V> V blend(const V& a, const V& b, const V& c, const Weights& w) {
    using T = typename V::value_type;
    V result;
    for (int k = 0; k < V::length(); ++k)
        result[k] = static_cast<T>((w.first * static_cast<double>(a[k]) + w.last * static_cast<double>(c[k])) +
                                   w.middle * static_cast<double>(b[k]));
    return result;
}

PatchVertex blend(const PatchVertex& a, const PatchVertex& b, const PatchVertex& c, const Weights& w) {
    return {blend(a.position, b.position, c.position, w), blend(a.normal, b.normal, c.normal, w),
            blend(a.texture, b.texture, c.texture, w), blend(a.lightmap, b.lightmap, c.lightmap, w),
            blend(a.colour, b.colour, c.colour, w)};
}

/// A segment that bows less than this is straight, whatever the tolerance: the game keeps the middle of all others, and
/// a pipe two units wide must stay round.
constexpr double straightBow = 0.1;

/// How far a piece may bow, as a share of its length: six pieces for a quarter of a circle, whose area is then right
/// within 0.3 %.
constexpr double roundBow = 0.03;

/// Pieces of one quadratic Bézier segment so that no chord is farther than `tolerance` from the curve; the same from
/// either end. Cutting n times leaves the second difference |a - 2b + c| / (4 n²) between chord and curve. All of it
/// counts, not only its part across the chord: on a straight segment whose middle is off centre, pictures and the lines
/// to the opposite edge run at an uneven pace, and triangles that ignore it fold over each other.
int piecesOf(const Vec3& a, const Vec3& b, const Vec3& c, float tolerance, int maxSegments) {
    const Dvec3 chord = Dvec3(c) - Dvec3(a);
    const Dvec3 bend = 0.25 * ((Dvec3(a) + Dvec3(c)) - 2.0 * Dvec3(b));
    const double bow = glm::length(bend);
    if (!(bow > std::min<double>(tolerance, straightBow))) return 1;
    const double length = glm::length(chord);
    const double across = length > 0 ? glm::length(glm::cross(chord, bend)) / length : bow;
    const double polygon = glm::length(Dvec3(b) - Dvec3(a)) + glm::length(Dvec3(c) - Dvec3(b));
    const double wanted = std::max(std::sqrt(bow / tolerance), across / (roundBow * polygon));
    return static_cast<int>(std::clamp(std::ceil(wanted), 2.0, static_cast<double>(std::max(2, maxSegments))));
}

/// One direction of the grid: where its lines run.
struct Lines {
    struct Line {
        int segment = 0; ///< Bézier segment, counted in control points: 0, 2, 4 …
        int step = 0, pieces = 1;
        [[nodiscard]] double parameter() const { return 0.5 * segment + static_cast<double>(step) / pieces; }
    };
    std::vector<Line> lines;

    explicit Lines(const std::vector<int>& pieces) {
        for (std::size_t s = 0; s < pieces.size(); ++s)
            for (int i = 0; i < pieces[s]; ++i) lines.push_back({static_cast<int>(2 * s), i, pieces[s]});
        const int last = pieces.back();
        lines.push_back({static_cast<int>(2 * (pieces.size() - 1)), last, last});
    }
    [[nodiscard]] int count() const { return static_cast<int>(lines.size()); }
    [[nodiscard]] const Line& operator[](int i) const { return lines[static_cast<std::size_t>(i)]; }
};

/// A row of vertices with their parameter along the row.
struct Chain {
    std::vector<std::uint32_t> vertices;
    std::vector<double> parameters;

    void add(std::uint32_t vertex, double parameter) {
        vertices.push_back(vertex);
        parameters.push_back(parameter);
    }
};

class Tessellator {
public:
    Tessellator(std::span<const PatchVertex> controls, int width, int height, float tolerance, int maxSegments)
        : controls_(controls), width_(width), height_(height), tolerance_(std::max(tolerance, 1e-6F)),
          maxSegments_(std::max(1, maxSegments)) {}

    PatchMesh make() {
        std::vector<int> across = piecesAcross(true);
        std::vector<int> down = piecesAcross(false);
        allowForTwist(across, down);
        const Lines u(across);
        const Lines v(down);
        const Chain top = edge(true, 0);
        const Chain bottom = edge(true, height_ - 1);
        const Chain left = edge(false, 0);
        const Chain right = edge(false, width_ - 1);
        if (u.count() == 2)
            stitch(left, right, true);
        else if (v.count() == 2)
            stitch(top, bottom, false);
        else
            fill(u, v, top, bottom, left, right);
        mendNormals();
        return std::move(mesh_);
    }

private:
    [[nodiscard]] const PatchVertex& control(int column, int row) const {
        return controls_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                         static_cast<std::size_t>(column)];
    }
    [[nodiscard]] const PatchVertex& control(bool alongRow, int along, int across) const {
        return alongRow ? control(along, across) : control(across, along);
    }
    [[nodiscard]] int pieces(bool alongRow, int segment, int across) const {
        return piecesOf(control(alongRow, segment, across).position, control(alongRow, segment + 1, across).position,
                        control(alongRow, segment + 2, across).position, tolerance_, maxSegments_);
    }

    /// Pieces per segment inside the patch: a line inside mixes control rows, so it bends no more than the worst of
    /// them.
    [[nodiscard]] std::vector<int> piecesAcross(bool alongRow) const {
        const int length = alongRow ? width_ : height_;
        const int lines = alongRow ? height_ : width_;
        std::vector<int> result;
        for (int segment = 0; segment + 2 < length; segment += 2) {
            int most = 1;
            for (int across = 0; across < lines; ++across) most = std::max(most, pieces(alongRow, segment, across));
            result.push_back(most);
        }
        return result;
    }

    /// Straight edges may still span a warped face: cutting a cell into two flat triangles errs by its twist. Cells get
    /// small enough for that, but the edges keep what their own points say.
    void allowForTwist(std::vector<int>& across, std::vector<int>& down) const {
        for (std::size_t row = 0; row < down.size(); ++row)
            for (std::size_t column = 0; column < across.size(); ++column) {
                const double cells = twist(static_cast<int>(2 * column), static_cast<int>(2 * row)) / tolerance_;
                int& u = across[column];
                int& v = down[row];
                while (static_cast<double>(u) * v < cells && std::min(u, v) < maxSegments_) ++(u <= v ? u : v);
            }
    }

    /// Largest distance of a corner of the four control cells of a piece from the plane along the cell's diagonals, as
    /// twist |a - b - c + d|. The mixed derivative is at most 4 times that, and a cell cut n by m errs by 1/(4 n m) of
    /// it.
    [[nodiscard]] double twist(int column, int row) const {
        double most = 0;
        for (int r = row; r < row + 2; ++r)
            for (int c = column; c < column + 2; ++c) {
                const Dvec3 a(control(c, r).position);
                const Dvec3 right(control(c + 1, r).position);
                const Dvec3 below(control(c, r + 1).position);
                const Dvec3 d(control(c + 1, r + 1).position);
                const Dvec3 normal = glm::cross(d - a, below - right);
                const double length = glm::length(normal);
                // In its own plane a cell may have any shape.
                if (length > 0) most = std::max(most, std::abs(glm::dot((a + d) - (right + below), normal)) / length);
            }
        return most;
    }

    std::uint32_t add(const PatchVertex& vertex) {
        mesh_.vertices.push_back(vertex);
        return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
    }

    /// An edge of the patch, cut by what its own control points say. Corners are shared between two edges.
    Chain edge(bool alongRow, int across) {
        const int length = alongRow ? width_ : height_;
        Chain chain;
        for (int segment = 0; segment + 2 < length; segment += 2) {
            const int n = pieces(alongRow, segment, across);
            for (int i = segment == 0 ? 0 : 1; i <= n; ++i) {
                const bool isCorner = (segment == 0 && i == 0) || (segment + 3 == length && i == n);
                const int along = i == 0 ? segment : segment + 2;
                const std::uint32_t vertex =
                    isCorner ? corner(alongRow ? along : across, alongRow ? across : along)
                             : add(blend(control(alongRow, segment, across), control(alongRow, segment + 1, across),
                                         control(alongRow, segment + 2, across), weightsAt(i, n)));
                chain.add(vertex, 0.5 * segment + static_cast<double>(i) / n);
            }
        }
        return chain;
    }

    std::uint32_t corner(int column, int row) {
        std::int64_t& known = corners_[column == 0 ? 0 : 1][row == 0 ? 0 : 1];
        if (known < 0) known = add(control(column, row));
        return static_cast<std::uint32_t>(known);
    }

    [[nodiscard]] PatchVertex inside(const Lines::Line& u, const Lines::Line& v) const {
        const Weights wu = weightsAt(u.step, u.pieces);
        PatchVertex rows[3];
        for (int r = 0; r < 3; ++r)
            rows[r] = blend(control(u.segment, v.segment + r), control(u.segment + 1, v.segment + r),
                            control(u.segment + 2, v.segment + r), wu);
        return blend(rows[0], rows[1], rows[2], weightsAt(v.step, v.pieces));
    }

    /// A regular grid inside, and four bands that join it to the edges.
    void fill(const Lines& u, const Lines& v, const Chain& top, const Chain& bottom, const Chain& left,
              const Chain& right) {
        const int columns = u.count() - 2;
        const int rows = v.count() - 2;
        const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
        for (int row = 1; row <= rows; ++row)
            for (int column = 1; column <= columns; ++column) add(inside(u[column], v[row]));
        const auto at = [&](int column, int row) { return first + static_cast<std::uint32_t>(row * columns + column); };
        for (int row = 0; row + 1 < rows; ++row)
            for (int column = 0; column + 1 < columns; ++column)
                quad(at(column, row), at(column + 1, row), at(column, row + 1), at(column + 1, row + 1));
        Chain innerTop, innerBottom, innerLeft, innerRight;
        for (int column = 0; column < columns; ++column) {
            innerTop.add(at(column, 0), u[column + 1].parameter());
            innerBottom.add(at(column, rows - 1), u[column + 1].parameter());
        }
        for (int row = 0; row < rows; ++row) {
            innerLeft.add(at(0, row), v[row + 1].parameter());
            innerRight.add(at(columns - 1, row), v[row + 1].parameter());
        }
        stitch(top, innerTop, false);
        stitch(innerBottom, bottom, false);
        stitch(left, innerLeft, true);
        stitch(innerRight, right, true);
    }

    /// Triangles between two chains that run the same way; always the step whose end comes first. `a` is above `b`
    /// (rows), or with `flipped` to its left (columns).
    void stitch(const Chain& a, const Chain& b, bool flipped) {
        std::size_t i = 0;
        std::size_t j = 0;
        while (i + 1 < a.vertices.size() || j + 1 < b.vertices.size()) {
            const bool stepA = j + 1 == b.vertices.size() ||
                               (i + 1 < a.vertices.size() &&
                                a.parameters[i + 1] + a.parameters[i] <= b.parameters[j + 1] + b.parameters[j]);
            if (stepA) {
                triangle(a.vertices[i], a.vertices[i + 1], b.vertices[j], flipped);
                ++i;
            } else {
                triangle(a.vertices[i], b.vertices[j + 1], b.vertices[j], flipped);
                ++j;
            }
        }
    }

    void quad(std::uint32_t a, std::uint32_t right, std::uint32_t below, std::uint32_t across) {
        triangle(a, right, below, false);
        triangle(right, across, below, false);
    }

    /// Counter-clockwise from the front when its corners run first along the row and then down the rows. Triangles of a
    /// collapsed edge are left out.
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, bool flipped) {
        if (flipped) std::swap(b, c);
        const Vec3& pa = mesh_.vertices[a].position;
        const Vec3& pb = mesh_.vertices[b].position;
        const Vec3& pc = mesh_.vertices[c].position;
        if (pa == pb || pb == pc || pc == pa) return;
        mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
    }

    /// Interpolated normals become unit length; where they cancel out, the triangles round the vertex decide.
    void mendNormals() {
        std::vector<Dvec3> geometric;
        for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
            Dvec3 normal(mesh_.vertices[i].normal);
            if (!(glm::length(normal) > 1e-6)) {
                if (geometric.empty()) geometric = geometricNormals();
                normal = geometric[i];
            }
            const double length = glm::length(normal);
            mesh_.vertices[i].normal = length > 0 && std::isfinite(length) ? Vec3(normal / length) : Vec3(0, 0, 1);
        }
    }

    [[nodiscard]] std::vector<Dvec3> geometricNormals() const {
        std::vector<Dvec3> sums(mesh_.vertices.size(), Dvec3(0.0));
        for (std::size_t i = 0; i + 2 < mesh_.indices.size(); i += 3) {
            const auto corner = [&](std::size_t k) { return Dvec3(mesh_.vertices[mesh_.indices[i + k]].position); };
            const Dvec3 n = glm::cross(corner(1) - corner(0), corner(2) - corner(0));
            for (std::size_t k = 0; k < 3; ++k) sums[mesh_.indices[i + k]] += n;
        }
        return sums;
    }

    std::span<const PatchVertex> controls_;
    int width_, height_;
    float tolerance_;
    int maxSegments_;
    PatchMesh mesh_;
    std::int64_t corners_[2][2] = {{-1, -1}, {-1, -1}};
};

} // namespace

PatchMesh tessellate(std::span<const PatchVertex> controls, int width, int height, float tolerance, int maxSegments) {
    return Tessellator(controls, width, height, tolerance, maxSegments).make();
}

} // namespace pie::level
