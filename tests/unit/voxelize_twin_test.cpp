// The voxelizer against its slow, obvious twin: every voxel by itself, every triangle against its rays, exactly.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/mesh/line_stabber.h"
#include "common/mesh/models/primitives.h"
#include "common/run/errors.h"
#include "common/volume/curtains.h"
#include "common/volume/voxelize.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

using test::frame_of;

__extension__ using Wide = __int128;
using WideVector = std::array<Wide, 3>;

WideVector minus(const WideVector& a, const WideVector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
WideVector cross(const WideVector& a, const WideVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Wide dot(const WideVector& a, const WideVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The sign at p + (e, e^2, e^3) of the linear function that is gradient . (p - a) at p: its first term that counts.
int moved_sign(const WideVector& gradient, const WideVector& p, const WideVector& a) {
  for (const Wide term : {dot(gradient, minus(p, a)), gradient[0], gradient[1], gradient[2]}) {
    if (term != 0) return term > 0 ? 1 : -1;
  }
  return 0;
}

/// Crossings of a voxel's ray in front of the voxel's centre, and of the whole line.
struct Count {
  std::int64_t in_front = 0;
  std::int64_t total = 0;
};

class Twin {
 public:
  Twin(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options)
      : soup_(soup), frame_(frame), options_(options) {
    // Vertices in voxels, rounded to 2^-16, or coarser where they reach beyond 2^12.
    double largest = 1;
    for (const Triangle& triangle : soup.triangles) {
      for (const std::uint32_t vertex : triangle) largest = std::max(largest, voxels(vertex).cwiseAbs().maxCoeff());
    }
    while (std::ldexp(largest + 1, bits_) > 0x1p28) --bits_;
    for (const Triangle& triangle : soup.triangles) {
      corners_.push_back({lattice(triangle[0]), lattice(triangle[1]), lattice(triangle[2])});
    }
  }

  BinaryVolume classes(VoxelizeReport& report) {
    const bool parity = options_.classifier == Classifier::kParity;
    const std::vector<Point> directions = voxelization_directions(options_.directions, options_.axis);
    TriangleSoup local = soup_;  // in voxels, for the directions that are no axis
    for (Point& position : local.positions) position = (position - frame_.origin) / frame_.voxel_size;
    Grid<std::uint8_t> in(frame_);
    Grid<std::uint8_t> out(frame_);
    for (const Point& direction : directions) {
      const Eigen::Index axis = std::find(direction.begin(), direction.end(), 1.0) - direction.begin();
      VoxelizeReport::Axis met{static_cast<int>(axis), 0, 0};
      const LineStabber stabber(local, StabFrame::along(direction));
      for_each_voxel([&](const Index3& voxel) {
        const Count count = axis < 3 ? along_axis(voxel, static_cast<std::size_t>(axis)) : along(stabber, voxel);
        const bool abstains = count.total % 2 != 0 && (parity || options_.stab_validity);
        if (axis < 3 && voxel[axis] == 0) {
          met.columns += count.total > 0;
          met.invalid_columns += abstains;
        }
        if (abstains) return;
        const bool interior = parity ? count.in_front % 2 != 0 : count.in_front > 0 && count.in_front < count.total;
        ++(interior ? in : out)(voxel[0], voxel[1], voxel[2]);
      });
      if (axis < 3) report.axes.push_back(met);
    }
    BinaryVolume volume(frame_);
    BinaryVolume disputed(frame_);
    for (std::size_t i = 0; i < volume.values.size(); ++i) {
      const int ins = in.values[i];
      const int outs = out.values[i];
      volume.values[i] = parity ? ins > outs : ins > 0 && outs == 0;
      disputed.values[i] = ((ins > 0 && outs > 0) || ins + outs == 0) && 2 * std::max(ins, outs) < options_.directions;
    }
    if (parity && options_.directions > 1) settle(volume, disputed, report);
    return volume;
  }

 private:
  Point voxels(std::uint32_t vertex) const {
    return (soup_.positions[vertex] - frame_.origin) / frame_.voxel_size - Point::Constant(0.5);
  }
  WideVector lattice(std::uint32_t vertex) const {
    const Point p = voxels(vertex) * std::ldexp(1.0, bits_);
    return {std::llround(p[0]), std::llround(p[1]), std::llround(p[2])};
  }

  template <class Visit>
  void for_each_voxel(const Visit& visit) const {
    for (std::int64_t k = 0; k < frame_.dims[2]; ++k) {
      for (std::int64_t j = 0; j < frame_.dims[1]; ++j) {
        for (std::int64_t i = 0; i < frame_.dims[0]; ++i) visit(Index3(i, j, k));
      }
    }
  }

  Count along_axis(const Index3& voxel, std::size_t axis) const {
    const Wide one = Wide{1} << bits_;
    const WideVector p = {voxel[0] * one, voxel[1] * one, voxel[2] * one};
    WideVector ray = {0, 0, 0};
    ray[axis] = 1;
    Count count;
    for (const std::array<WideVector, 3>& corners : corners_) {
      const WideVector normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
      if (normal[axis] == 0) continue;
      const int sign = normal[axis] > 0 ? 1 : -1;
      bool crosses = true;
      for (std::size_t side = 0; side < 3; ++side) {
        const WideVector along_side = minus(corners[(side + 1) % 3], corners[side]);
        crosses &= moved_sign(cross(ray, along_side), p, corners[side]) == sign;
      }
      count.total += crosses;
      count.in_front += crosses && moved_sign(normal, p, corners[0]) == sign;
    }
    return count;
  }

  static Count along(const LineStabber& stabber, const Index3& voxel) {
    const Point center = voxel.cast<double>() + Point::Constant(0.5) + Point(0x1p-10, 0x1p-13, 0x1p-16);
    std::vector<Crossing> crossings;
    stabber.append_crossings(center.dot(stabber.frame().u), center.dot(stabber.frame().v), crossings);
    const double depth = center.dot(stabber.frame().w);
    return {std::ranges::count_if(crossings, [&](const Crossing& crossing) { return crossing.depth <= depth; }),
            std::ssize(crossings)};
  }

  void settle(BinaryVolume& volume, const BinaryVolume& disputed, VoxelizeReport& report) const {
    const BinaryVolume voted = volume;
    for (int sweep = 0; sweep < options_.settle_sweeps; ++sweep) {
      const BinaryVolume before = volume;
      for_each_voxel([&](const Index3& v) {
        if (disputed(v[0], v[1], v[2]) == 0) return;
        int interior = 0;
        for (int n = 0; n < 27; ++n) {
          if (n != 13) interior += before.get(v[0] + n % 3 - 1, v[1] + n / 3 % 3 - 1, v[2] + n / 9 - 1, 0);
        }
        if (interior != 13) volume(v[0], v[1], v[2]) = interior > 13;
      });
    }
    for (std::size_t i = 0; i < volume.values.size(); ++i) report.settled_voxels += volume.values[i] != voted.values[i];
  }

  const TriangleSoup& soup_;
  const GridFrame& frame_;
  const VoxelizeOptions& options_;
  int bits_ = 16;
  std::vector<std::array<WideVector, 3>> corners_;  ///< of the triangles, on the lattice
};

void expect_as_twin(const TriangleSoup& soup, const GridFrame& frame, const VoxelizeOptions& options) {
  VoxelizeReport expected;
  const BinaryVolume volume = Twin(soup, frame, options).classes(expected);
  for (const int threads : {1, 3}) {
    RunContext context;
    context.threads = threads;
    VoxelizeReport report;
    ASSERT_EQ(voxelize(soup, frame, options, context, &report), volume);
    ASSERT_EQ(report.axes.size(), expected.axes.size());
    for (std::size_t i = 0; i < report.axes.size(); ++i) {
      EXPECT_EQ(report.axes[i].axis, expected.axes[i].axis);
      EXPECT_EQ(report.axes[i].columns, expected.axes[i].columns);
      EXPECT_EQ(report.axes[i].invalid_columns, expected.axes[i].invalid_columns);
    }
    EXPECT_EQ(report.settled_voxels, expected.settled_voxels);
  }
}

std::vector<VoxelizeOptions> all_options(bool oblique) {
  std::vector<VoxelizeOptions> all;
  for (const int directions : {1, 3, 13}) {
    if (directions == 13 && !oblique) continue;
    for (int axis = 0; axis < (directions == 1 ? 3 : 1); ++axis) {
      for (const int sweeps : {0, 1, 4}) {
        all.push_back(
            {.classifier = Classifier::kParity, .directions = directions, .axis = axis, .settle_sweeps = sweeps});
      }
      for (const bool validity : {false, true}) {
        all.push_back(
            {.classifier = Classifier::kStabbing, .directions = directions, .axis = axis, .stab_validity = validity});
      }
    }
  }
  return all;
}

void expect_as_twin_with_all_options(const TriangleSoup& soup, const GridFrame& frame, bool oblique = false) {
  for (const VoxelizeOptions& options : all_options(oblique)) {
    SCOPED_TRACE(testing::Message() << "directions " << options.directions << " axis " << options.axis << " classifier "
                                    << static_cast<int>(options.classifier) << " sweeps " << options.settle_sweeps
                                    << " validity " << options.stab_validity);
    expect_as_twin(soup, frame, options);
    if (testing::Test::HasFatalFailure()) return;
  }
}

/// Triangles with corners drawn one coordinate at a time by `coordinate`; some share vertices, some are repeated, some
/// have two corners at one vertex or all three on a line.
template <class Coordinate>
TriangleSoup random_soup(int triangles, std::mt19937& random, const Coordinate& coordinate) {
  TriangleSoup soup;
  const auto vertices = static_cast<std::uint32_t>(triangles + 4);
  for (std::uint32_t i = 0; i < vertices; ++i) {
    soup.positions.emplace_back(coordinate(0), coordinate(1), coordinate(2));
  }
  soup.positions[2] = 0.5 * (soup.positions[0] + soup.positions[1]);
  soup.triangles = {{0, 1, 2}, {3, 3, 4}};
  while (std::ssize(soup.triangles) < triangles) {
    soup.triangles.push_back({static_cast<std::uint32_t>(random() % vertices),
                              static_cast<std::uint32_t>(random() % vertices),
                              static_cast<std::uint32_t>(random() % vertices)});
    if (random() % 8 == 0) soup.triangles.push_back(soup.triangles.back());
  }
  return soup;
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) * 0x1p-32;
}

// Longer than a word along x, than a row's span that is tested sample by sample, and than a slab or band.
const Index3 kLong[] = {{70, 6, 5}, {6, 70, 5}, {5, 6, 70}, {64, 7, 5}, {130, 3, 4}, {1, 1, 1}};

TEST(VoxelizeTwin, RandomSoupsInGeneralPosition) {
  std::mt19937 random(1);
  for (const Index3& dims : kLong) {
    for (const int triangles : {3, 20}) {
      const TriangleSoup soup = random_soup(
          triangles, random, [&](int axis) { return uniform(random, -3, static_cast<double>(dims[axis]) + 3); });
      expect_as_twin_with_all_options(soup, frame_of(dims));
    }
  }
}

TEST(VoxelizeTwin, CornersAtVoxelCentresAndFaces) {
  // Half-integer coordinates: rays through vertices and edges, crossings exactly at centres, edge-on triangles.
  std::mt19937 random(2);
  for (const Index3& dims : kLong) {
    for (const int triangles : {4, 30}) {
      const TriangleSoup soup = random_soup(triangles, random, [&](int axis) {
        return 0.5 * static_cast<double>(random() % static_cast<std::uint64_t>(2 * dims[axis] + 5)) - 1;
      });
      expect_as_twin_with_all_options(soup, frame_of(dims));
    }
  }
}

TEST(VoxelizeTwin, PlanesWithinALatticeStepOfVoxelCentres) {
  // Corners within three lattice steps of centres: depths that doubles cannot be trusted with, and slivers.
  std::mt19937 random(3);
  for (const Index3& dims : {Index3(9, 8, 7), Index3(66, 3, 3)}) {
    const TriangleSoup soup = random_soup(40, random, [&](int axis) {
      return 0.5 + static_cast<double>(random() % static_cast<std::uint64_t>(dims[axis])) +
             (static_cast<double>(random() % 7) - 3) * 0x1p-16;
    });
    expect_as_twin_with_all_options(soup, frame_of(dims));
  }
}

TEST(VoxelizeTwin, SoupsFarLargerThanTheGrid) {
  // Corners up to 2^14 voxels away leave 2^-13 voxel of the lattice; most triangles are cut by all sides of the grid.
  std::mt19937 random(4);
  const GridFrame frame = frame_of({67, 9, 10}, Point(-3, 5, 2), 0.25);
  const TriangleSoup soup = random_soup(40, random, [&](int) { return uniform(random, -4000, 4000); });
  expect_as_twin_with_all_options(soup, frame);
}

TEST(VoxelizeTwin, AllDirections) {
  std::mt19937 random(5);
  for (const bool snapped : {false, true}) {
    const Index3 dims(67, 6, 18);
    const TriangleSoup soup = random_soup(25, random, [&](int axis) {
      const double value = uniform(random, -1, static_cast<double>(dims[axis]) + 1);
      return snapped ? 0.5 * std::round(2 * value) : value;
    });
    expect_as_twin_with_all_options(soup, frame_of(dims), true);
  }
}

TEST(VoxelizeTwin, FewBoundaryEdgesInAllDirections) {
  // So few that oblique parities are derived from those along x: single triangles, all of them boundary; the corner of
  // a box on voxel centres, with rays over edges and vertices; a closed surface with a hole, and without.
  std::mt19937 random(7);
  const Index3 dims(40, 16, 14);
  std::vector<TriangleSoup> soups;
  for (const bool snapped : {false, true}) {
    soups.push_back(random_soup(6, random, [&](int axis) {
      const double value = uniform(random, -2, static_cast<double>(dims[axis]) + 2);
      return snapped ? 0.5 * std::round(2 * value) : value;
    }));
  }
  soups.push_back(box(Point(3.5, 4.5, 5.5), Point(30.5, 12.5, 10.5)));
  soups.push_back(soups.back());
  soups.back().triangles.resize(7);
  soups.push_back(icosphere(Point(20, 8, 7), 6.3, 1));
  soups.push_back(soups.back());
  soups.back().triangles.resize(70);
  for (const TriangleSoup& soup : soups) {
    RunContext context;
    const GridFrame frame = frame_of(dims);
    const LatticeSoup lattice(soup, frame, context);
    EXPECT_TRUE(Curtains(soup, lattice).pay_off(dims));
    for (const int sweeps : {0, 4}) expect_as_twin(soup, frame, {.directions = 13, .settle_sweeps = sweeps});
  }
}

TEST(VoxelizeTwin, TheOrderOfTrianglesAndUnusedVerticesChangeNothing) {
  std::mt19937 random(6);
  const GridFrame frame = frame_of({40, 21, 19});
  TriangleSoup soup = random_soup(50, random, [&](int) { return uniform(random, -1, 40); });
  RunContext context;
  const BinaryVolume volume = voxelize(soup, frame, {}, context);
  std::ranges::reverse(soup.triangles);
  soup.positions.push_back(Point::Constant(1e9));  // would make the lattice coarser if it counted
  EXPECT_EQ(voxelize(soup, frame, {}, context), volume);
}

TEST(VoxelizeTwin, RefusesASoupThatReachesTooFarBeyondTheGrid) {
  TriangleSoup soup;
  soup.positions = {Point(0, 0, 0), Point(0x1p29, 0, 0), Point(0, 1, 1)};
  soup.triangles = {{0, 1, 2}};
  RunContext context;
  EXPECT_THROW(voxelize(soup, frame_of({4, 4, 4}), {}, context), InputError);
}

}  // namespace
}  // namespace voxcarve
