#include "common/run/text_scanner.h"

#include <array>
#include <charconv>
#include <limits>

#include "common/run/errors.h"

namespace voxcarve {

namespace {

/// std::from_chars takes no '+'; "+-1" stays wrong.
std::string_view without_plus(std::string_view token) {
  const bool plus = token.size() > 1 && token[0] == '+' && token[1] != '-' && token[1] != '+';
  return plus ? token.substr(1) : token;
}

/// The value of a well-formed number that std::from_chars found out of range: 0 or infinity, by the decimal exponent of
/// its first significant digit.
double beyond_range(std::string_view token) {
  const bool negative = token.starts_with('-');
  if (negative) token.remove_prefix(1);
  const std::size_t mark = std::min(token.find_first_of("eE"), token.size());
  const std::string_view mantissa = token.substr(0, mark);
  const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size()));
  const auto digit = static_cast<std::int64_t>(std::min(mantissa.find_first_of("123456789"), mantissa.size()));
  std::int64_t exponent = 0;
  if (mark < token.size()) {
    const std::string_view digits = token.substr(mark + 1);
    // An exponent that exceeds 64 bits decides alone.
    exponent = parse_integer(digits).value_or(digits.starts_with('-') ? -1000000000000 : 1000000000000);
    exponent = std::clamp<std::int64_t>(exponent, -1000000000000, 1000000000000);
  }
  const double size = exponent + point - digit < 0 ? 0.0 : std::numeric_limits<double>::infinity();
  return negative ? -size : size;
}

template <class T>
void append_shortest(std::string& text, T value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), result.ptr);
}

}  // namespace

std::optional<double> parse_real(std::string_view token) {
  token = without_plus(token);
  double value = 0;
  const char* const last = token.data() + token.size();
  const auto [end, error] = std::from_chars(token.data(), last, value);
  if (end != last || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) return beyond_range(token);
  return value;
}

std::optional<std::int64_t> parse_integer(std::string_view token) {
  token = without_plus(token);
  std::int64_t value = 0;
  const char* const last = token.data() + token.size();
  const auto [end, error] = std::from_chars(token.data(), last, value);
  if (end != last || error != std::errc{}) return std::nullopt;
  return value;
}

std::string in_quotes(std::string_view token) {
  constexpr std::size_t kShown = 32;
  std::string text = "'";
  for (const char c : token.substr(0, kShown)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (token.size() > kShown ? "...'" : "'");
}

void append_number(std::string& text, double value) {
  append_shortest(text, value);
}
void append_number(std::string& text, float value) {
  append_shortest(text, value);
}
void append_number(std::string& text, std::int64_t value) {
  append_shortest(text, value);
}

std::string_view TextScanner::rest() {
  std::string_view found = line_;
  line_ = {};
  while (!found.empty() && is_blank(found.front())) found.remove_prefix(1);
  while (!found.empty() && is_blank(found.back())) found.remove_suffix(1);
  return found;
}

void TextScanner::fail(std::string_view message) const {
  throw InputError(name_, "line " + std::to_string(std::max<std::size_t>(number_, 1)), message);
}

void TextScanner::refuse_number(std::string_view found, std::string_view what) const {
  if (found.empty()) fail(std::string(what) + " is missing; the file may be truncated");
  fail(std::string(what) + " is not a number: " + in_quotes(found));
}

void TextScanner::require_items(std::int64_t count, std::size_t tokens, std::string_view what) const {
  if (count < 0) fail("negative number of " + std::string(what) + ": " + std::to_string(count));
  if (tokens == 0) return;
  if (static_cast<std::uint64_t>(count) > (remaining() + 1) / (2 * tokens)) {
    fail(std::to_string(count) + " " + std::string(what) + " announced, but only " + std::to_string(remaining()) +
         " bytes follow; the file is truncated or its counts are wrong");
  }
}

}  // namespace voxcarve
