// The model bolt: its thread by definition, its volume in closed form, and that its two forms are one solid.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/unit/implicit_checks.h"
#include "tests/unit/model_checks.h"

namespace voxcarve {
namespace {

using namespace test;

/// The defaults: diameter 1, pitch 0.16, ten turns, a shank of 0.6, and a head of 1.6 by 0.65.
constexpr double kPitch = 0.16;
constexpr double kThread = 1.6;
constexpr double kShaft = 2.2;
constexpr double kTotal = 2.85;
const double kDepth = 0.625 * std::sqrt(0.75) * kPitch;  // ISO 68-1: 5/8 H, H = sqrt(3) / 2 pitch
const double kRoot = 0.5 - kDepth;

/// The thread's radius where the distance from the middle of a crest is `offset` pitches, up to 1/2: a crest of 1/8, a
/// root of 1/4, and straight flanks between.
double thread_radius(double offset) {
  if (offset <= 1.0 / 16) return 0.5;
  if (offset >= 3.0 / 8) return kRoot;
  return 0.5 - kDepth * (offset - 1.0 / 16) / (5.0 / 16);
}

/// By the mathematics library's angle.
double shaft_radius(const Point& p) {
  const double phase = p.z() / kPitch - std::atan2(p.y(), p.x()) / (2 * pi);
  const double thread = thread_radius(std::abs(phase - std::round(phase)));
  const double cut = std::min(thread, kRoot + p.z());
  return std::min(0.5, std::max(cut, 0.5 - (kThread - p.z())));
}

bool slow_inside(const Point& p) {
  if (p.z() < 0 || p.z() > kTotal) return false;
  if (p.z() <= kShaft) return std::hypot(p.x(), p.y()) <= shaft_radius(p);
  for (int side = 0; side < 6; ++side) {
    const double angle = pi / 6 + side * pi / 3;
    if (std::cos(angle) * p.x() + std::sin(angle) * p.y() > 0.8) return false;
  }
  return true;
}

TEST(Bolt, IsWhatItsFormulaSays) {
  const ImplicitSolid solid = *make_implicit("bolt?form=implicit");
  RandomPoints random(1);
  const Box shaft{Point(-0.55, -0.55, -0.05), Point(0.55, 0.55, kShaft)};
  std::size_t different = 0;
  for (int i = 0; i < case_count(300'000); ++i) {
    const Point p = random.in(i % 2 == 0 ? shaft : solid.box);
    // Rounding decides at the boundary.
    if (p.z() <= kShaft && std::abs(std::hypot(p.x(), p.y()) - shaft_radius(p)) < 1e-13) continue;
    different += solid.inside(p) != slow_inside(p) ? 1 : 0;
  }
  EXPECT_EQ(different, 0U);
}

TEST(Bolt, ThreadIsRightHanded) {
  const ImplicitSolid solid = *make_implicit("bolt?form=implicit");
  // The middle of a crest is at x = 0.5, z = 0.8, and climbs a quarter of the pitch to y = 0.5.
  EXPECT_TRUE(solid.inside({0.499, 0, 0.8}));
  EXPECT_TRUE(solid.inside({0, 0.499, 0.84}));
  EXPECT_TRUE(solid.inside({-0.499, 0, 0.88}));
  EXPECT_FALSE(solid.inside({0, 0.499, 0.76}));
  EXPECT_FALSE(solid.inside({0.499, 0, 0.88}));  // over a root
  EXPECT_TRUE(solid.inside({kRoot - 1e-9, 0, 0.88}));
  EXPECT_FALSE(solid.inside({kRoot + 1e-9, 0, 0.88}));
}

TEST(Bolt, IsClosedAndCoversTheNamedTriangles) {
  for (const std::string spec : {"bolt", "bolt?turns=2&shank=0", "bolt?turns=3&pitch=0.4&detail=2&diameter=8"}) {
    const TriangleSoup soup = make_procedural(spec);
    expect_closed(soup, spec);
    EXPECT_TRUE(has_single_fans(soup)) << spec;
    ASSERT_EQ(parts_of(soup).size(), 1U) << spec;
    EXPECT_EQ(genus_of(soup), 0) << spec;
  }
  // 480 belts of thread, one of shank, the head's underside and its sides; 46 and 48 at the ends.
  EXPECT_EQ(make_procedural("bolt").triangles.size(), 96U * 483 + 46 + 48);
  EXPECT_EQ(make_procedural("bolt?shank=0").triangles.size(), 96U * 482 + 46 + 48);
}

/// Of the defaults. A plane's section of a thread has pi times the mean of the squared radius over a turn, which is
/// that over a pitch; where it is cut, or runs out, at the share w of its depth, that is a cubic in w, which Simpson's
/// rule integrates exactly.
double bolt_volume() {
  const double crest = 0.5;
  // The mean of (root + s depth)^2 over s from a to b, times b - a.
  const auto flank = [](double a, double b) {
    const auto antiderivative = [](double s) { return std::pow(kRoot + s * kDepth, 3) / (3 * kDepth); };
    return antiderivative(b) - antiderivative(a);
  };
  const auto whole = 0.125 * crest * crest + 0.25 * kRoot * kRoot + 0.625 * flank(0, 1);
  const auto at = [](double w) { return std::pow(kRoot + w * kDepth, 2); };
  const auto cut = [&](double w) {
    return (0.125 + 0.625 * (1 - w)) * at(w) + 0.25 * kRoot * kRoot + 0.625 * flank(0, w);
  };
  const auto run_out = [&](double w) {
    return (0.25 + 0.625 * w) * at(w) + 0.125 * crest * crest + 0.625 * flank(w, 1);
  };
  const auto simpson = [](const auto& f) { return (f(0.0) + 4 * f(0.5) + f(1.0)) / 6; };
  const double ends = kDepth * (simpson(cut) + simpson(run_out));
  const double shaft = pi * ((kThread - 2 * kDepth) * whole + ends + (kShaft - kThread) * crest * crest);
  return shaft + 2 * std::sqrt(3.0) * 0.8 * 0.8 * (kTotal - kShaft);  // a hexagon of apothem a has 2 sqrt(3) a^2
}

TEST(Bolt, HasItsVolume) {
  expect_volume(*make_implicit("bolt?form=implicit"), bolt_volume(), case_count(1'000'000U));
  // A polygon of n sides in a circle lacks about 2 pi^2 / (3 n^2) of its area, 1.8e-4 for 192; creases that run across
  // the edges, at the ends of the thread, are of the same order.
  const double volume = signed_volume(make_procedural("bolt?detail=4"));
  EXPECT_LT(volume, bolt_volume());
  EXPECT_NEAR(volume, bolt_volume(), 2e-4 * bolt_volume());
}

TEST(Bolt, FormsAgree) {
  // Chords are 0.5 (1 - cos(pi / 48)) = 0.0011 off the circle. At the ends of the thread, where creases run across the
  // triangles, these may be off by as much as the radius changes within one: a step of pitch / 48 up, of slope 1 + tan
  // 60, and one around, along which the thread climbs as much: 0.0033 * (1 + 2 * 1.732) = 0.0149.
  expect_surface_agrees(*make_implicit("bolt?form=implicit"), make_procedural("bolt"), 0.016, case_count(20'000U));
}

TEST(Bolt, HasAValidClearanceAndATightBox) {
  for (const std::string parameters : {"", "pitch=0.4&turns=2&shank=0&", "pitch=0.02&turns=40&diameter=300&"}) {
    SCOPED_TRACE(parameters);
    const ImplicitSolid solid = *make_implicit("bolt?" + parameters + "form=implicit");
    expect_clearance_is_valid(solid, case_count(20'000U));
    expect_box_holds(solid, case_count(20'000U));
    const Box mesh = bounds(make_procedural("bolt?" + parameters + "form=mesh"));
    EXPECT_LT((mesh.lower - solid.box.lower).norm(), 1e-14 * solid.box.diagonal());
    EXPECT_LT((mesh.upper - solid.box.upper).norm(), 1e-14 * solid.box.diagonal());
    // The hexagon's corners lie on the x axis, the middles of two of its sides on the y axis.
    const Point within = (1 - 1e-9) * solid.box.upper;
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_TRUE(solid.inside({sign * within.x(), 0, within.z()}));
      EXPECT_TRUE(solid.inside({0, sign * within.y(), within.z()}));
    }
    EXPECT_TRUE(solid.inside(Point::Zero()));
  }
}

}  // namespace
}  // namespace voxcarve
