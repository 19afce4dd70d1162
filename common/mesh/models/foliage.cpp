// pine and elm: stand-ins for the foliage of [HE10, Table 1, Fig. 14]. Leaves and needles are open
// sheets of one layer; wood is closed. Nothing is joined: every leaf, needle and branch is a component of its own.
//
// The counts follow from the paper's. An elm leaf has 8 vertices and 8 faces, a needle 6 and 4, a branch 5 sides x 4
// rings + 2 poles = 22 and 40. A stem with 9 boughs of 6 twigs makes 64 branches, and then
//     pine: 7,393 pairs of needles: 64 * 22 + 14,786 * 6 = 90,124 vertices, 64 * 40 + 14,786 * 4 = 61,704 faces;
//     elm:  749 leaves:             64 * 22 + 749 * 8    =  7,400 vertices, 64 * 40 + 749 * 8    =  8,552 faces.
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/growth.h"
#include "common/mesh/models/leaves.h"
#include "common/mesh/models/tubes.h"

namespace voxcarve {

namespace {

using std::numbers::pi;

Point any_perpendicular(const Point& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().minCoeff(&axis);
  return direction.cross(Point(Point::Unit(axis))).normalized();
}

// --- branches ----------------------------------------------------------------------------------------------------

constexpr int kBranchSides = 5;
constexpr int kBranchRings = 4;

/// How a stem, its boughs and their twigs grow. The stem is about 1 long and stands along z.
struct Habit {
  double bough_angle;   ///< of the lowest bough from the stem, in degrees; the top one has half of it
  double bough_length;  ///< of the lowest bough; the top one has 0.4 of it
  double twig_angle;    ///< from the bough, in degrees
  double twig_length;   ///< of the first twig, as a share of the bough's
  double stem_radius;
};

/// One branch: a curve from its start, thick there and thin at the end.
struct Branch {
  std::vector<Point> path;  ///< pole, rings, pole
  double radius;
  double end_radius;
  bool bears_leaves;

  double length() const {
    double sum = 0;
    for (std::size_t i = 1; i < path.size(); ++i) sum += (path[i] - path[i - 1]).norm();
    return sum;
  }
  /// The point after that share of the length.
  Point at(double share) const {
    double rest = share * length();
    std::size_t i = 1;
    for (; i + 1 < path.size() && rest > (path[i] - path[i - 1]).norm(); ++i) rest -= (path[i] - path[i - 1]).norm();
    return path[i - 1] + rest * (path[i] - path[i - 1]).normalized();
  }
  Point direction(double share) const {
    return (at(std::min(share + 0.05, 1.0)) - at(std::max(share - 0.05, 0.0))).normalized();
  }
  double radius_at(double share) const { return radius + share * (end_radius - radius); }
};

/// From `start` along `direction`, bending by `bend` of its length towards `towards` at the end.
Branch curved_branch(const Point& start, const Point& direction, const Point& towards, double bend, double length,
                     double radius, bool bears_leaves) {
  Branch branch{{}, radius, 0.4 * radius, bears_leaves};
  for (int i = 0; i <= kBranchRings + 1; ++i) {
    // The first and last rings stand close to the poles: blunt ends.
    const double share = std::clamp((i - 0.9) / (kBranchRings - 0.8), 0.0, 1.0);
    branch.path.emplace_back(start + length * (share * direction + bend * share * share * towards));
  }
  return branch;
}

TriangleSoup wood(const Branch& branch) {
  const Point reference = any_perpendicular((branch.path.back() - branch.path.front()).normalized());
  const auto half_axes = [&](double share) { return HalfAxes{branch.radius_at(share), branch.radius_at(share)}; };
  return loft(spindle_rings(branch.path, reference, half_axes, kBranchSides));
}

/// Where a branch starts that leaves `parent` at `share` in `direction`: just outside its bark.
Point start_of(const Branch& parent, double share, const Point& direction, double radius) {
  const double cosine = parent.direction(share).dot(direction);
  const double sine = parent.direction(share).cross(direction).norm();
  return parent.at(share) + (1.05 * parent.radius_at(share) + cosine * radius) / sine * direction;
}

/// Grows the branches and their wood, as many as `branch_parameters` say, stem first, each bough followed by its twigs.
/// Twigs stand alternately on both sides of their bough, in a plane about level: the flat sprays of elms, and of pines'
/// lower boughs.
std::vector<Branch> grow_branches(const Habit& habit, const Parameters& parameters, SeededSequence& random,
                                  FreeSpace& space, TriangleSoup& soup) {
  const auto boughs = static_cast<int>(parameters.integer("boughs"));
  const auto twigs = static_cast<int>(parameters.integer("twigs"));
  std::vector<Branch> branches;
  const auto grow = [&](const std::function<Branch(double crowding)>& make) {
    Branch branch;
    append(soup, space.place([&](double crowding) { return wood(branch = make(crowding)); }, kLeafAttempts));
    branches.push_back(branch);
    return branch;
  };
  const Branch stem = grow([&](double) {
    return curved_branch(Point::Zero(), Point::UnitZ(), Point::UnitX(), 0.08, 1, habit.stem_radius, false);
  });
  for (int i = 0; i < boughs; ++i) {
    const double height = boughs > 1 ? static_cast<double>(i) / (boughs - 1) : 0;
    const Branch bough = grow([&](double crowding) {
      const double azimuth = i * kGoldenAngle + random.uniform(-0.2, 0.2) * (1 + 4 * crowding);
      const double angle = radians(habit.bough_angle * (1 - 0.5 * height) + random.uniform(-4, 4));
      const Point side(std::cos(azimuth), std::sin(azimuth), 0);
      const Point direction = turned(Point::UnitZ(), side, angle);
      const double radius = 0.5 * stem.radius_at(height);
      const double share = 0.25 + 0.7 * height;
      return curved_branch(start_of(stem, share, direction, radius), direction, Point::UnitZ(), 0.15,
                           habit.bough_length * (1 - 0.6 * height), radius, true);
    });
    const double length = bough.length();
    for (int j = 0; j < twigs; ++j) {
      grow([&](double crowding) {
        const double share = 0.25 + 0.62 * (j + random.uniform(-0.2, 0.2)) / std::max(1, twigs - 1);
        const double rise = random.uniform(-0.1, 0.15) * (1 + 4 * crowding);
        const Point along = bough.direction(share);
        const Point level = Point::UnitZ().cross(along).normalized() * (j % 2 == 0 ? 1 : -1);
        const Point upward = along.cross(level) * (j % 2 == 0 ? 1 : -1);
        const Point direction = (turned(along, level, radians(habit.twig_angle)) + rise * upward).normalized();
        const double radius = 0.5 * bough.radius_at(share);
        return curved_branch(start_of(bough, share, direction, radius), direction, along, 0.1,
                             habit.twig_length * length * (1.15 - 0.6 * share) * (1 - 0.5 * crowding), radius, true);
      });
    }
  }
  return branches;
}

double branch_count(const Parameters& parameters) {
  return 1 + static_cast<double>(parameters.integer("boughs")) * (1 + static_cast<double>(parameters.integer("twigs")));
}

double branch_triangles(const Parameters& parameters) {
  return branch_count(parameters) * 2 * kBranchSides * kBranchRings;
}

/// Calls `place(branch, share of its length, number of the organ)` for `count` organs, spread evenly over the length of
/// all branches that bear leaves.
void spread_over(const std::vector<Branch>& branches, std::int64_t count,
                 const std::function<void(const Branch& branch, double share, std::int64_t number)>& place) {
  double total = 0;
  for (const Branch& branch : branches) total += branch.bears_leaves ? branch.length() : 0;
  double passed = 0;
  std::int64_t number = 0;
  for (std::size_t i = 0; i < branches.size(); ++i) {
    if (!branches[i].bears_leaves) continue;
    const double length = branches[i].length();
    const bool is_last = i + 1 == branches.size();
    for (; number < count; ++number) {
      const double position = (static_cast<double>(number) + 0.5) / static_cast<double>(count) * total;
      if (position > passed + length && !is_last) break;
      place(branches[i], std::min((position - passed) / length, 1.0), number);
    }
    passed += length;
  }
}

// --- pine --------------------------------------------------------------------------------------------------------

constexpr Habit kPineHabit = {
    .bough_angle = 75, .bough_length = 0.75, .twig_angle = 45, .twig_length = 0.42, .stem_radius = 0.02};

/// Two quads, bent in the middle.
TriangleSoup needle(const Point& base, const Point& direction, const Point& across, const Point& bend, double length,
                    double width) {
  std::vector<std::vector<Point>> rows;
  for (const auto& [share, half_width] : {std::array{0.0, 0.4}, {0.5, 0.5}, {1.0, 0.15}}) {
    const Point middle = base + length * (share * direction + 0.12 * share * share * bend);
    rows.push_back({middle - half_width * width * across, middle + half_width * width * across});
  }
  return strip(rows);
}

/// Pairs of needles around every bough and shoot, pointing forward.
TriangleSoup build_pine(const Parameters& parameters) {
  SeededSequence random(static_cast<std::uint64_t>(parameters.integer("seed")));
  const double length = parameters.real("needle_length");
  const double width = parameters.real("needle_width");
  FreeSpace space(0.5 * length);
  TriangleSoup pine;
  const std::vector<Branch> branches = grow_branches(kPineHabit, parameters, random, space, pine);
  spread_over(branches, parameters.integer("pairs"), [&](const Branch& branch, double share, std::int64_t number) {
    const Point along = branch.direction(share);
    const Point side = any_perpendicular(along);
    for (const double half : {-1.0, 1.0}) {
      append(pine, space.place(
                       [&](double crowding) {
                         const double azimuth = static_cast<double>(number) * kGoldenAngle +
                                                random.uniform(-0.6, 0.6) * (1 + 4 * crowding);
                         const Point outward = turned(side, along.cross(side), azimuth);
                         const Point tangent = along.cross(outward);
                         const double angle = radians(42 + random.uniform(-12, 18) * (1 + crowding) - 20 * share);
                         const Point direction = (turned(along, outward, angle) + half * 0.14 * tangent).normalized();
                         const Point base = branch.at(share) + (1.2 * branch.radius_at(share) + width) * outward +
                                            half * 0.7 * width * tangent;
                         return needle(base, direction, direction.cross(outward).normalized(), along,
                                       length * random.uniform(0.75, 1) * (1 - 0.5 * crowding), width);
                       },
                       kLeafAttempts));
    }
  });
  return pine;
}

// --- elm ---------------------------------------------------------------------------------------------------------

constexpr Habit kElmHabit = {
    .bough_angle = 65, .bough_length = 0.8, .twig_angle = 48, .twig_length = 0.5, .stem_radius = 0.025};

/// A leaf of eight faces, folded along its midrib and pointed at both ends; `upward` is perpendicular to `direction`.
TriangleSoup oval_leaf(const Point& base, const Point& direction, const Point& upward, double length, double width) {
  const Point across = direction.cross(upward);
  std::vector<std::vector<Point>> rows = {{base}};
  for (const auto& [share, half_width] : {std::array{0.3, 0.46}, {0.65, 0.4}}) {
    const Point rib = base + length * (share * direction - 0.15 * share * share * upward);
    const Point rise = 0.25 * half_width * width * upward;
    rows.push_back({rib - half_width * width * across + rise, rib, rib + half_width * width * across + rise});
  }
  rows.push_back({base + length * (direction - 0.15 * upward)});
  return strip(rows);
}

/// Leaves in two ranks along every bough and twig, about level.
TriangleSoup build_elm(const Parameters& parameters) {
  SeededSequence random(static_cast<std::uint64_t>(parameters.integer("seed")));
  const double length = parameters.real("leaf_length");
  FreeSpace space(length);
  TriangleSoup elm;
  const std::vector<Branch> branches = grow_branches(kElmHabit, parameters, random, space, elm);
  spread_over(branches, parameters.integer("leaves"), [&](const Branch& branch, double share, std::int64_t number) {
    const double rank = number % 2 == 0 ? 1 : -1;
    append(elm, space.place(
                    [&](double crowding) {
                      const Point along = branch.direction(share);
                      const Point level = rank * Point::UnitZ().cross(along).normalized();
                      const Point upward = rank * along.cross(level);
                      const double roll = random.uniform(-0.5, 0.5) * (1 + 2 * crowding);
                      const Point outward = turned(level, upward, roll);
                      const double size = length * (1 - 0.4 * crowding);
                      const double angle = radians(55 + random.uniform(-15, 15) * (1 + crowding));
                      const Point direction = turned(along, outward, angle);
                      const Point facing = along.cross(outward) * rank;
                      const Point base = branch.at(share) + (1.5 * branch.radius_at(share) + 0.1 * length) * outward;
                      return oval_leaf(base, direction, facing, size * random.uniform(0.8, 1.1), 0.5 * size);
                    },
                    kLeafAttempts));
  });
  return elm;
}

std::vector<ParameterSpec> branch_parameters() {
  return {seed_parameter(), ParameterSpec::integer("boughs", "branches", 1, 1000, 9, "branches on the stem"),
          ParameterSpec::integer("twigs", "branches", 1, 1000, 6, "branches on each bough")};
}

}  // namespace

ProceduralModel pine_model() {
  ModelInfo info{"pine",
                 "a branching shoot full of needles, each an open strip of its own, on closed wood",
                 "HE Fig. 14, Table 1 (90,125 vertices, 61,700 faces, 151 hull vertices)",
                 {}};
  info.parameters.specs = branch_parameters();
  info.parameters.specs.push_back(
      ParameterSpec::integer("pairs", "pairs", 0, 1'000'000, 7'393, "pairs of needles, of 12 vertices and 8 faces"));
  info.parameters.specs.push_back(
      ParameterSpec::real("needle_length", "model", 1e-3, 1, 0.07, "of the longest needles; the stem is 1 long"));
  info.parameters.specs.push_back(
      ParameterSpec::real("needle_width", "model", 1e-5, 0.1, 0.0025, "of a needle at its widest"));
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit("pine",
                                   branch_triangles(parameters) + 8 * static_cast<double>(parameters.integer("pairs")));
  };
  return {std::move(info), build_pine};
}

ProceduralModel elm_model() {
  ModelInfo info{"elm",
                 "leaves in flat sprays on branches: open sheets on closed wood, a component each",
                 "HE Table 1 (7,401 vertices, about 8,500 faces, 91 hull vertices)",
                 {}};
  info.parameters.specs = branch_parameters();
  info.parameters.specs.push_back(
      ParameterSpec::integer("leaves", "leaves", 0, 1'000'000, 749, "leaves, of 8 vertices and 8 faces"));
  info.parameters.specs.push_back(
      ParameterSpec::real("leaf_length", "model", 1e-3, 1, 0.075, "of a leaf; the stem is 1 long"));
  info.parameters.check = [](const Parameters& parameters) {
    require_triangles_within_limit(
        "elm", branch_triangles(parameters) + 8 * static_cast<double>(parameters.integer("leaves")));
  };
  return {std::move(info), build_elm};
}

}  // namespace voxcarve
