#include "methods/he_lowpass/in_between.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "methods/he_lowpass/value_filter.h"

namespace voxcarve {

InBetween::InBetween(const DensityVolume& coarse, const DensityVolume& fine, float iso_value, RunContext& context) {
  Stage stage(context, "in-between levels", fine.nz());
  const DensityVolume from = interpolated(coarse, fine.frame, context);
  const Index3 dims = fine.frame.dims;
  cells_ = (dims - Index3::Ones()).cwiseMax(0).prod();
  const auto bytes = static_cast<std::uint64_t>(fine.frame.voxels());
  context.require_memory(9 * bytes, "in-between levels");
  std::vector<std::uint8_t> touched(static_cast<std::size_t>(bytes), 0);
  for (std::int64_t k = 0; k + 1 < dims[2]; ++k) {
    for (std::int64_t j = 0; j + 1 < dims[1]; ++j) {
      for (std::int64_t i = 0; i + 1 < dims[0]; ++i) {
        bool inside = false;
        bool outside = false;
        for (int corner = 0; corner < 8; ++corner) {
          const std::size_t at = fine.index(i + corner % 2, j + corner / 2 % 2, k + corner / 4);
          for (const float value : {from.values[at], fine.values[at]}) (value >= iso_value ? inside : outside) = true;
        }
        if (!inside || !outside) continue;
        ++touched_cells_;
        for (int corner = 0; corner < 8; ++corner)
          touched[fine.index(i + corner % 2, j + corner / 2 % 2, k + corner / 4)] = 1;
      }
    }
    stage.advance(1);
  }
  elsewhere_ = fine;
  for (std::size_t at = 0; at < touched.size(); ++at) {
    const double difference = std::abs(static_cast<double>(fine.values[at]) - static_cast<double>(from.values[at]));
    largest_difference_ = std::max(largest_difference_, difference);
    if (touched[at] != 0) samples_.push_back({static_cast<std::int64_t>(at), from.values[at], fine.values[at]});
  }
}

DensityVolume InBetween::at(double share, RunContext& context) const {
  context.require_memory(
      2 * static_cast<std::uint64_t>(elsewhere_.frame.voxels()) * sizeof(float) + samples_.size() * sizeof(Sample),
      "an in-between level");
  DensityVolume volume = elsewhere_;
  for (const Sample& sample : samples_) {
    const auto coarse = static_cast<double>(sample.coarse);
    const auto fine = static_cast<double>(sample.fine);
    volume.values[static_cast<std::size_t>(sample.index)] =
        static_cast<float>(share == 1 ? fine : coarse + share * (fine - coarse));
  }
  return volume;
}

}  // namespace voxcarve
