#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

#include "core/mesh/stl_check.h"

namespace {

using millscale::mesh::StlCheck;

/// Fault of the file, or "" if there is none.
std::string fault(const std::string& content, const std::string& name = "m.stl")
{
  std::istringstream file(content);
  return StlCheck(file, name).fault().value_or("");
}

const std::string triangle =
    "  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1 0 0\n"
    "      vertex 0 1e-3 0\n    endloop\n  endfacet\n";
const std::string text = "solid mill\n" + triangle + triangle + "endsolid mill\n";

std::string binary(const std::string& begin, std::uint32_t stated, int triangles,
                   float first_number = 1.0f)
{
  std::string file = begin + std::string(80 - begin.size(), ' ');
  file.append(reinterpret_cast<const char*>(&stated), 4);
  for (int k = 0; k < triangles; ++k) {
    const float numbers[12] = {0, 0, 1, first_number, 0, 0, 1, 1, 0, 0, 1, 0};
    file.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
    file.append(2, '\0');
  }
  return file;
}

std::string replaced(std::string where, const std::string& what, const std::string& by)
{
  const std::size_t at = where.find(what);
  EXPECT_NE(at, std::string::npos);
  return where.replace(at, what.size(), by);
}

TEST(StlCheck, WhatTheEngineReadsRightIsAccepted)
{
  EXPECT_EQ(fault(text), "");
  EXPECT_EQ(fault("\n" + text), "");                                    // read as text
  EXPECT_EQ(fault(text + "\n" + text), "");                             // two solids
  EXPECT_EQ(fault(replaced(text, "outer", "color 1 0 0\nouter")), "");  // line is ignored
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(fault(crlf), "");
  EXPECT_EQ(fault(binary("exported", 3, 3)), "");
  EXPECT_EQ(fault(binary("solidworks", 3, 3)), "");  // header word other than solid
  EXPECT_EQ(fault(binary("exported", 3, 3) + "more"), "");
  EXPECT_EQ(fault(binary(std::string(80, '\0'), 3, 3)), "");
  EXPECT_EQ(fault(binary("", 256, 256)), "");
}

TEST(StlCheck, ABinaryFileNamedSolidIsNoText)
{
  for (const char* begin : {"solid", "solid liner of the mill", "  solid"})
    EXPECT_EQ(fault(binary(begin, 3, 3)),
              "is binary with a header that begins with `solid`, which the engine reads as text; "
              "write another word there: printf STL__ | dd of='m.stl' conv=notrunc");
  EXPECT_NE(fault(binary("solid", 3, 2)).find("is binary"), std::string::npos);
  EXPECT_NE(fault(binary("\"solid\" mesh", 3, 3)).find("is binary"), std::string::npos);
  for (const char* begin : {"\nmesh", "# mesh", "  \n"})
    EXPECT_NE(fault(binary(begin, 3, 3)).find("begins with an empty line"), std::string::npos);
  EXPECT_NE(fault(binary("solid", 3, 3), "it's.stl").find("dd of='it'\\''s.stl' "),
            std::string::npos);
}

TEST(StlCheck, UpperCaseIsNoTextToTheEngine)
{
  std::string upper = text;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(fault(upper),
            "is text in upper case (`SOLID`), which the engine does not read; write it in lower "
            "case: tr A-Z a-z < 'm.stl' > lower-case.stl");
  EXPECT_EQ(fault(replaced(upper, "SOLID", "solid")).rfind("is text in upper case (`FACET`)", 0),
            0u);
}

TEST(StlCheck, AnyCutIsSeen)
{
  // A text is complete once `endsolid` is; the name may be cut.
  for (std::size_t size = 1; size < text.size() - std::strlen(" mill\n"); ++size)
    EXPECT_NE(fault(text.substr(0, size)), "") << size;
  EXPECT_EQ(fault(text.substr(0, text.find("endsolid"))),
            "is cut short: line 15, its last, is in a solid of 2 triangles, without `endsolid`; "
            "copy or export it again");
  EXPECT_EQ(fault(text.substr(0, text.rfind("endloop")))
                .rfind("is cut short: line 14, its last, "
                       "is in triangle 2,",
                       0),
            0u);
  const std::string whole = binary("exported", 7, 7);
  for (std::size_t size = 1; size < whole.size(); ++size)
    EXPECT_NE(fault(whole.substr(0, size)), "") << size;
  EXPECT_EQ(fault(whole.substr(0, 84 + 150)),
            "is cut short: its header states 7 triangles, its 234 bytes hold 3; copy or export it "
            "again");
}

TEST(StlCheck, NothingIsNoMesh)
{
  EXPECT_EQ(fault(""), "is empty; export the mesh again");
  EXPECT_EQ(fault("solid mill\nendsolid mill\n"), "holds no triangle; export the mesh again");
  EXPECT_EQ(fault(binary("exported", 0, 0)),
            "states 0 triangles in its header; export the mesh again");
}

TEST(StlCheck, ANumberThatIsNoneIsNamedWithItsLine)
{
  for (const char* word : {"0,001", "nan", "inf", "1e999", "0.1m"})
    EXPECT_EQ(fault(replaced(text, "1e-3", word)),
              std::string("line 6: a vertex has `") + word +
                  "`, expected a finite number with a decimal point; export the mesh again");
  EXPECT_EQ(fault(replaced(text, " 1e-3 0", "")),
            "line 6: a vertex needs 3 numbers, got 1; export the mesh again");
  EXPECT_EQ(fault(replaced(text, "    endloop", "vertex 1 1 1\n    endloop")),
            "line 9: a facet ends with 4 nodes, 3 are needed; export the mesh as triangles");
  EXPECT_EQ(fault(binary("exported", 2, 2, std::numeric_limits<float>::quiet_NaN())),
            "has a node of triangle 1 that is no finite number; export the mesh again");
}

TEST(StlCheck, OtherFilesAreNamedByHowTheyBegin)
{
  EXPECT_EQ(fault("version https://git-lfs.github.com/spec/v1\noid sha256:0\n")
                .rfind("begins with `version`, where a text STL has `solid`", 0),
            0u);
  EXPECT_EQ(fault("\xef\xbb\xbf" + text).rfind("begins with a byte order mark", 0), 0u);
  EXPECT_EQ(fault(std::string("\xff\xfes\0o\0l\0i\0d\0", 12)), "is UTF-16 text; save it as ASCII");
  std::string returns = text;
  for (char& c : returns)
    if (c == '\n') c = '\r';
  EXPECT_EQ(fault(returns).rfind("has lines that end in CR alone", 0), 0u);
}

TEST(StlCheck, AFileThatCannotBeReadIsNamed)
{
  const auto said = [](const std::string& name) {
    try {
      millscale::mesh::check_stl_file(name);
    } catch (const std::invalid_argument& problem) {
      return std::string(problem.what());
    }
    return std::string();
  };
  EXPECT_EQ(said("nowhere.stl").rfind("file 'nowhere.stl' does not exist; give its path", 0), 0u);
  EXPECT_EQ(said("/"), "file '/' is no regular file");
  EXPECT_NE(said(std::string(300, 'a') + ".stl").find("a name of 304 characters"),
            std::string::npos);
}

}  // namespace
