#pragma once
// The parts of a shader definition that have a grammar of their own: stages and deformations.

#include "pie/level/shader.h"
#include "pie/level/tokens.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pie::level {

/// The words of one definition and the list of what is wrong with it.
class Words {
public:
    Words(std::string_view text, int line, std::string fileName, std::vector<std::string>& defects)
        : tokens_(text, line), fileName_(std::move(fileName)), defects_(&defects) {}

    [[nodiscard]] std::optional<Token> next() { return tokens_.next(); }
    [[nodiscard]] std::optional<Token> nextOnLine() { return tokens_.nextOnLine(); }
    void skipLine() { tokens_.skipLine(); }
    /// The next word of the line, empty at its end.
    std::string wordOnLine();
    /// The number that the next word of the line starts with, else 0.
    float numberOnLine();
    /// "( 1 2 3 )"; false and refused if it is not one.
    bool vector(Vec3& into);
    void refuse(const std::string& why);

private:
    Tokens tokens_;
    std::string fileName_;
    std::vector<std::string>* defects_;
};

[[nodiscard]] Wave parseWave(Words& words);
/// Behind the word "deformVertexes".
[[nodiscard]] std::optional<Deform> parseDeform(Words& words);

/// From behind the '{' of a stage to behind its '}'.
class StageParser {
public:
    explicit StageParser(Words& words) : words_(words) {}
    /// Nothing if the stage names no picture.
    [[nodiscard]] std::optional<Stage> parse();

private:
    void keyword(const std::string& word);
    void map();
    void clampMap();
    void animMap();
    void videoMap();
    void alphaFunc();
    void depthFunc();
    void detail();
    void blendFunc();
    void rgbGen();
    void alphaGen();
    void tcGen();
    void tcMod();
    void depthWrite();
    void finish();

    Words& words_;
    Stage stage_;
    bool hasPicture_ = false, hasBlend_ = false, hasRgbGen_ = false, hasTcGen_ = false, writesDepth_ = false;
};

} // namespace pie::level
