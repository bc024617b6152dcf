#include "pie/level/names.h"
#include "pie/level/tokens.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <string_view>

using namespace pie::level;

namespace {

std::vector<std::string> words(std::string_view text) {
    Tokens tokens(text);
    std::vector<std::string> result;
    while (const std::optional<Token> token = tokens.next()) result.emplace_back(token->text);
    return result;
}

using Words = std::vector<std::string>;

} // namespace

TEST(Tokens, SplitAtWhiteSpaceAndKeepQuotedText) {
    EXPECT_EQ(words("a  b\t\"c d\"\r\n{ e}"), (Words{"a", "b", "c d", "{", "e}"}));
    EXPECT_EQ(words(""), Words{});
    EXPECT_EQ(words("\"\""), Words{""});
}

TEST(Tokens, CommentsAreWhiteSpaceEvenBehindAWord) {
    EXPECT_EQ(words("a // b\nc /* d\n e */ f"), (Words{"a", "c", "f"}));
    EXPECT_EQ(words("textures//x y"), (Words{"textures"}));
    EXPECT_EQ(words("a/*b*/c"), (Words{"a", "c"}));
    EXPECT_EQ(words("a /* never closed"), (Words{"a"}));
    EXPECT_EQ(words("\"a // b\""), (Words{"a // b"}));
    EXPECT_EQ(words("a/b / c"), (Words{"a/b", "/", "c"}));
}

TEST(Tokens, KnowLineAndColumn) {
    Tokens tokens("a\n  bb /* \n */ c \"d\ne\" f");
    const auto at = [&] {
        const std::optional<Token> t = tokens.next();
        return std::pair(t->line, t->column);
    };
    EXPECT_EQ(at(), std::pair(1, 1));
    EXPECT_EQ(at(), std::pair(2, 3));
    EXPECT_EQ(at(), std::pair(3, 5));
    EXPECT_EQ(at(), std::pair(3, 7));
    EXPECT_EQ(at(), std::pair(4, 4));
}

TEST(Tokens, LineWiseReadingStopsAtTheEndOfTheLine) {
    Tokens tokens("map x // y\nnext");
    EXPECT_EQ(tokens.nextOnLine()->text, "map");
    EXPECT_EQ(tokens.nextOnLine()->text, "x");
    EXPECT_FALSE(tokens.nextOnLine());
    EXPECT_FALSE(tokens.nextOnLine());
    EXPECT_EQ(tokens.next()->text, "next");
    EXPECT_FALSE(tokens.next());
}

// ctf_compromise's sand: "tcMod scale 7 7\r\t\talphaGen vertex\r\n" are two lines to the game.
TEST(Tokens, ALoneCarriageReturnEndsALine) {
    Tokens tokens("tcMod 7\r\talphaGen\r\nend");
    EXPECT_EQ(tokens.nextOnLine()->text, "tcMod");
    EXPECT_EQ(tokens.nextOnLine()->text, "7");
    EXPECT_FALSE(tokens.nextOnLine());
    EXPECT_EQ(tokens.next()->text, "alphaGen");
    tokens.skipLine();
    const auto end = tokens.next();
    EXPECT_EQ(end->text, "end");
    EXPECT_EQ(end->line, 2);
}

TEST(Tokens, BlocksNestAndMayEndTooEarly) {
    Tokens tokens("{ a { b } c } d");
    EXPECT_TRUE(tokens.next()->is('{'));
    EXPECT_TRUE(tokens.skipBlock());
    EXPECT_EQ(tokens.next()->text, "d");
    Tokens open("a { b");
    EXPECT_FALSE(open.skipBlock());
    Tokens quoted("\"}\" }");
    EXPECT_TRUE(quoted.skipBlock());
    EXPECT_FALSE(quoted.next());
}

TEST(Tokens, SkippingABlockIsReadingItsWords) {
    std::minstd_rand random(7);
    constexpr std::string_view letters = "{}{} \"/*\n\r a";
    for (int round = 0; round < 20'000; ++round) {
        std::string text(random() % 40, ' ');
        for (char& c : text) c = letters[random() % letters.size()];
        Tokens skipped(text);
        Tokens read(text);
        int depth = 1;
        while (depth > 0) {
            const auto token = read.next();
            if (!token) break;
            if (token->is('{')) ++depth;
            if (token->is('}')) --depth;
        }
        ASSERT_EQ(skipped.skipBlock(), depth == 0) << text;
        ASSERT_EQ(skipped.offset(), read.offset()) << text;
        ASSERT_EQ(skipped.line(), read.line()) << text;
        const auto next = skipped.next();
        const auto expected = read.next();
        ASSERT_EQ(next.has_value(), expected.has_value()) << text;
        ASSERT_TRUE(!next || next->column == expected->column) << text;
    }
}

TEST(Tokens, NumbersAreReadAsTheGameReadsThem) {
    EXPECT_EQ(toNumber("1.5"), 1.5F);
    EXPECT_EQ(toNumber("+2"), 2.0F);
    EXPECT_EQ(toNumber(".5x"), 0.5F);
    EXPECT_EQ(toNumber("-3e1"), -30.0F);
    EXPECT_EQ(toNumber("sin"), 0.0F);
    EXPECT_EQ(toNumber(""), 0.0F);
    EXPECT_EQ(toNumber("nan"), 0.0F);
    EXPECT_EQ(toNumber("inf"), 0.0F);
    EXPECT_EQ(toNumber("1e999"), 0.0F);
    EXPECT_FALSE(leadingNumber("x1"));
    std::string_view rest;
    EXPECT_EQ(leadingNumber(" 12 34", &rest), 12.0F);
    EXPECT_EQ(rest, " 34");
}

TEST(Names, SafeNamesStayInsideTheirTree) {
    EXPECT_EQ(safeName("Textures\\Base//./X.TGA"), "textures/base/x.tga");
    EXPECT_EQ(safeName("a/b/"), "a/b");
    for (const char* bad :
         {"", ".", "..", "../a", "a/../b", "a/..", "/etc/passwd", "\\a", "c:/a", "c:a", "a/\n", "..\\a"})
        EXPECT_FALSE(safeName(bad)) << bad;
    EXPECT_EQ(safeName("..a/b..c"), "..a/b..c");
}

TEST(Names, ExtensionsBelongToTheLastPart) {
    EXPECT_EQ(extension("a/b.tga"), "tga");
    EXPECT_EQ(extension("a.b/c"), "");
    EXPECT_EQ(withoutExtension("a.b/c"), "a.b/c");
    EXPECT_EQ(withoutExtension("a.b/c.blend.tga"), "a.b/c.blend");
    EXPECT_TRUE(endsWithNoCase("X.PK3", ".pk3"));
    EXPECT_FALSE(endsWithNoCase("3", ".pk3"));
    EXPECT_TRUE(equalNoCase("AbC", "aBc"));
    EXPECT_FALSE(equalNoCase("AbC", "aBcd"));
}
