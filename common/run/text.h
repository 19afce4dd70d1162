// Small helpers for messages and for text that is compared byte for byte.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxcarve {

/// "1.5 GiB", "12 KiB", "7 B".
std::string format_bytes(std::uint64_t bytes);

/// The shortest decimal text that reads back as the same double, the same on every machine ("0.1", "1e-12").
std::string format_real(double value);

/// "1234567" as "1,234,567".
std::string with_thousands(std::int64_t value);

/// The candidate with the smallest edit distance to `name`, or "" when none is within a third of its length (at least
/// 2).
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

/// "; did you mean 'x'?" or "".
std::string suggestion(std::string_view name, std::span<const std::string> candidates);

/// "a, b, c".
std::string join(std::span<const std::string> items, std::string_view separator = ", ");

/// "a soup", "an image": by the first letter of `noun`, which must not be empty.
std::string with_article(std::string_view noun);

/// Splits at every separator; "" gives no item.
std::vector<std::string> split(std::string_view text, char separator);

std::string to_lower(std::string_view text);

}  // namespace voxcarve
