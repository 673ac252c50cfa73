#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <istream>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace millscale::mesh {

/// Reads an STL file as LIGGGHTS-PUBLIC 3.8 does, and finds what the engine's reader misreads. The
/// reader takes a file for text if its first line begins with `solid` or is empty, and for binary
/// otherwise. In text it skips unknown words, reads a word that is no number as 0, and takes the
/// end of the file for the end of the mesh.
class StlCheck {
 public:
  /// name: of the file, for the commands in the messages.
  StlCheck(std::istream& file, const std::string& name) : file_(file), name_(quoted(name)) {}

  /// Return what is wrong and what to do, as the rest of a sentence about the file; empty if the
  /// file is valid.
  std::optional<std::string> fault()
  {
    file_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(file_.tellg());
    head_.resize(std::min<std::uint64_t>(size_, 512));
    file_.seekg(0);
    file_.read(head_.data(), static_cast<std::streamsize>(head_.size()));
    if (size_ == 0) return "is empty; export the mesh again";
    if (begins_with("\xff\xfe") || begins_with("\xfe\xff"))
      return "is UTF-16 text; save it as ASCII";
    const bool text = is_text(), read_as_text = engine_reads_text();
    if (!text && read_as_text)
      return "is binary with a header that begins with " +
             std::string(first_word().empty() ? "an empty line" : "`solid`") +
             ", which the engine reads as text; write another word there: printf STL__ | dd of=" +
             name_ + " conv=notrunc";
    if (!text) return fault_of_binary();
    if (!read_as_text) return fault_of_first_word();
    return fault_of_text();
  }

 private:
  using Fault = std::optional<std::string>;
  static constexpr std::uint64_t header = 84, facet = 50;  ///< sizes in a binary file [bytes]

  /// Quote a name for a shell.
  static std::string quoted(const std::string& name)
  {
    std::string word = "'";
    for (const char c : name) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
  }

  bool begins_with(const char* bytes) const { return head_.rfind(bytes, 0) == 0; }

  /// Return whether the file is binary: as long as its header states, or with bytes that no text
  /// has.
  bool is_text() const
  {
    if (size_ >= header && size_ == header + facet * stated()) return false;
    return std::none_of(head_.begin(), head_.end(),
                        [](char c) {
                          return std::iscntrl(static_cast<unsigned char>(c)) &&
                                 !std::strchr("\t\n\v\f\r", c);
                        }) &&
           head_.find('\0') == std::string::npos;
  }

  std::uint64_t stated() const
  {
    std::uint32_t triangles = 0;
    std::memcpy(&triangles, head_.data() + header - sizeof triangles, sizeof triangles);
    return triangles;
  }

  std::string first_word() const
  {
    const std::string line = head_.substr(0, head_.find_first_of(std::string("\n#\0", 3)));
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) return "";
    const std::string& word = words.front();
    const bool quoted =
        word.size() > 1 && (word[0] == '"' || word[0] == '\'') && word.back() == word[0];
    return quoted ? word.substr(1, word.size() - 2) : word;  // as the engine
  }

  /// Return whether the engine reads the file as text. A zero byte before the end of the first line
  /// does not end the line: the engine reads on, to bytes that are no word of text.
  bool engine_reads_text() const
  {
    const std::string word = first_word();
    const std::size_t end = head_.find_first_of(std::string("\n#\0", 3));
    return word == "solid" || (word.empty() && end != std::string::npos && head_[end] != '\0');
  }

  static std::vector<std::string> words_of(const std::string& line)
  {
    std::vector<std::string> words;
    constexpr const char* space = " \t\r\n\f";
    for (std::size_t at = line.find_first_not_of(space); at != std::string::npos;) {
      const std::size_t end = std::min(line.find_first_of(space, at), line.size());
      words.push_back(line.substr(at, end - at));
      at = line.find_first_not_of(space, end);
    }
    return words;
  }

  static std::string lower(std::string word)
  {
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return word;
  }

  std::string upper_case(const std::string& word) const
  {
    return "is text in upper case (`" + word +
           "`), which the engine does not read; write it in lower case: tr A-Z a-z < " + name_ +
           " > lower-case.stl";
  }

  Fault fault_of_first_word() const
  {
    const std::string word = first_word();
    if (lower(word) == "solid") return upper_case(word);
    if (begins_with("\xef\xbb\xbf"))
      return "begins with a byte order mark, so the engine reads it as binary; leave that out: "
             "tail -c +4 " +
             name_ + " > without-mark.stl";
    return "begins with `" + word.substr(0, 20) +
           "`, where a text STL has `solid`; export the mesh again, as STL";
  }

  Fault fault_of_binary()
  {
    if (size_ < header)
      return "is cut short: " + std::to_string(size_) + " bytes, a binary STL has " +
             std::to_string(header) + " or more; copy or export it again";
    const std::uint64_t triangles = stated();
    if (triangles == 0) return "states 0 triangles in its header; export the mesh again";
    if (size_ < header + facet * triangles)
      return "is cut short: its header states " + std::to_string(triangles) + " triangles, its " +
             std::to_string(size_) + " bytes hold " + std::to_string((size_ - header) / facet) +
             "; copy or export it again";
    file_.seekg(header);
    for (std::uint64_t k = 0; k < triangles; ++k) {
      char bytes[facet];
      file_.read(bytes, facet);
      float numbers[12];  // normal, three nodes
      std::memcpy(numbers, bytes, sizeof numbers);
      for (int i = 3; i < 12; ++i)
        if (!std::isfinite(numbers[i]))
          return "has a node of triangle " + std::to_string(k + 1) +
                 " that is no finite number; export the mesh again";
    }
    return std::nullopt;
  }

  Fault fault_of_text()
  {
    file_.clear();
    file_.seekg(0);
    bool in_solid = false, in_facet = false;
    int nodes = 0;
    std::uint64_t triangles = 0, line_number = 0;
    for (std::string line; std::getline(file_, line);) {
      ++line_number;
      const std::vector<std::string> words = words_of(line.substr(0, line.find('#')));
      if (words.empty()) continue;
      const std::string& key = words.front();
      const std::string where = "line " + std::to_string(line_number) + ": ";
      if (key == "solid" || key == "endsolid")
        in_solid = key == "solid";
      else if (key == "facet") {
        if (in_facet) return where + "a facet begins within another; export the mesh again";
        in_facet = true;
        nodes = 0;
      } else if (key == "vertex") {
        if (const Fault fault = fault_of_vertex(words)) return where + *fault;
        ++nodes;
      } else if (key == "endfacet") {
        if (!in_facet || nodes != 3)
          return where + "a facet ends with " + std::to_string(nodes) +
                 " nodes, 3 are needed; export the mesh as triangles";
        in_facet = false;
        ++triangles;
      } else if (known(lower(key)) && !known(key))
        return upper_case(key);
    }
    if (head_.find('\r') != std::string::npos && head_.find('\n') == std::string::npos)
      return "has lines that end in CR alone, which the engine takes for one line: tr '\\r' '\\n' "
             "< " +
             name_ + " > lines.stl";
    if (in_solid || in_facet)
      return "is cut short: line " + std::to_string(line_number) + ", its last, is in " +
             (in_facet ? "triangle " + std::to_string(triangles + 1)
                       : "a solid of " + std::to_string(triangles) + " triangles") +
             ", without `endsolid`; copy or export it again";
    if (triangles == 0) return "holds no triangle; export the mesh again";
    return std::nullopt;
  }

  static Fault fault_of_vertex(const std::vector<std::string>& words)
  {
    if (words.size() != 4)
      return "a vertex needs 3 numbers, got " + std::to_string(words.size() - 1) +
             "; export the mesh again";
    for (std::size_t i = 1; i < words.size(); ++i) {
      char* end = nullptr;
      const double x = std::strtod(words[i].c_str(), &end);
      if (*end != '\0' || !std::isfinite(x))
        return "a vertex has `" + words[i].substr(0, 30) +
               "`, expected a finite number with a decimal point; export the mesh again";
    }
    return std::nullopt;
  }

  static bool known(const std::string& key)
  {
    for (const char* word :
         {"solid", "facet", "outer", "vertex", "endloop", "endfacet", "endsolid"})
      if (key == word) return true;
    return false;
  }

  std::istream& file_;
  std::string name_, head_;
  std::uint64_t size_ = 0;
};

/// Check an STL file. Throws std::invalid_argument with the file, the fault and what to do.
inline void check_stl_file(const std::string& name)
{
  constexpr std::size_t longest = 255;  // the engine copies the name to an array of this length
  const auto refuse = [&](const std::string& fault) {
    throw std::invalid_argument("file '" + name + "' " + fault);
  };
  if (name.size() > longest)
    refuse("has a name of " + std::to_string(name.size()) + " characters, the engine takes " +
           std::to_string(longest) + "; give a shorter path");
  std::error_code none;
  if (!std::filesystem::exists(name, none))
    refuse("does not exist; give its path from the folder in which the engine runs");
  if (!std::filesystem::is_regular_file(name, none)) refuse("is no regular file");
  std::ifstream file(name, std::ios::binary);
  if (!file) refuse("cannot be opened; check its permissions");
  if (const auto fault = StlCheck(file, name).fault()) refuse(*fault);
}

}  // namespace millscale::mesh
