// Implicit solids as models, their building blocks, and the sphereflake.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "common/mesh/models/implicit_shapes.h"
#include "common/mesh/models/procedural.h"
#include "common/mesh/models/sphereflake.h"
#include "common/model.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "tests/unit/implicit_checks.h"

namespace voxcarve {
namespace {

using namespace test;
using std::numbers::pi;
using testing::HasSubstr;

ImplicitSolid solid_from(const std::string& spec) {
  std::optional<ImplicitSolid> solid = make_implicit(spec);
  if (!solid) throw InputError(spec + " is no solid");
  return *solid;
}

// --- as models ---------------------------------------------------------------------------------------------------

template <class Error, class Function>
std::string message_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no such error";
}

TEST(ImplicitModels, AreOpenedByTheirForm) {
  std::vector<std::string> notices;
  for (const std::string name : {"bolt", "mechanical-part", "sphereflake"}) {
    const Model solid = open_model("model:" + name + "?form=implicit", {}, notices);
    EXPECT_EQ(solid.kind(), ModelKind::kImplicitSolid);
    EXPECT_EQ(solid.name, name);
    EXPECT_TRUE(std::get<ImplicitSolid>(solid.shape).clearance);
    EXPECT_FALSE(make_implicit(name));
    EXPECT_FALSE(make_implicit(name + "?form=mesh"));
  }
  EXPECT_EQ(open_model("model:sphereflake?depth=0", {}, notices).kind(), ModelKind::kSoup);
  EXPECT_FALSE(make_implicit("torus"));
  EXPECT_TRUE(notices.empty());
}

TEST(ImplicitModels, HaveASchemaThatOffersTheForm) {
  std::set<std::string> with_solid;
  for (const ProceduralModel& model : procedural_models()) {
    EXPECT_EQ(static_cast<bool>(model.solid), model.info.parameters.find("form") != nullptr) << model.info.name;
    if (model.solid) with_solid.insert(model.info.name);
  }
  EXPECT_EQ(with_solid, (std::set<std::string>{"bolt", "mechanical-part", "sphereflake"}));
}

TEST(ImplicitModels, HaveNoTriangles) {
  EXPECT_THAT(message_of<ParameterError>([] { make_procedural("bolt?form=implicit"); }), HasSubstr("no triangles"));
  EXPECT_THAT(message_of<ParameterError>([] { make_implicit("bolt?form=solid"); }), HasSubstr("form"));
  EXPECT_THAT(message_of<ParameterError>([] { make_implicit("torus?form=implicit"); }), HasSubstr("form"));
  // So the limit on triangles does not hold: a depth of 6 means 597,871 balls.
  EXPECT_NO_THROW(solid_from("sphereflake?depth=6&subdivision=8&form=implicit"));
  std::vector<std::string> notices;
  const Model model = open_model("model:bolt?form=implicit", {}, notices);
  RunContext context;
  EXPECT_THAT(message_of<InputError>([&] { reference_surface(model, context); }), HasSubstr("form=mesh"));
}

TEST(ImplicitModels, AreValidated) {
  const auto inside = [](const Point&) { return true; };
  const auto message = [](const ImplicitSolid& solid) {
    return message_of<InputError>([&] { validate(Model{"x", solid}); });
  };
  const Point zero = Point::Zero();
  EXPECT_NO_THROW(validate(Model{"x", ImplicitSolid{inside, {zero, Point::Ones()}}}));
  EXPECT_THAT(message({nullptr, {zero, Point::Ones()}}), HasSubstr("membership"));
  EXPECT_THAT(message({inside, {}}), HasSubstr("empty box"));
  EXPECT_THAT(message({inside, {zero, zero}}), HasSubstr("no extent"));
  EXPECT_THAT(message({inside, {zero, Point(1, 1, std::numeric_limits<double>::infinity())}}), HasSubstr("not finite"));
}

// --- building blocks ---------------------------------------------------------------------------------------------

TEST(ImplicitShapes, TurnsAreThoseOfTheAngle) {
  EXPECT_EQ(turns_of(1, 0), 0);
  EXPECT_EQ(turns_of(1, 1), 0.125);
  EXPECT_EQ(turns_of(0, 2), 0.25);
  EXPECT_EQ(turns_of(-3, 3), 0.375);
  EXPECT_EQ(turns_of(-1, 0), 0.5);
  EXPECT_EQ(turns_of(-1, -1), 0.625);
  EXPECT_EQ(turns_of(0, -1), 0.75);
  EXPECT_EQ(turns_of(5, -5), 0.875);
  RandomPoints random(1);
  double worst = 0;
  for (int i = 0; i < case_count(200'000); ++i) {
    const Point p = random.in({Point::Constant(-1), Point::Constant(1)});
    const double angle = std::atan2(p.y(), p.x()) / (2 * pi);
    worst = std::max(worst, std::abs(turns_of(p.x(), p.y()) - (angle < 0 ? angle + 1 : angle)));
  }
  EXPECT_LT(worst, 4e-16);  // four roundings of a number below 1
}

TEST(ImplicitShapes, ClearancesAreDistances) {
  const Box box{Point(-1, -2, -3), Point(1, 2, 3)};
  EXPECT_EQ(box_clearance({4, 6, 15}, box), 13);  // 3, 4, 12 off a corner
  EXPECT_EQ(box_clearance({-4, 6, 0}, box), 5);   // off an edge
  EXPECT_EQ(box_clearance({0, 0, 4}, box), 1);
  EXPECT_EQ(box_clearance({0.25, 0.5, 0}, box), -0.75);
  // A slot along z, 2 long between the centres of its ends, from y = -1 to 1.
  const RoundPrism slot{1, {5, 7}, 1, 3, -1, 1};  // axis y: u is z, v is x
  EXPECT_EQ(slot.clearance({7, 0, 5}), -1);       // the nearest is an end
  EXPECT_EQ(slot.clearance({7, 0.75, 5}), -0.25);
  EXPECT_EQ(slot.clearance({15, 5, 5}), std::sqrt(16.0 + 16.0));  // 7 beyond the end's centre, 4 above
  EXPECT_EQ(slot.clearance({7.5, 0, 8}), 0);
  EXPECT_EQ(slot.clearance({11, 0, 9}), 2);  // 3, 4 off the centre of an end
  EXPECT_EQ(slot.bounds().lower, Point(3, -1, 2));
  EXPECT_EQ(slot.bounds().upper, Point(11, 1, 8));
}

TEST(ImplicitShapes, GuardedClearanceIsLessThanWhatItGuards) {
  EXPECT_EQ(guarded_clearance(1e-13, 1), 0);
  for (const double clearance : {-2.0, -1e-3, 1e-3, 2.0, 1e9}) {
    const double guarded = guarded_clearance(clearance, 1);
    EXPECT_LT(guarded, std::abs(clearance));
    EXPECT_NEAR(guarded, std::abs(clearance), 2e-12 * (1 + std::abs(clearance)));
  }
}

// --- sphereflake -------------------------------------------------------------------------------------------------

bool slow_inside(const Sphereflake& flake, const Point& p) {
  return std::ranges::any_of(flake.balls(), [&](const auto& ball) { return ball.holds(p); });
}

double slow_clearance(const Sphereflake& flake, const Point& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Sphereflake::Ball& ball : flake.balls()) least = std::min(least, (p - ball.center).norm() - ball.radius);
  return least;
}

TEST(Sphereflakes, BallsAreThoseOfTheMesh) {
  const Sphereflake flake(3, 2.5);
  const TriangleSoup mesh = make_procedural("sphereflake?radius=2.5&subdivision=0");
  ASSERT_EQ(flake.balls().size(), 820U);
  ASSERT_EQ(mesh.positions.size(), 820U * 12);
  // The 12 vertices of each icosahedron are on its sphere.
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Sphereflake::Ball& ball = flake.balls()[i / 12];
    EXPECT_NEAR((mesh.positions[i] - ball.center).norm(), ball.radius, 1e-14);
  }
}

TEST(Sphereflakes, PruningChangesNothing) {
  for (const int depth : {0, 1, 2, 3}) {
    const Sphereflake flake(depth, 1);
    const ImplicitSolid solid = implicit_solid(flake);
    std::vector<Point> points = probes(solid, case_count(3000U), 1);
    // Points of contact, and beside them.
    RandomPoints random(2);
    for (std::size_t child = 1; child < flake.balls().size(); ++child) {
      const Sphereflake::Ball& ball = flake.balls()[child];
      const Sphereflake::Ball& parent = flake.balls()[(child - 1) / 9];
      const Point contact = parent.center + parent.radius * (ball.center - parent.center).normalized();
      points.push_back(contact);
      for (const double distance : {1e-15, 1e-9, 1e-3, 0.02})
        points.emplace_back(contact + distance * random.direction());
    }
    for (const Point& p : points) {
      ASSERT_EQ(flake.inside(p), slow_inside(flake, p)) << p.transpose();
      ASSERT_NEAR(flake.signed_clearance(p), slow_clearance(flake, p), 1e-14) << p.transpose();
    }
  }
}

TEST(Sphereflakes, HaveAValidClearanceAndATightBox) {
  const ImplicitSolid solid = solid_from("sphereflake?form=implicit");
  expect_clearance_is_valid(solid, case_count(20'000U));
  expect_box_holds(solid, case_count(20'000U));
  const Sphereflake flake(3, 1);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      // A ball reaches the side.
      double reach = -std::numeric_limits<double>::infinity();
      for (const Sphereflake::Ball& ball : flake.balls()) {
        reach = std::max(reach, sign * ball.center[axis] + ball.radius);
      }
      EXPECT_EQ(sign * (sign < 0 ? solid.box.lower : solid.box.upper)[axis], reach);
    }
  }
  // Half a turn about z and six children around the equator: z runs from -1, the root, up.
  EXPECT_EQ(solid.box.lower.z(), -1);
}

TEST(Sphereflakes, HaveTheVolumeOfTheirBalls) {
  // 9 balls of 1/27 of the volume a generation: 1 + 1/3 + 1/9 + 1/27 = 40/27.
  expect_volume(solid_from("sphereflake?radius=2&form=implicit"), 4.0 / 3 * pi * 8 * 40 / 27, case_count(400'000U));
}

TEST(Sphereflakes, SurfaceAgreesWithTheBalls) {
  // An icosahedron's edges are 1.0515 of its radius; halved four times they are about 1.2 / 16 at most, and a triangle
  // of that size, 0.043 from centre to corner, lies below its sphere by 0.043^2 / 2 < 0.001.
  expect_surface_agrees(solid_from("sphereflake?depth=2&form=implicit"),
                        make_procedural("sphereflake?depth=2&subdivision=4"), 0.001, case_count(4000U));
}

}  // namespace
}  // namespace voxcarve
