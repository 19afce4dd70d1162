// Reading numbers and words out of a text that came from anywhere: independent of the locale, with the line of every
// error.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace voxcarve {

/// The number that the whole token spells, or nothing. Accepts a leading '+', "inf" and "nan"; what is too small for a
/// double becomes 0, what is too large infinity.
std::optional<double> parse_real(std::string_view token);

/// The whole number that the whole token spells, or nothing (also when it exceeds 64 bits). Accepts a leading '+'.
std::optional<std::int64_t> parse_integer(std::string_view token);

/// The token between quotes, cut to a length that fits a message, with unprintable bytes replaced.
std::string in_quotes(std::string_view token);

/// Appends the shortest decimal text that reads back as the same number.
void append_number(std::string& text, double value);
void append_number(std::string& text, float value);
void append_number(std::string& text, std::int64_t value);

/// Walks through a text line by line (ends: LF, CRLF or CR) and token by token (separated by blanks and tabs). The text
/// and its name must outlive the scanner.
class TextScanner {
 public:
  TextScanner(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  /// Moves to the next line. False at the end of the text.
  bool next_line() {
    if (next_ >= text_.size()) {
      line_ = {};
      return false;
    }
    const std::size_t begin = next_;
    if (newline_ < begin || newline_ == kUnknown) newline_ = std::min(text_.find('\n', begin), text_.size());
    std::size_t end = text_.substr(0, newline_).find('\r', begin);
    if (end == std::string_view::npos) end = newline_;
    next_ = end + 1;
    if (end < text_.size() && text_[end] == '\r' && next_ < text_.size() && text_[next_] == '\n') ++next_;
    line_ = text_.substr(begin, end - begin);
    ++number_;
    return true;
  }

  /// Moves to the next line that is neither blank nor only a comment, and cuts a comment off its end.
  bool next_content_line(char comment) {
    while (next_line()) {
      line_ = line_.substr(0, std::min(line_.find(comment), line_.size()));
      if (!peek().empty()) return true;
    }
    return false;
  }

  /// The next token of the line; empty at its end.
  std::string_view token() {
    std::size_t begin = 0;
    while (begin < line_.size() && is_blank(line_[begin])) ++begin;
    std::size_t end = begin;
    while (end < line_.size() && !is_blank(line_[end])) ++end;
    const std::string_view found = line_.substr(begin, end - begin);
    line_.remove_prefix(end);
    return found;
  }

  /// What `token` would give, without moving on.
  std::string_view peek() const { return TextScanner(*this).token(); }

  /// The next token, on a later line if this one has no more; empty at the end of the text.
  std::string_view stream_token() {
    for (;;) {
      const std::string_view found = token();
      if (!found.empty() || !next_line()) return found;
    }
  }

  /// The unread part of the line without blanks at its ends; the line is then used up.
  std::string_view rest();

  /// The next token of the line as a number. `what` names it in the message when it is missing or is none.
  double real(std::string_view what) {
    const std::string_view found = token();
    const std::optional<double> value = parse_real(found);
    if (!value) refuse_number(found, what);
    return *value;
  }
  /// The same for a real that must be finite.
  double finite(std::string_view what) {
    const double value = real(what);
    if (!(value - value == 0)) fail(std::string(what) + " is not finite");
    return value;
  }
  std::int64_t integer(std::string_view what) {
    const std::string_view found = token();
    const std::optional<std::int64_t> value = parse_integer(found);
    if (!value) refuse_number(found, what);
    return *value;
  }

  /// Replaces the unread part of the line, for formats in which a line can go on. `line` must outlive its use.
  void set_line(std::string_view line) { line_ = line; }
  std::string_view line() const { return line_; }

  std::size_t line_number() const { return number_; }
  /// Offset of the first byte after the line.
  std::size_t offset() const { return std::min(next_, text_.size()); }
  /// Number of bytes after the line.
  std::size_t remaining() const { return text_.size() - offset(); }
  std::string_view name() const { return name_; }

  /// Throws InputError with the name and the line.
  [[noreturn]] void fail(std::string_view message) const;

  /// Refuses a count that the rest of the text cannot hold. One item takes `tokens` tokens, so at least twice as many
  /// bytes with their separators, of which the last may lack its own.
  void require_items(std::int64_t count, std::size_t tokens, std::string_view what) const;

 private:
  static constexpr std::size_t kUnknown = std::string_view::npos;
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\r' || c == '\n'; }
  [[noreturn]] void refuse_number(std::string_view found, std::string_view what) const;

  std::string_view text_;
  std::string_view name_;
  std::string_view line_;           // the unread part of the current line
  std::size_t next_ = 0;            // where the next line begins
  std::size_t newline_ = kUnknown;  // the first '\n' at or after the line's begin, so that CR files stay linear
  std::size_t number_ = 0;
};

}  // namespace voxcarve
