// Tables of text cells: for a terminal, and as CSV.
#pragma once

#include <string>
#include <vector>

#include "common/run/text.h"

namespace voxcarve {

/// A header and rows of equally many cells.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
};

/// Columns padded to their widest cell, two spaces apart, a rule under the header; columns whose cells are all numbers
/// or dashes are aligned to the right. Widths count code points.
std::string to_text(const Table& table);

/// RFC 4180: cells with commas, quotes or line ends are quoted. Lines end with "\n".
std::string to_csv(const Table& table);

/// A number with `digits` significant digits, without an exponent between 1e-4 and 1e7.
std::string rounded(double value, int digits);

}  // namespace voxcarve
