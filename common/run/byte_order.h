// Numbers in files, in either byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace voxcarve {

/// The number whose bytes begin at `bytes`, aligned or not.
template <class T>
T load(const char* bytes, std::endian order) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (order != std::endian::native) std::ranges::reverse(raw);
  return std::bit_cast<T>(raw);
}

/// Appends the bytes of a number, the lowest first.
template <class T>
void append_little_endian(std::string& bytes, T value) {
  auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (std::endian::native != std::endian::little) std::ranges::reverse(raw);
  bytes.append(raw.data(), raw.size());
}

}  // namespace voxcarve
