#include "methods/hagbi_elsana/level_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>

#include "common/mesh/models/primitives.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

/// What CarvingStream::extract says, word by word: every side is glued to the one that bounds the same wedge of the
/// outside, whether its edge has more than two sides or not, and fans are followed around anew whenever they are asked
/// for.
class SlowSurface {
 public:
  SlowSurface(const CarvingStream& stream, std::uint32_t step)
      : mesh_(stream.complement()), solid_{mesh_, stream.steps(), step} {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> faces;  // in the order in which they come
    for (std::uint32_t t = 0; t < mesh_.size(); ++t) {
      for (std::uint32_t i = 0; i < 4 && stream.steps()[t] <= step; ++i) {
        if (solid_.ends_at(t, static_cast<int>(i))) faces.emplace_back(stream.steps()[t], 4 * t + i);
      }
    }
    std::ranges::sort(faces);
    for (const auto& [born, face] : faces) {
      place_[face] = static_cast<std::uint32_t>(faces_.size());
      faces_.push_back(face);
      for (const std::uint32_t point : mesh_.face(face / 4, static_cast<int>(face % 4))) point_.push_back(point);
    }
  }

  TriangleSoup run() {
    for (std::uint32_t side = 0; side < point_.size(); ++side) glued_.push_back(across_wedge(side));
    fan_.assign(point_.size(), kNone);
    for (std::uint32_t corner = 0; corner < point_.size(); ++corner) {
      if (fan_[corner] == kNone) number(corner);
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> sides_of;
    for (std::uint32_t side = 0; side < point_.size(); ++side) {
      if (point_[side] < point_[next(side)]) sides_of[{point_[side], point_[next(side)]}].push_back(side);
    }
    for (auto& [edge, sides] : sides_of) {
      while (cut_one(sides)) {
      }
    }
    TriangleSoup soup;
    soup.positions.resize(fans_);
    soup.triangles.resize(faces_.size());
    for (std::uint32_t corner = 0; corner < point_.size(); ++corner) {
      soup.positions[fan_[corner]] = mesh_.points[point_[corner]];
      soup.triangles[corner / 3][corner % 3] = fan_[corner];
    }
    return soup;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  static std::uint32_t next(std::uint32_t side) { return side / 3 * 3 + (side + 1) % 3; }

  std::uint32_t across_wedge(std::uint32_t side) const {
    const std::uint32_t u = point_[side];
    const std::uint32_t w = point_[next(side)];
    std::uint32_t t = faces_[side / 3] / 4;
    std::uint32_t behind = faces_[side / 3] % 4;  // the face through which the tetrahedron was entered
    for (;;) {
      std::uint32_t ahead = kNone;  // the other one with the edge
      for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t corner = mesh_.corners[t][i];
        if (i != behind && corner != u && corner != w) ahead = i;
      }
      if (solid_.ends_at(t, static_cast<int>(ahead))) {
        std::uint32_t twin = 3 * place_.at(4 * t + ahead);
        while (point_[twin] != w) ++twin;
        EXPECT_EQ(point_[next(twin)], u);
        return twin;
      }
      const std::uint32_t beyond = mesh_.neighbors[t][ahead];
      const auto& back = mesh_.neighbors[beyond];
      behind = static_cast<std::uint32_t>(std::ranges::find(back, t) - back.begin());
      t = beyond;
    }
  }

  std::vector<std::uint32_t> around(std::uint32_t corner) const {
    std::vector<std::uint32_t> corners;
    std::uint32_t at = corner;
    do {
      corners.push_back(at);
      at = next(glued_[at]);
    } while (at != corner);
    return corners;
  }

  void number(std::uint32_t corner) {
    for (const std::uint32_t at : around(corner)) fan_[at] = fans_;
    ++fans_;
  }

  bool cut_one(std::vector<std::uint32_t>& sides) {
    const auto key = [&](std::uint32_t side) { return std::tuple(fan_[side], fan_[next(side)], side); };
    std::ranges::sort(sides, {}, key);
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const std::uint32_t one = sides[i - 1];
      const std::uint32_t other = sides[i];
      if (fan_[one] != fan_[other] || fan_[next(one)] != fan_[next(other)]) continue;
      std::swap(glued_[one], glued_[other]);
      glued_[glued_[one]] = one;
      glued_[glued_[other]] = other;
      number(around(one).size() <= around(other).size() ? one : other);
      number(around(next(one)).size() <= around(next(other)).size() ? next(one) : next(other));
      return true;
    }
    return false;
  }

  const Complement& mesh_;
  CarvedSolid solid_;
  std::vector<std::uint32_t> faces_;
  std::map<std::uint32_t, std::uint32_t> place_;
  std::vector<std::uint32_t> point_;  ///< by corner
  std::vector<std::uint32_t> glued_;  ///< by side, which has the number of the corner that it starts in
  std::vector<std::uint32_t> fan_;    ///< by corner
  std::uint32_t fans_ = 0;
};

/// A disc of triangles around one point: with its other side, a fan of twice as many triangles as it has slices.
TriangleSoup disc(std::uint32_t slices) {
  TriangleSoup soup;
  soup.positions.emplace_back(0, 0, 0.3);
  for (std::uint32_t i = 0; i < slices; ++i) {
    const double angle = 2 * 3.14159265358979 * i / slices;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0.05 * std::sin(5 * angle));
    soup.triangles.push_back({0, i + 1, (i + 1) % slices + 1});
  }
  return soup;
}

/// Pages that hang together in one edge.
TriangleSoup book(std::uint32_t pages) {
  TriangleSoup soup;
  soup.positions = {Point(0, 0, 0), Point(0, 0, 1)};
  for (std::uint32_t i = 0; i < pages; ++i) {
    const double angle = 2 * 3.14159265358979 * i / pages;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0.5 + 0.03 * i);
    soup.triangles.push_back({0, 1, i + 2});
  }
  return soup;
}

std::map<std::string, TriangleSoup> models() {
  const TriangleSoup cube = box(Point(0, 0, 0), Point(1, 1, 1));
  return {{"torus", torus(2, 0.7, 12, 6)},
          {"cubes that touch in an edge", test::joined({cube, box(Point(1, 1, 0), Point(2, 2, 1))})},
          {"cubes that touch in a vertex", test::joined({cube, box(Point(1, 1, 1), Point(2, 2, 2))})},
          {"balls that touch in a vertex of 60 triangles",
           test::joined({uv_sphere(Point(0, 0, 0), 1, 30, 5), uv_sphere(Point(0, 0, 2), 1, 30, 5)})},
          {"disc of 40", disc(40)},
          {"disc of 11", disc(11)},
          {"book", book(7)},
          {"soup", test::crossing_triangles(40, 7)},
          {"other soup", test::crossing_triangles(40, 11)}};
}

TEST(LevelSurface, IsWhatGluingEverySideByItsWedgeMakes) {
  int cut = 0;
  for (const auto& [name, model] : models()) {
    const CarvingStream stream = test::carved(model);
    for (std::uint32_t step = 0; step <= stream.last_step(); ++step) {
      const TriangleSoup surface = stream.extract(step);
      ASSERT_EQ(surface, SlowSurface(stream, step).run()) << name << ", step " << step;
      cut += surface.positions.size() > stream.vertices(step);
    }
  }
  EXPECT_GT(cut, 100);  // levels that had to be cut, of models made for it
}

TEST(LevelSurface, IsTheSameOnTwoThreads) {
  // Cut everywhere, and of more faces and singular vertices than a chunk has.
  TriangleSoup pages;
  for (std::uint32_t row = 0; row <= 60; ++row) {
    for (std::uint32_t column = 0; column <= 60; ++column) {
      pages.positions.emplace_back(0.1 * column, 0.1 * row + 0.01 * std::sin(3.0 * column),
                                   std::sin(0.13 * row * column));
    }
  }
  for (std::uint32_t row = 0; row < 60; ++row) {
    for (std::uint32_t column = 0; column < 60; ++column) {
      const std::uint32_t p = 61 * row + column;
      pages.triangles.push_back({p, p + 1, p + 62});
      pages.triangles.push_back({p, p + 62, p + 61});
    }
  }
  const CarvingStream stream = test::carved(pages);
  RunContext two;
  two.threads = 2;
  const TriangleSoup last = stream.extract(stream.last_step());
  EXPECT_EQ(last.triangles.size(), 2 * pages.triangles.size());
  for (const std::uint32_t step : {stream.last_step(), stream.last_step() / 2, 0U, stream.last_step()}) {
    EXPECT_EQ(stream.extract(step, &two), stream.extract(step)) << step;
  }
  EXPECT_EQ(stream.extract(stream.last_step()), last);  // whatever the workspace was used for in between
}

}  // namespace
}  // namespace voxcarve
