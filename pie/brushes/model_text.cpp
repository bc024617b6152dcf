#include "pie/brushes/model_formats.h"
#include "pie/level/byte_reader.h"
#include "pie/level/names.h"
#include "pie/level/tokens.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

namespace pie::brushes {
namespace {

using level::Damage;
using level::Token;
using level::Tokens;

double number(const std::optional<Token>& token, int line) {
    if (!token) throw Damage(fmt::format("line {}", line), "expected a number, found the end of the line");
    double value = 0;
    const char* end = token->text.data() + token->text.size();
    if (std::from_chars(token->text.data(), end, value).ec != std::errc())
        throw Damage(fmt::format("line {}, column {}", token->line, token->column),
                     fmt::format("expected a number, found '{}'", token->text.substr(0, 40)));
    return value;
}

/// Words of a text, line by line where asked for.
class Words : public Tokens {
public:
    using Tokens::Tokens;
    double real() { return number(nextOnLine(), line()); }
    std::int64_t integer() { return static_cast<std::int64_t>(real()); }
    glm::dvec3 triple() {
        const double x = real();
        const double y = real();
        return {x, y, real()};
    }
    std::string word() {
        const std::optional<Token> token = nextOnLine();
        return token ? std::string(token->text) : std::string();
    }
};

template <class Item> const Item& itemOf(const std::vector<Item>& items, std::int64_t index, const char* what) {
    if (index < 0 || index >= static_cast<std::int64_t>(items.size()))
        throw Damage("", fmt::format("names {} {} of {}", what, index, items.size()));
    return items[static_cast<std::size_t>(index)];
}

/// Surfaces by shader, in the order in which shaders are met.
class Surfaces {
public:
    ModelSurface& of(const std::string& shader) {
        const auto [at, isNew] = places_.try_emplace(shader, model.size());
        if (isNew) model.push_back({"", shader, {}, {}});
        return model[at->second];
    }
    void triangle(const std::string& shader, const std::array<ModelVertex, 3>& corners) {
        ModelSurface& surface = of(shader);
        for (const ModelVertex& corner : corners) {
            surface.indices.push_back(static_cast<std::uint32_t>(surface.vertices.size()));
            surface.vertices.push_back(corner);
        }
    }
    Model model;

private:
    std::map<std::string, std::size_t> places_;
};

/// "textures/a/b" of "..\textures\a\b.tga": what the game can find.
std::string inGame(std::string path) {
    for (char& c : path)
        if (c == '\\') c = '/';
    const std::string low = level::lower(path);
    for (const char* folder : {"textures/", "models/"})
        if (const std::size_t start = low.find(folder); start != std::string::npos) return low.substr(start);
    return {};
}

/// *MATERIAL blocks name shaders by their pictures; every *GEOMOBJECT has lists of corners, faces that name them, and a
/// material, of whose *SUBMATERIALs each face chooses one.
class AseReader {
public:
    explicit AseReader(std::string_view text) : words_(text) {}

    Model read() {
        while (const std::optional<Token> token = words_.next()) {
            if (token->quoted || !token->text.starts_with('*')) continue;
            key(level::lower(token->text.substr(1)));
        }
        finish();
        return std::move(surfaces_.model);
    }

private:
    struct Material {
        std::string name, picture;
        std::vector<Material> parts;
        [[nodiscard]] std::string shader() const {
            const std::string found = inGame(picture);
            return found.empty() ? name : found;
        }
    };
    using Corners = std::array<std::int64_t, 3>;
    struct Face {
        Corners corners{};
        std::int64_t part = 0;
    };
    struct FaceNormals {
        glm::dvec3 whole{0};
        std::vector<std::pair<std::int64_t, glm::dvec3>> corners; ///< by vertex
    };
    Words words_;
    std::vector<Material> materials_;
    Material* material_ = nullptr;
    std::vector<glm::dvec3> corners_;
    std::vector<glm::dvec2> texture_;
    // Lists come in any order.
    std::vector<Face> faces_;
    std::vector<Corners> texturedFaces_;
    std::vector<FaceNormals> faceNormals_;
    std::size_t normalsOf_ = 0;
    std::vector<glm::dvec3> vertexNormals_;
    std::int64_t chosen_ = -1;
    Surfaces surfaces_;

    static Material* grown(std::vector<Material>& list, std::int64_t index) {
        constexpr std::int64_t most = 4096;
        if (index < 0 || index >= most) throw Damage("", fmt::format("numbers a material {}", index));
        if (static_cast<std::size_t>(index) >= list.size()) list.resize(static_cast<std::size_t>(index) + 1);
        return &list[static_cast<std::size_t>(index)];
    }
    template <class Item> void put(std::vector<Item>& list, std::int64_t index, const Item& item) const {
        constexpr std::int64_t most = 1 << 22;
        if (index < 0 || index >= most)
            throw Damage(fmt::format("line {}", words_.line()), fmt::format("index {}", index));
        if (static_cast<std::size_t>(index) >= list.size()) list.resize(static_cast<std::size_t>(index) + 1);
        list[static_cast<std::size_t>(index)] = item;
    }

    void key(const std::string& name) {
        if (name == "material")
            material_ = grown(materials_, words_.integer());
        else if (name == "submaterial" && !materials_.empty())
            material_ = grown(materials_.back().parts, words_.integer());
        else if (name == "material_name" && material_ != nullptr)
            material_->name = words_.word();
        else if (name == "bitmap" && material_ != nullptr && material_->picture.empty())
            material_->picture = words_.word();
        else if (name == "geomobject")
            finish();
        else if (name == "material_ref")
            chosen_ = words_.integer();
        else if (name.starts_with("mesh_"))
            meshKey(name.substr(5));
    }

    void meshKey(const std::string& name) {
        if (name == "vertex") {
            const std::int64_t index = words_.integer();
            put(corners_, index, words_.triple());
        } else if (name == "tvert") {
            const std::int64_t index = words_.integer();
            const double u = words_.real();
            // Rows of pictures are counted from below.
            put(texture_, index, glm::dvec2(u, 1 - words_.real()));
        } else if (name == "face") {
            face();
        } else if (name == "mtlid" && !faces_.empty()) {
            faces_.back().part = words_.integer();
        } else if (name == "tface") {
            const std::int64_t index = words_.integer();
            Corners corners{};
            for (std::int64_t& corner : corners) corner = words_.integer();
            put(texturedFaces_, index, corners);
        } else if (name == "facenormal") {
            const std::int64_t index = words_.integer();
            put(faceNormals_, index, FaceNormals{words_.triple(), {}});
            normalsOf_ = static_cast<std::size_t>(index);
        } else if (name == "vertexnormal" && normalsOf_ < faceNormals_.size()) {
            // Behind its face, or all of them behind all faces.
            const std::int64_t vertex = words_.integer();
            const glm::dvec3 normal = words_.triple();
            faceNormals_[normalsOf_].corners.emplace_back(vertex, normal);
            put(vertexNormals_, vertex, normal);
        }
    }
    /// 0: A: 1 B: 2 C: 3 AB: …, where some exporters leave no blank behind a colon.
    void face() {
        Face face;
        std::int64_t index = -1;
        std::size_t next = 0;
        while (next < 4) {
            const std::optional<Token> token = words_.nextOnLine();
            if (!token) throw Damage(fmt::format("line {}", words_.line()), "a face without three corners");
            std::string_view text = token->text;
            while (!text.empty() &&
                   (text.front() == 'A' || text.front() == 'B' || text.front() == 'C' || text.front() == ':'))
                text.remove_prefix(1);
            if (text.empty()) continue;
            std::int64_t value = 0;
            if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc())
                throw Damage(fmt::format("line {}, column {}", token->line, token->column),
                             fmt::format("expected a corner, found '{}'", token->text.substr(0, 40)));
            if (next == 0)
                index = value;
            else
                face.corners.at(next - 1) = value;
            ++next;
        }
        put(faces_, index, face);
    }

    [[nodiscard]] std::string shaderOf(const Face& face) const {
        if (chosen_ < 0 || chosen_ >= static_cast<std::int64_t>(materials_.size())) return "";
        const Material& material = materials_[static_cast<std::size_t>(chosen_)];
        if (material.parts.empty()) return material.shader();
        return material.parts[static_cast<std::size_t>(std::abs(face.part)) % material.parts.size()].shader();
    }
    [[nodiscard]] glm::dvec3 normalOf(std::size_t face, std::int64_t vertex) const {
        if (face < faceNormals_.size())
            for (const auto& [of, normal] : faceNormals_[face].corners)
                if (of == vertex) return normal;
        if (vertex < static_cast<std::int64_t>(vertexNormals_.size()))
            return vertexNormals_[static_cast<std::size_t>(vertex)];
        return face < faceNormals_.size() ? faceNormals_[face].whole : glm::dvec3(0);
    }
    /// The object is whole: its faces become triangles.
    void finish() {
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            std::array<ModelVertex, 3> corners;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int64_t vertex = faces_[f].corners.at(i);
                corners.at(i).position = itemOf(corners_, vertex, "vertex");
                if (f < texturedFaces_.size())
                    corners.at(i).texture = itemOf(texture_, texturedFaces_[f].at(i), "texture vertex");
                corners.at(i).normal = normalOf(f, vertex);
            }
            surfaces_.triangle(shaderOf(faces_[f]), corners);
        }
        corners_.clear();
        texture_.clear();
        faces_.clear();
        texturedFaces_.clear();
        faceNormals_.clear();
        vertexNormals_.clear();
        chosen_ = -1;
        normalsOf_ = 0;
    }
};

} // namespace

Model readAse(std::string_view text) { return AseReader(text).read(); }

Model readObj(std::string_view text) {
    Words words(text);
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;
    std::vector<glm::dvec2> texture;
    Surfaces surfaces;
    std::string shader;
    // "7/1/3": numbers from 1, or from the end if negative; 0 or nothing: none.
    const auto corner = [&](std::string_view word) {
        ModelVertex vertex;
        for (int part = 0; part < 3 && !word.empty(); ++part) {
            const std::size_t slash = std::min(word.find('/'), word.size());
            std::int64_t index = 0;
            std::from_chars(word.data(), word.data() + slash, index);
            const auto from = [&](std::size_t count) {
                return index < 0 ? static_cast<std::int64_t>(count) + index : index - 1;
            };
            if (part == 0) vertex.position = itemOf(positions, from(positions.size()), "vertex");
            if (part == 1 && index != 0) vertex.texture = itemOf(texture, from(texture.size()), "texture vertex");
            if (part == 2 && index != 0) vertex.normal = itemOf(normals, from(normals.size()), "normal");
            word.remove_prefix(std::min(slash + 1, word.size()));
        }
        return vertex;
    };
    while (const std::optional<Token> token = words.next()) {
        if (token->text == "v") {
            positions.push_back(words.triple());
        } else if (token->text == "vn") {
            normals.push_back(words.triple());
        } else if (token->text == "vt") {
            const double u = words.real();
            texture.emplace_back(u, 1 - words.real());
        } else if (token->text == "usemtl") {
            shader = words.word();
        } else if (token->text == "f") {
            std::vector<ModelVertex> corners;
            while (const std::optional<Token> word = words.nextOnLine()) corners.push_back(corner(word->text));
            for (std::size_t i = 2; i < corners.size(); ++i)
                surfaces.triangle(shader, {corners[0], corners[i - 1], corners[i]});
            continue;
        }
        words.skipLine();
    }
    return std::move(surfaces.model);
}

} // namespace pie::brushes
