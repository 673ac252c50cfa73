#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace millscale::test {

using Row = std::map<std::string, std::string>;

inline std::vector<std::string> cells(const std::string& line)
{
  std::vector<std::string> result;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) result.push_back(cell);
  return result;
}

/// Rows of a table of the paper (analysis/mill_analysis/paper_tables), by column name.
inline std::vector<Row> paper_table(const std::string& name)
{
  const std::string path = MILLSCALE_PAPER_TABLES "/" + name;
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  std::vector<Row> rows;
  std::vector<std::string> header;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> values = cells(line);
    if (header.empty()) {
      header = values;
      continue;
    }
    Row row;
    for (std::size_t i = 0; i < header.size(); ++i) row[header[i]] = values.at(i);
    rows.push_back(row);
  }
  return rows;
}

inline double number(const Row& row, const std::string& column)
{
  return std::stod(row.at(column));
}

}  // namespace millscale::test
