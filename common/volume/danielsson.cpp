// Based on [Dan80], four-point sequential mapping, in three dimensions as [NT03, 4] runs it: upward and downward
// through the slices, in each of them after its neighbour in front upward and downward through the rows, in each of
// these after the row in front to the right and to the left. Differs in storing a vector as one number, in place of the
// distances, and in scanning the only row of a grid that has one row, where the papers' loops begin at the second.
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "common/run/errors.h"
#include "common/volume/distance_transform.h"
#include "common/volume/lower_envelope.h"

namespace voxcarve {

namespace {

/// How far away along each axis the feature of a voxel is, and its squared distance.
struct FeatureVector {
  std::uint32_t squared = kUnreached;
  std::uint16_t x = 0, y = 0, z = 0;

  /// A step from here never looks nearer than what was reached, so no comparison needs to ask.
  static constexpr std::uint32_t kUnreached = static_cast<std::uint32_t>(kInfiniteDistance);
};

static_assert(kLongestExactSide <= std::numeric_limits<std::uint16_t>::max());

/// Takes the vector of a neighbour one step along the axis of `component` when that is shorter than the own one.
inline void relax(FeatureVector& own, const FeatureVector& neighbour, std::uint16_t FeatureVector::*component) {
  const std::uint32_t squared = neighbour.squared + 2U * (neighbour.*component) + 1U;
  if (own.squared <= squared) return;
  own = neighbour;
  own.squared = squared;
  ++(own.*component);
}

/// The vectors of one slice.
class Slice {
 public:
  explicit Slice(const GridFrame& frame)
      : nx_(frame.dims[0]), ny_(frame.dims[1]), vectors_(static_cast<std::size_t>(nx_ * ny_)) {}

  FeatureVector& operator[](std::size_t i) { return vectors_[i]; }

  void relax_from(const Slice& neighbour) {
    for (std::size_t i = 0; i < vectors_.size(); ++i) relax(vectors_[i], neighbour.vectors_[i], &FeatureVector::z);
  }

  /// The two scans of the two-dimensional algorithm.
  void scan() {
    if (ny_ == 1) scan_row(row(0));
    for (std::int64_t j = 1; j < ny_; ++j) scan_row_after(row(j), row(j - 1));
    for (std::int64_t j = ny_ - 2; j >= 0; --j) scan_row_after(row(j), row(j + 1));
  }

 private:
  FeatureVector* row(std::int64_t j) { return vectors_.data() + j * nx_; }

  void scan_row_after(FeatureVector* current, const FeatureVector* neighbour) const {
    for (std::int64_t i = 0; i < nx_; ++i) relax(current[i], neighbour[i], &FeatureVector::y);
    scan_row(current);
  }
  void scan_row(FeatureVector* current) const {
    for (std::int64_t i = 1; i < nx_; ++i) relax(current[i], current[i - 1], &FeatureVector::x);
    for (std::int64_t i = nx_ - 2; i >= 0; --i) relax(current[i], current[i + 1], &FeatureVector::x);
  }

  std::int64_t nx_;
  std::int64_t ny_;
  std::vector<FeatureVector> vectors_;
};

/// Vectors as numbers: x + nx (y + ny z), of which a grid has fewer than voxels, so the distances' own memory holds
/// them between the two passes.
class VectorCode {
 public:
  explicit VectorCode(const GridFrame& frame)
      : nx_(static_cast<std::uint32_t>(frame.dims[0])), ny_(static_cast<std::uint32_t>(frame.dims[1])) {}

  std::int32_t encode(const FeatureVector& vector) const {
    if (vector.squared == FeatureVector::kUnreached) return static_cast<std::int32_t>(kNone);
    return static_cast<std::int32_t>(vector.x + nx_ * (vector.y + ny_ * vector.z));
  }
  FeatureVector decode(std::int32_t value) const {
    const auto code = static_cast<std::uint32_t>(value);
    FeatureVector vector;
    if (code == kNone) return vector;
    const std::uint32_t rows = code / nx_;
    const std::uint32_t x = code % nx_;
    const std::uint32_t y = rows % ny_;
    const std::uint32_t z = rows / ny_;
    vector.x = static_cast<std::uint16_t>(x);
    vector.y = static_cast<std::uint16_t>(y);
    vector.z = static_cast<std::uint16_t>(z);
    vector.squared = x * x + y * y + z * z;
    return vector;
  }

  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

 private:
  std::uint32_t nx_;
  std::uint32_t ny_;
};

}  // namespace

Grid<std::int32_t> squared_distance_4sed(const BinaryVolume& volume, std::uint8_t feature, RunContext& context) {
  require_exact_sides(volume.frame);
  if (volume.frame.voxels() > std::int64_t{VectorCode::kNone})
    throw ResourceError("Danielsson's distance map takes at most 2^32 - 1 voxels; lower the resolution");
  const std::int64_t nz = volume.nz();
  const auto in_slice = static_cast<std::size_t>(volume.nx() * volume.ny());
  context.require_memory(volume.values.size() * (sizeof(std::int32_t) + 1) + 2 * in_slice * sizeof(FeatureVector),
                         "Danielsson's distance map");
  Slice current(volume.frame);
  Slice previous(volume.frame);
  const VectorCode code(volume.frame);
  auto result = Grid<std::int32_t>::uninitialized(volume.frame);
  for (std::int64_t k = 0; k < nz; ++k) {
    context.check_cancelled();
    const std::size_t first = static_cast<std::size_t>(k) * in_slice;
    for (std::size_t i = 0; i < in_slice; ++i) {
      current[i] = FeatureVector();
      if (volume.values[first + i] == feature) current[i].squared = 0;
    }
    if (k > 0) current.relax_from(previous);
    current.scan();
    for (std::size_t i = 0; i < in_slice; ++i) result.values[first + i] = code.encode(current[i]);
    std::swap(current, previous);
  }
  for (std::int64_t k = nz - 1; k >= 0; --k) {
    context.check_cancelled();
    const std::size_t first = static_cast<std::size_t>(k) * in_slice;
    for (std::size_t i = 0; i < in_slice; ++i) current[i] = code.decode(result.values[first + i]);
    if (k + 1 < nz) {
      current.relax_from(previous);
      current.scan();
    }
    for (std::size_t i = 0; i < in_slice; ++i) result.values[first + i] = static_cast<std::int32_t>(current[i].squared);
    std::swap(current, previous);
  }
  return result;
}

}  // namespace voxcarve
