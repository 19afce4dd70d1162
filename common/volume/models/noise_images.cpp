// landscape, cells and galaxy: stand-ins for the images of [WR05, 5], photographs that are not public. Painted are the
// things that the paper's text says of each, and of its tables the size of the image, the share of black pixels
// (exactly) and, within a factor of 1.5 for the default seed, the numbers of components of either colour. Where the
// things lie in the picture is free invention.
//
// Each image is a grey picture of shapes and noise whose darkest pixels are black. Shapes scale with the picture;
// noise is a matter of pixels, as it is in photographs, so that larger pictures have more components.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/volume/models/builders.h"
#include "common/volume/models/picture.h"

namespace voxcarve {

namespace {

ParameterSchema image_parameters(std::int64_t width, std::int64_t height) {
  ParameterSchema schema;
  schema.specs = {
      ParameterSpec::integer("height", "pixels", 16, 4096, height, "of the image; the default is the paper's"),
      ParameterSpec::integer("seed", "-", 0, 1'000'000'000, 1, "of the noise: another seed, another picture"),
      ParameterSpec::integer("width", "pixels", 16, 4096, width, "of the image; the default is the paper's")};
  return schema;
}

/// What the pictures share: their size and share of black pixels, the noise, and coordinates.
class Picture {
 public:
  Picture(const Parameters& parameters, double black)
      : width_(parameters.integer("width")),
        height_(parameters.integer("height")),
        noise_(static_cast<std::uint64_t>(parameters.integer("seed"))),
        black_(black) {}
  virtual ~Picture() = default;

  BinaryVolume paint() const {
    return darkest_share(width_, height_, black_, [this](std::int64_t i, std::int64_t j) { return darkness(i, j); });
  }

 protected:
  /// Of the pixel in column i and row j from below: the darkest are black.
  virtual double darkness(std::int64_t i, std::int64_t j) const = 0;

  /// From 0 at the left edge to 1 at the right one.
  double u(std::int64_t i) const { return (static_cast<double>(i) + 0.5) / static_cast<double>(width_); }
  /// From 0 at the lower edge to 1 at the upper one.
  double v(std::int64_t j) const { return (static_cast<double>(j) + 0.5) / static_cast<double>(height_); }
  /// 1 at a share of all pixels, each for itself, and 0 elsewhere.
  double speck(std::int64_t i, std::int64_t j, double share, std::uint32_t layer) const {
    return noise_.grain(i, j, layer) >= 1 - 2 * share ? 1 : 0;
  }
  /// Noise whose first octave has the given periods in pixels.
  double texture(std::int64_t i, std::int64_t j, double across, double up, int octaves, std::uint32_t layer) const {
    return noise_.fractal(static_cast<double>(i) / across, static_cast<double>(j) / up, octaves, layer);
  }

  std::int64_t width_;
  std::int64_t height_;
  Noise noise_;

 private:
  double black_;
};

// --- landscape ---------------------------------------------------------------------------------------------------

/// Sky above a dark far shore, water right of a tree in the middle, foliage at the top left, dark ground below.
class Landscape : public Picture {
 public:
  explicit Landscape(const Parameters& parameters) : Picture(parameters, 78'195.0 / 120'000) {}  // [WR05, Table 1]

 private:
  double darkness(std::int64_t i, std::int64_t j) const override {
    const double x = u(i);
    const double y = v(j);
    // Shores and outlines are uneven: the coordinates that decide them waver.
    const double waver = noise_.fractal(9 * x, 9 * y, 4, 20);
    const double leaves = std::max(crown(x, y, waver), thicket(x, y, waver));
    const double ground = smooth_step(-0.012, 0.012, 0.2 + 0.05 * waver - 0.08 * (x - 0.4) - y);
    double value = interpolated(behind(i, j, x, y, waver), 1.5, std::max(ground, trunk(x, y, waver)));
    if (leaves > 0) value = interpolated(value, foliage(i, j), leaves);
    return value;
  }

  /// Predominantly black.
  double foliage(std::int64_t i, std::int64_t j) const {
    return 0.28 + 0.5 * texture(i, j, 30, 30, 1, 34) + 0.9 * texture(i, j, 4, 4, 2, 30) + 0.35 * noise_.grain(i, j, 36);
  }

  /// Predominantly white, with the streaks of waves.
  double water(std::int64_t i, std::int64_t j) const {
    return -0.26 + 0.4 * texture(i, j, 60, 15, 1, 54) + 0.9 * texture(i, j, 6, 2.5, 2, 50) +
           0.1 * noise_.grain(i, j, 56);
  }

  /// What lies behind tree and ground: water, the far shore and the sky.
  double behind(std::int64_t i, std::int64_t j, double x, double y, double waver) const {
    const double shore = 0.64 + 0.04 * noise_.fractal(5 * x, 0.5, 4, 40);
    if (y > shore) return -1.5;
    if (y > 0.5 + 0.02 * waver) return 1.5;
    if (x < 0.40 + 0.05 * waver) return 1.5;  // the bank left of the tree
    return water(i, j);
  }

  /// The foliage of the top left, fading at its edge.
  static double thicket(double x, double y, double waver) {
    return smooth_step(-0.03, 0.03, 0.36 + 0.10 * waver - x) * smooth_step(-0.03, 0.03, y - 0.52 - 0.08 * waver);
  }

  static double crown(double x, double y, double waver) {
    const double across = (x - 0.47) / 0.20;
    const double up = (y - 0.80) / 0.20;
    return smooth_step(-0.15, 0.15, 1 + 0.5 * waver - across * across - up * up);
  }

  /// The trunk, wider towards its foot.
  static double trunk(double x, double y, double waver) {
    const double middle = 0.47 + 0.02 * waver;
    const double half_width = 0.012 + 0.02 * (1 - y) * (1 - y);
    return y < 0.85 ? smooth_step(-0.004, 0.004, half_width - std::abs(x - middle)) : 0;
  }
};

// --- cells -------------------------------------------------------------------------------------------------------

/// Lung tissue: white air spaces of different sizes between dark walls, both of them mottled.
class Cells : public Picture {
 public:
  explicit Cells(const Parameters& parameters) : Picture(parameters, 36'967.0 / 67'500) {}  // [WR05, Table 2]

 private:
  double darkness(std::int64_t i, std::int64_t j) const override {
    return -2.2 * air(i, j) + 1.1 * texture(i, j, 24, 24, 2, 20) + 0.7 * texture(i, j, 6, 6, 2, 30) +
           0.06 * noise_.grain(i, j, 36) - 0.8 * speck(i, j, 0.0035, 37);
  }

  /// How deep the pixel lies in an air space: positive inside, in widths of a cell.
  double air(std::int64_t i, std::int64_t j) const {
    const double pitch = static_cast<double>(std::max(width_, height_)) / 7;
    const double x = static_cast<double>(i) / pitch + 0.25 * texture(i, j, pitch, pitch, 2, 40);
    const double y = static_cast<double>(j) / pitch + 0.25 * texture(i, j, pitch, pitch, 2, 42);
    const auto column = static_cast<std::int64_t>(std::floor(x));
    const auto row = static_cast<std::int64_t>(std::floor(y));
    double deepest = -1;
    for (std::int64_t m = row - 1; m <= row + 1; ++m) {
      for (std::int64_t n = column - 1; n <= column + 1; ++n) {
        const double across = x - (static_cast<double>(n) + 0.5 + 0.4 * noise_.grain(n, m, 50));
        const double up = y - (static_cast<double>(m) + 0.5 + 0.4 * noise_.grain(n, m, 51));
        const double radius = 0.42 + 0.16 * noise_.grain(n, m, 52);
        deepest = std::max(deepest, radius - std::sqrt(across * across + up * up));
      }
    }
    return deepest;
  }
};

// --- galaxy ------------------------------------------------------------------------------------------------------

/// A spiral galaxy: a bright nucleus and two arms in a dark sky with stars, under so much noise that at radius 5 one
/// component of the mortar holds white regions with black noise and black ones with white noise.
class Galaxy : public Picture {
 public:
  explicit Galaxy(const Parameters& parameters) : Picture(parameters, 128'956.0 / 266'600) {}  // [WR05, Table 3]

 private:
  double darkness(std::int64_t i, std::int64_t j) const override {
    const double x = (u(i) - 0.5) * static_cast<double>(width_) / static_cast<double>(height_);
    const double y = v(j) - 0.5;
    // The disc is seen at a slant.
    const double along = 0.92 * x + 0.39 * y;
    const double across = (0.92 * y - 0.39 * x) / 0.62;
    return -light(along, across) + 0.8 * texture(i, j, 24, 24, 2, 20) + 0.7 * texture(i, j, 3, 3, 2, 30) +
           0.06 * noise_.grain(i, j, 36) - 0.7 * speck(i, j, 0.03, 37) + 1.2 * speck(i, j, 0.004, 38);
  }

  static double light(double x, double y) {
    const double square = x * x + y * y;
    const double radius = std::sqrt(square);
    const double nucleus = 1.6 * (1 - smooth_step(0.02, 0.16, radius));
    // Two arms: brightest where twice the angle equals the phase, which turns with the radius.
    const double phase = 3.2 * radius / (radius + 0.35);
    const double alignment = square > 0 ? ((x * x - y * y) * wave(phase) + 2 * x * y * wave(phase - 0.25)) / square : 0;
    const double arms = alignment * smooth_step(0.05, 0.2, radius) * (1 - smooth_step(0.45, 0.75, radius));
    const double disc = 0.35 * (1 - smooth_step(0.2, 0.75, radius));
    return nucleus + disc + 0.55 * arms;
  }

  /// A wave of period 1 like a cosine, from 1 at 0 to -1 at 1/2, of multiplications alone.
  static double wave(double turns) {
    const double from_crest = std::abs(turns - std::floor(turns + 0.5));
    return 1 - 2 * smooth_step(0, 0.5, from_crest);
  }
};

}  // namespace

VolumeModel landscape_model() {
  return {{"landscape", "water with sparse black noise, foliage with sparse white noise", "WR Fig. 4",
           image_parameters(400, 300)},
          true,
          [](const Parameters& parameters) { return Landscape(parameters).paint(); }};
}

VolumeModel cells_model() {
  return {{"cells", "tissue with air spaces, blobs of both colours alike", "WR Fig. 5", image_parameters(300, 225)},
          true,
          [](const Parameters& parameters) { return Cells(parameters).paint(); }};
}

VolumeModel galaxy_model() {
  return {{"galaxy", "a spiral under noise, sparse and dense regions in one component of the mortar", "WR Fig. 6",
           image_parameters(620, 430)},
          true,
          [](const Parameters& parameters) { return Galaxy(parameters).paint(); }};
}

}  // namespace voxcarve
