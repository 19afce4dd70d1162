#include "experiments/runner/table.h"

#include <fmt/format.h>

#include <algorithm>

namespace voxcarve {

namespace {

std::size_t display_width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

bool reads_as_number(const std::string& cell) {
  return cell.empty() || cell == "-" || cell.find_first_not_of("0123456789.,+-e% ") == std::string::npos;
}

std::string padded_cell(const std::string& cell, std::size_t width, bool right) {
  const std::string space(width - std::min(width, display_width(cell)), ' ');
  return right ? space + cell : cell + space;
}

std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\n\r") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t c = 0; c < cells.size(); ++c) line += (c == 0 ? "" : ",") + csv_cell(cells[c]);
  return line + "\n";
}

}  // namespace

std::string to_text(const Table& table) {
  const std::size_t columns = table.header.size();
  std::vector<std::size_t> width(columns);
  std::vector<bool> right(columns, true);
  for (std::size_t c = 0; c < columns; ++c) {
    width[c] = display_width(table.header[c]);
    for (const auto& row : table.rows) {
      width[c] = std::max(width[c], display_width(row.at(c)));
      right[c] = right[c] && reads_as_number(row[c]);
    }
  }
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string text;
    for (std::size_t c = 0; c < columns; ++c) text += (c == 0 ? "" : "  ") + padded_cell(cells[c], width[c], right[c]);
    text.erase(text.find_last_not_of(' ') + 1);
    return text + "\n";
  };
  std::string text = line(table.header);
  std::string rule;
  for (std::size_t c = 0; c < columns; ++c) rule += (c == 0 ? "" : "  ") + std::string(width[c], '-');
  text += rule + "\n";
  for (const auto& row : table.rows) text += line(row);
  return text;
}

std::string to_csv(const Table& table) {
  std::string text = csv_line(table.header);
  for (const auto& row : table.rows) text += csv_line(row);
  return text;
}

std::string rounded(double value, int digits) {
  return fmt::format("{:.{}g}", value, digits);
}

}  // namespace voxcarve
