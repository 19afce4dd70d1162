// Build for libFuzzer with -DVOXCARVE_LIBFUZZER -fsanitize=fuzzer.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/run/errors.h"
#include "common/volume/io/volume_io.h"
#include "tests/fuzz/fuzz_targets.h"

namespace voxcarve::fuzz {

namespace {

void check(const VolumeFile& file) {
  const GridFrame& frame = file.values.frame;
  const bool sizes_agree =
      (frame.dims.array() >= 1).all() && file.values.values.size() == static_cast<std::size_t>(frame.voxels());
  if (!sizes_agree) throw std::logic_error("the reader gave a grid whose sizes disagree");
  if (!frame.origin.allFinite() || !(frame.voxel_size > 0) || !std::isfinite(frame.voxel_size)) {
    throw std::logic_error("the reader gave a grid that lies nowhere");
  }
  const auto wrong = [&file](float value) {
    return !std::isfinite(value) || (file.is_binary && value != 0 && value != 1);
  };
  if (std::ranges::any_of(file.values.values, wrong)) throw std::logic_error("the reader gave an invalid sample");
}

}  // namespace

bool volume(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return false;
  const auto format = static_cast<VolumeFormat>(data[0] % 4);
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const DataLoader loader = [](std::string_view) { return std::string(64, '\1'); };
  VolumeFile file;
  try {
    file = parse_volume(format, bytes, "fuzz", loader);
  } catch (const InputError&) {
    return false;
  }
  check(file);
  return true;
}

}  // namespace voxcarve::fuzz

#ifdef VOXCARVE_LIBFUZZER
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  voxcarve::fuzz::volume(data, size);
  return 0;
}
#endif
