#pragma once

#include <cstdio>
#include <cstdlib>
#include <istream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/liner/profile.h"

namespace millscale::liner {

/// Header of a profile's table. The lines `sectors,N` and `phase_rad,P` precede it. Each row is a
/// Node, in the frame of the sector's centre line.
inline constexpr const char* profile_columns = "radial_m,tangential_m,arc_radius_m,face,ahead";

namespace detail {

inline const char* const face_names[] = {"groove", "leading", "top", "trailing"};

inline Face face_from_name(const std::string& name)
{
  for (int i = 0; i < 4; ++i)
    if (name == face_names[i]) return static_cast<Face>(i);
  throw std::invalid_argument("face: got '" + name +
                              "', accepted are groove, leading, top, trailing");
}

inline double number_in(const std::string& text)
{
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0')
    throw std::invalid_argument("expected a number, got '" + text + "'");
  return value;
}

inline std::vector<std::string> split_at_commas(const std::string& line)
{
  std::vector<std::string> words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  return words;
}

}  // namespace detail

/// The profile as text. `read_profile` returns the same profile from it, bit by bit.
inline std::string profile_text(const Profile& profile)
{
  const auto exact = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.17g", value);
    return std::string(text);
  };
  std::string text = "sectors," + std::to_string(profile.sectors()) + "\nphase_rad," +
                     exact(profile.phase()) + "\n" + profile_columns + "\n";
  for (const Node& node : profile.nodes())
    text += exact(node.point.radial) + "," + exact(node.point.tangential) + "," +
            exact(node.arc_radius) + "," + detail::face_names[static_cast<int>(node.face)] + "," +
            std::to_string(node.ahead) + "\n";
  return text;
}

/// Read a profile. Throws std::invalid_argument with the number of the faulty line.
inline Profile read_profile(std::istream& in)
{
  std::vector<Node> nodes;
  double sectors = 0.0, phase = 0.0;
  bool table = false;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string> words = detail::split_at_commas(line);
    try {
      if (line == profile_columns)
        table = true;
      else if (!table && words.size() == 2 && words[0] == "sectors")
        sectors = detail::number_in(words[1]);
      else if (!table && words.size() == 2 && words[0] == "phase_rad")
        phase = detail::number_in(words[1]);
      else if (table && words.size() == 5)
        nodes.push_back({{detail::number_in(words[0]), detail::number_in(words[1])},
                         detail::number_in(words[2]),
                         detail::face_from_name(words[3]),
                         words[4] == "1" ? 1 : 0});
      else
        throw std::invalid_argument(
            std::string("expected `sectors,N`, `phase_rad,P`, the header `") + profile_columns +
            "` and rows of 5 columns, got '" + line + "'");
    } catch (const std::invalid_argument& problem) {
      throw std::invalid_argument("line " + std::to_string(number) + ": " + problem.what());
    }
  }
  if (!(sectors >= 1.0 && sectors <= most_sectors && sectors == static_cast<int>(sectors)))
    reject("sectors", "must be a whole number from 1 to " + std::to_string(most_sectors), sectors);
  return {nodes, static_cast<int>(sectors), phase};
}

}  // namespace millscale::liner
