// The models that are volumes and images: exact sizes and volumes, the statistics of the papers' tables, and their
// names beside those of all other models.
#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/models/catalogue.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "common/volume/labelling.h"
#include "common/volume/models/volume_models.h"
#include "common/volume/morphology.h"

namespace voxcarve {
namespace {

using testing::HasSubstr;

std::string parameter_error(const std::string& spec) {
  try {
    make_volume(spec);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no ParameterError";
}

std::vector<std::string> volume_model_names() {
  std::vector<std::string> names;
  for (const VolumeModel& model : volume_models()) names.push_back(model.info.name);
  return names;
}

// --- the registry ------------------------------------------------------------------------------------------------

TEST(VolumeModels, AreListedInOrder) {
  EXPECT_EQ(volume_model_names(), (std::vector<std::string>{"ball-cube", "cells", "galaxy", "landscape"}));
}

TEST(VolumeModels, ANameMeansOneModelOfAnyKind) {
  std::set<std::string> names;
  for (const VolumeModel& model : volume_models()) EXPECT_TRUE(names.insert(model.info.name).second);
  for (const ProceduralModel& model : procedural_models()) {
    EXPECT_TRUE(names.insert(model.info.name).second) << model.info.name;
  }
  for (const ExternalModel& model : external_models()) EXPECT_TRUE(names.insert(model.name).second) << model.name;
}

TEST(VolumeModels, UnknownNamesAreRefusedWithTheNearestOfAllKinds) {
  EXPECT_THAT(parameter_error("galaxi"), HasSubstr("'galaxi'; did you mean 'galaxy'?"));
  EXPECT_THAT(parameter_error("tors"), HasSubstr("did you mean 'torus'?"));                  // a mesh
  EXPECT_THAT(parameter_error("turbin_blade"), HasSubstr("did you mean 'turbine_blade'?"));  // an external one
  EXPECT_THAT(parameter_error("xyzzyxyzzy"), testing::EndsWith("no model is called 'xyzzyxyzzy'"));
  EXPECT_THAT(parameter_error("torus"), HasSubstr("'torus' is no volume or image model"));
  EXPECT_TRUE(is_volume_model("cells"));
  EXPECT_FALSE(is_volume_model("torus"));
}

TEST(VolumeModels, BadParametersAreRefused) {
  EXPECT_THAT(parameter_error("galaxy?sed=2"), HasSubstr("galaxy has no parameter 'sed'; did you mean 'seed'?"));
  EXPECT_THAT(parameter_error("cells?width=15"), HasSubstr("at least 16"));
  EXPECT_THAT(parameter_error("cells?height=4097"), HasSubstr("at most 4096"));
  EXPECT_THAT(parameter_error("landscape?seed=-1"), HasSubstr("at least 0"));
  EXPECT_THAT(parameter_error("ball-cube?side=2"), HasSubstr("at least 3"));
  EXPECT_THAT(parameter_error("ball-cube?ball_radius=-1"), HasSubstr("at least 0"));
  EXPECT_THAT(parameter_error("ball-cube?gap=1.5"), HasSubstr("must be an integer"));
  // (2 * 1000 + 833) * 1000^2: the gap is 125 / 150 of the side.
  EXPECT_THAT(parameter_error("ball-cube?side=1000"), HasSubstr("2833000000 voxels, more than the limit of 2^30"));
}

class EveryVolumeModel : public testing::TestWithParam<std::string> {};

TEST_P(EveryVolumeModel, BuildsTheSameTwiceOnAGridAtTheOrigin) {
  const VolumeModel& model = find_volume_model(GetParam());
  const BinaryVolume volume = model.build(Parameters::defaults(model.info.parameters));
  EXPECT_EQ(volume, make_volume(GetParam()));
  EXPECT_EQ(volume.frame.origin, Point(0, 0, 0));
  EXPECT_EQ(volume.frame.voxel_size, 1);
  EXPECT_EQ(volume.frame.is_image(), model.is_image);
  EXPECT_TRUE(std::ranges::all_of(volume.values, [](std::uint8_t value) { return value <= 1; }));
}

TEST_P(EveryVolumeModel, HasASchemaWithHelpAndValidDefaults) {
  const ModelInfo& info = find_volume_model(GetParam()).info;
  EXPECT_FALSE(info.summary.empty());
  EXPECT_FALSE(info.stands_for.empty());
  for (const ParameterSpec& spec : info.parameters.specs) {
    EXPECT_FALSE(spec.help.empty() || spec.unit.empty()) << spec.name;
    EXPECT_TRUE(std::isfinite(spec.minimum) && std::isfinite(spec.maximum)) << spec.name;
    const std::string value = to_string(spec.default_value);
    EXPECT_NO_THROW(Parameters::parse(info.parameters, std::vector{spec.name + "=" + value}, info.name)) << spec.name;
  }
}

TEST_P(EveryVolumeModel, OpensAsAModelOfItsKind) {
  std::vector<std::string> notices;
  const Model model = open_model("model:" + GetParam(), {}, notices);
  EXPECT_EQ(model.name, GetParam());
  EXPECT_EQ(model.kind(), find_volume_model(GetParam()).is_image ? ModelKind::kImage : ModelKind::kBinaryVolume);
  EXPECT_EQ(std::get<BinaryVolume>(model.shape), make_volume(GetParam()));
  EXPECT_TRUE(notices.empty());
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryVolumeModel, testing::ValuesIn(volume_model_names()), test_name);

TEST(OpenModel, TellsTheKindsOfModelsApart) {
  std::vector<std::string> notices;
  EXPECT_EQ(open_model("model:torus?segments=8", {}, notices).kind(), ModelKind::kSoup);
  const Model small = open_model("model:ball-cube?side=6", {}, notices);
  EXPECT_EQ(small.name, "ball-cube");
  EXPECT_EQ(std::get<BinaryVolume>(small.shape).frame.dims, Index3(17, 6, 6));  // 6 + 5 + 6
  const auto message = [&](const std::string& input) -> std::string {
    try {
      open_model(input, {}, notices);
    } catch (const ParameterError& error) {
      return error.what();
    }
    return "no ParameterError";
  };
  EXPECT_THAT(message("model:landscap"), HasSubstr("did you mean 'landscape'?"));
  EXPECT_THAT(message("model:sphereflak?depth=1"), HasSubstr("did you mean 'sphereflake'?"));
  EXPECT_THAT(message("model:torus?majr=2"), HasSubstr("did you mean 'major'?"));
  EXPECT_THAT(message("model:cells?seeds=2"), HasSubstr("did you mean 'seed'?"));
  EXPECT_THAT(message("model:motor?x=1"), HasSubstr("'motor' is an external model"));
}

// --- ball-cube ---------------------------------------------------------------------------------------------------

TEST(BallCube, HasThePapersSizeAndVolume) {
  const BinaryVolume volume = make_volume("ball-cube");
  EXPECT_EQ(volume.frame.dims, Index3(425, 150, 150));
  EXPECT_EQ(count_interior(volume), 3'375'000);
  // No voxel centre is more than 42.5 (24.5 sqrt 3) from the middle of its cell: one cube is full, the other empty.
  const BinaryVolume full = make_volume("ball-cube?ball_radius=42.5");
  EXPECT_EQ(count_interior(full), 3'375'000);
  EXPECT_EQ(full(0, 0, 0), 0);
  EXPECT_EQ(full(275, 0, 0), 1);
}

/// Whether the centre of voxel (i, j, k) lies in one of the 27 balls, each looked at.
bool in_some_ball(const Point& center, double side, double radius) {
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      for (int c = 0; c < 3; ++c) {
        const Point ball = side / 6 * Point(2 * a + 1, 2 * b + 1, 2 * c + 1);
        if ((center - ball).norm() <= radius) return true;
      }
    }
  }
  return false;
}

TEST(BallCube, IsMadeOfBallsAndTheirComplement) {
  for (const int side : {3, 10, 30, 31}) {
    // Radii for which no voxel centre lies on a sphere: twice the squared distance in thirds of voxels is an integer.
    for (const double radius : {0.0123, 17.0123, 25.0123, 35.0123, 42.0123, 149.0123}) {
      SCOPED_TRACE(testing::Message() << side << " " << radius);
      const BinaryVolume volume =
          make_volume("ball-cube?side=" + std::to_string(side) + "&ball_radius=" + std::to_string(radius));
      const std::int64_t right = volume.nx() - side;
      EXPECT_EQ(right - side, std::lround(side * 125 / 150.0));
      EXPECT_EQ(count_interior(volume), side * side * side);
      int wrong = 0;
      for (int k = 0; k < side; ++k) {
        for (int j = 0; j < side; ++j) {
          for (int i = 0; i < side; ++i) {
            const bool inside = in_some_ball(Point(i + 0.5, j + 0.5, k + 0.5), side, radius * side / 150);
            if (volume(right + i, j, k) != static_cast<std::uint8_t>(inside)) ++wrong;
            if (volume(i, j, k) != static_cast<std::uint8_t>(!inside)) ++wrong;
          }
          for (std::int64_t i = side; i < right; ++i) wrong += volume(i, j, k);
        }
      }
      EXPECT_EQ(wrong, 0);
    }
  }
}

TEST(BallCube, CentresLieInTheMiddleOfTheirCells) {
  // Cells of one voxel: the middle is the voxel's centre, which a ball of radius 0 holds.
  EXPECT_EQ(make_volume("ball-cube?side=3&ball_radius=0")(3 + 3, 0, 0), 1);  // the gap is 2.5, rounded up to 3
  // Cells of two voxels: the middle is a corner, sqrt(3) / 2 = 0.866 from the eight centres around it, that is 21.65
  // of the 150 parts of the side.
  EXPECT_EQ(make_volume("ball-cube?side=6&ball_radius=21.6&gap=0")(6, 0, 0), 0);
  EXPECT_EQ(make_volume("ball-cube?side=6&ball_radius=21.7&gap=0")(6, 0, 0), 1);
}

TEST(BallCube, IsSymmetric) {
  const BinaryVolume volume = make_volume("ball-cube?side=30");
  int different = 0;
  for (int k = 0; k < 30; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 30; ++i) {
        const std::uint8_t right = volume(55 + i, j, k);
        if (right != volume(55 + 29 - i, j, k) || right != volume(55 + i, 29 - j, k) ||
            right != volume(55 + i, j, 29 - k) || right != volume(55 + j, k, i)) {
          ++different;
        }
      }
    }
  }
  EXPECT_EQ(different, 0);
}

// --- images ------------------------------------------------------------------------------------------------------

struct ImageStatistics {
  std::int64_t area;
  std::int64_t black;
  std::int64_t white;
};

ImageStatistics statistics(const BinaryVolume& image) {
  RunContext context;
  return {count_interior(image), label_components(image, 1, Connectivity::kFace, context).count,
          label_components(image, 0, Connectivity::kVertex, context).count};
}

struct PaperImage {
  const char* name;
  Index3 dims;
  ImageStatistics paper;  // [WR05, Tables 1 to 3]
  ImageStatistics ours;   // pinned: the area is the paper's by construction, the components are what came out
};

std::vector<PaperImage> paper_images() {
  return {{"landscape", {400, 300, 1}, {78'195, 527, 711}, {78'195, 632, 568}},
          {"cells", {300, 225, 1}, {36'967, 98, 177}, {36'967, 92, 158}},
          {"galaxy", {620, 430, 1}, {128'956, 2'212, 3'218}, {128'956, 2'231, 3'210}}};
}

TEST(Images, HaveThePapersSizesAreasAndNearlyItsComponents) {
  for (const PaperImage& expected : paper_images()) {
    SCOPED_TRACE(expected.name);
    const BinaryVolume image = make_volume(expected.name);
    EXPECT_EQ(image.frame.dims, expected.dims);
    const ImageStatistics found = statistics(image);
    EXPECT_EQ(found.area, expected.ours.area);
    EXPECT_EQ(found.area, expected.paper.area);
    EXPECT_EQ(found.black, expected.ours.black);
    EXPECT_EQ(found.white, expected.ours.white);
  }
}

TEST(Images, KeepTheirCharacterWithOtherSeeds) {
  for (const PaperImage& expected : paper_images()) {
    const BinaryVolume first = make_volume(expected.name);
    for (const int seed : {0, 2, 1'000'000'000}) {
      SCOPED_TRACE(testing::Message() << expected.name << " " << seed);
      const BinaryVolume image = make_volume(std::string(expected.name) + "?seed=" + std::to_string(seed));
      EXPECT_NE(image, first);
      const ImageStatistics found = statistics(image);
      EXPECT_EQ(found.area, expected.paper.area);
      for (const auto& [count, paper] :
           {std::pair(found.black, expected.paper.black), std::pair(found.white, expected.paper.white)}) {
        EXPECT_LE(count, 2 * paper);
        EXPECT_GE(2 * count, paper);
      }
    }
  }
}

TEST(Images, KeepTheShareOfBlackAtOtherSizes) {
  // 78,195 / 120,000 of 200 x 100 is 13,032.5; 36,967 / 67,500 of 17 x 16 is 148.96; of 600 x 450, 147,868.
  EXPECT_EQ(count_interior(make_volume("landscape?width=200&height=100")), 13'032);
  EXPECT_EQ(count_interior(make_volume("cells?width=17&height=16")), 148);
  EXPECT_EQ(count_interior(make_volume("cells?width=600&height=450")), 147'868);
}

double black_share(const BinaryVolume& image, double left, double right, double low, double high) {
  std::int64_t pixels = 0;
  std::int64_t black = 0;
  for (std::int64_t j = 0; j < image.ny(); ++j) {
    for (std::int64_t i = 0; i < image.nx(); ++i) {
      const double x = (static_cast<double>(i) + 0.5) / static_cast<double>(image.nx());
      const double y = (static_cast<double>(j) + 0.5) / static_cast<double>(image.ny());
      if (x < left || x > right || y < low || y > high) continue;
      ++pixels;
      black += image(i, j, 0);
    }
  }
  return static_cast<double>(black) / static_cast<double>(pixels);
}

TEST(Images, LandscapeHasSparseWaterAndDenseFoliage) {
  // [WR05, 5]: "the predominantly white portion of water to the right of the tree", "the predominantly black portion of
  // the top left part". Both are noisy: neither all white nor all black.
  const BinaryVolume image = make_volume("landscape");
  const double water = black_share(image, 0.55, 0.95, 0.25, 0.45);
  EXPECT_GT(water, 0.05);
  EXPECT_LT(water, 0.35);
  const double foliage = black_share(image, 0.05, 0.30, 0.65, 0.95);
  EXPECT_GT(foliage, 0.65);
  EXPECT_LT(foliage, 0.95);
}

/// Pixels that filleting would add and those that rounding would remove.
BinaryVolume mortar_of(const BinaryVolume& image, double radius) {
  RunContext context;
  const BinaryVolume rounded = open(image, radius, context);
  BinaryVolume mortar = close(image, radius, context);
  for (std::size_t i = 0; i < mortar.values.size(); ++i) mortar.values[i] = mortar.values[i] & ~rounded.values[i] & 1U;
  return mortar;
}

TEST(Images, CellsHaveAsMuchInnerAsOuterIrregularity) {
  // [WR05, Table 2]: 7,970 inner-irregular and 7,312 outer-irregular pixels at radius 5, a mortar of 15,282.
  const BinaryVolume image = make_volume("cells");
  const BinaryVolume mortar = mortar_of(image, 5);
  std::int64_t inner = 0;
  for (std::size_t i = 0; i < image.values.size(); ++i) inner += image.values[i] & mortar.values[i];
  const std::int64_t outer = count_interior(mortar) - inner;
  EXPECT_LT(inner, 2 * outer);
  EXPECT_LT(outer, 2 * inner);
  EXPECT_NEAR(static_cast<double>(inner + outer), 15'282, 0.2 * 15'282);
}

TEST(Images, GalaxyMixesSparseAndDenseRegionsInOneComponentOfTheMortar) {
  // [WR05, 5]: "predominantly white regions with black noise are adjacent to predominantly black regions with white
  // noise, forming a single connected component of mortar".
  const BinaryVolume image = make_volume("galaxy");
  const BinaryVolume mortar = mortar_of(image, 5);
  RunContext context;
  const Labelling components = label_components(mortar, 1, Connectivity::kFace, context);
  std::vector<std::int64_t> sizes(static_cast<std::size_t>(components.count) + 1);
  for (const std::int32_t label : components.labels.values) ++sizes[static_cast<std::size_t>(label)];
  const auto largest = std::max_element(sizes.begin() + 1, sizes.end());
  EXPECT_GT(*largest, count_interior(mortar) * 9 / 10);
  // Squares of 20 pixels at least half of which belong to that component, by the share of black among those.
  int sparse = 0;
  int dense = 0;
  const auto label = static_cast<std::int32_t>(largest - sizes.begin());
  for (std::int64_t top = 0; top + 20 <= image.ny(); top += 20) {
    for (std::int64_t left = 0; left + 20 <= image.nx(); left += 20) {
      int pixels = 0;
      int black = 0;
      for (std::int64_t j = top; j < top + 20; ++j) {
        for (std::int64_t i = left; i < left + 20; ++i) {
          if (components.labels(i, j, 0) != label) continue;
          ++pixels;
          black += image(i, j, 0);
        }
      }
      if (pixels < 200) continue;
      if (3 * black < pixels) ++sparse;
      if (3 * black > 2 * pixels) ++dense;
    }
  }
  EXPECT_GE(sparse, 30);
  EXPECT_GE(dense, 30);
}

}  // namespace
}  // namespace voxcarve
