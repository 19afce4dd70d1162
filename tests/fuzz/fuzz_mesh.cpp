// Build for libFuzzer with -DVOXCARVE_LIBFUZZER -fsanitize=fuzzer.
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/mesh/io/mesh_io.h"
#include "common/run/errors.h"
#include "tests/fuzz/fuzz_targets.h"

namespace voxcarve::fuzz {

bool mesh(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return false;
  const auto format = static_cast<MeshFormat>(data[0] % 4);
  std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  std::string_view library;
  if (format == MeshFormat::kObj) {
    const std::size_t end = std::min(bytes.find('\0'), bytes.size());
    library = bytes.substr(std::min(end + 1, bytes.size()));
    bytes = bytes.substr(0, end);
  }
  const MaterialLoader loader = [library](std::string_view) { return std::optional<std::string>(library); };
  TriangleSoup soup;
  try {
    soup = parse_mesh(format, bytes, "fuzz", loader);
  } catch (const InputError&) {
    return false;
  }
  try {
    validate(soup, "fuzz");
  } catch (const InputError& error) {
    throw std::logic_error(std::string("the reader gave an invalid soup: ") + error.what());
  }
  const auto outside = [](const Color& color) { return !((color.array() >= 0).all() && (color.array() <= 1).all()); };
  if (std::ranges::any_of(soup.vertex_colors, outside) || std::ranges::any_of(soup.triangle_colors, outside)) {
    throw std::logic_error("the reader gave a colour outside [0, 1]");
  }
  return true;
}

}  // namespace voxcarve::fuzz

#ifdef VOXCARVE_LIBFUZZER
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voxcarve::fuzz::mesh(data, size);
  return 0;
}
#endif
