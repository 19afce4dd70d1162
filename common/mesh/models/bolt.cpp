// bolt, in place of the bolt of [He95, Fig. 7], which is not public: a hexagon head on a shaft with a metric thread.
//
// The shaft is r <= R(z, angle) in cylindrical coordinates. A thread's section is the basic profile of ISO 68-1: flanks
// of 60 degrees, crests an eighth and roots a quarter of the pitch wide. It is cut at 45 degrees at the tip and runs
// out at 45 degrees into the shank, so that R is continuous everywhere.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/mesh/models/builders.h"
#include "common/mesh/models/implicit_shapes.h"
#include "common/mesh/models/primitives.h"

namespace voxcarve {

namespace {

constexpr int kSegments = 48;  // around, and along each turn, at detail 1; the profile's corners are at sixteenths
constexpr double kHeadHeight = 0.65;  // in diameters
constexpr double kHeadApothem = 0.8;

class Bolt {
 public:
  explicit Bolt(const Parameters& parameters)
      : diameter_(parameters.real("diameter")),
        pitch_(parameters.real("pitch") * diameter_),
        turns_(static_cast<int>(parameters.integer("turns"))),
        crest_(diameter_ / 2),
        // Five eighths of the height of the triangle on a pitch, whose half is that over tan 30 degrees.
        root_(crest_ - 0.625 * std::sqrt(0.75) * pitch_),
        thread_end_(turns_ * pitch_),
        shaft_end_(thread_end_ + parameters.real("shank") * diameter_),
        head_end_(shaft_end_ + kHeadHeight * diameter_),
        apothem_(kHeadApothem * diameter_) {}

  /// R at height z, of any z, where the thread has `phase`, in pitches: a whole number in the middle of a crest.
  double radius_at(double z, double phase) const {
    // Along z, from the middle of a crest: 1/16 of crest, 5/16 of flank, 1/8 of half a root.
    const double from_crest = std::abs(phase - std::round(phase));
    const double share = std::clamp((0.375 - from_crest) / 0.3125, 0.0, 1.0);
    const double thread = std::min(root_ + share * (crest_ - root_), root_ + std::max(z, 0.0));
    return std::min(crest_, std::max(thread, crest_ - (thread_end_ - z)));
  }

  TriangleSoup surface(int detail) const {
    const int segments = kSegments * detail;
    std::vector<Ring> rings;
    // One segment on along the helix is one on around and one up, so that crests and roots run along edges.
    for (int i = 0; i <= turns_ * segments; ++i) {
      const double z = pitch_ * i / segments;
      rings.push_back(ring(segments, z, [&](int k, double) {
        return radius_at(z, static_cast<double>((i - k + segments) % segments) / segments);
      }));
    }
    const auto hexagon = [&](int k, double angle) {
      // The nearest middle of a side is at 30 + 60 s degrees.
      const int side = 6 * k / segments;
      return apothem_ / std::cos(angle - (2 * side + 1) * std::numbers::pi / 6);
    };
    if (shaft_end_ > thread_end_) rings.push_back(ring(segments, shaft_end_, [&](int, double) { return crest_; }));
    rings.push_back(ring(segments, shaft_end_, hexagon));
    rings.push_back(ring(segments, head_end_, hexagon));
    rings.push_back({Point(0, 0, head_end_)});
    return loft(rings);
  }

  bool inside(const Point& p) const {
    if (p.z() < 0 || p.z() > head_end_) return false;
    if (p.z() >= shaft_end_) return hexagon_clearance(p) <= 0;
    const double squared = p.x() * p.x() + p.y() * p.y();
    if (squared > crest_ * crest_) return false;
    return squared <= root_ * root_ || std::sqrt(squared) <= radius_at(p.z(), phase_of(p));
  }

  double signed_clearance(const Point& p) const {
    // The shaft goes on through the head, lest the plane between them count as a boundary.
    const double shaft = std::max(slab_clearance(p.z(), 0, head_end_), lateral_clearance(p));
    const double head = std::max(slab_clearance(p.z(), shaft_end_, head_end_), hexagon_clearance(p));
    return std::min(shaft, head);
  }

  Box bounds() const {
    const double corner = 2 * apothem_ / std::numbers::sqrt3;
    return {Point(-corner, -apothem_, 0), Point(corner, apothem_, head_end_)};
  }

 private:
  template <class Radius>
  static Ring ring(int segments, double z, const Radius& radius) {
    Ring points;
    for (int k = 0; k < segments; ++k) {
      const double angle = 2 * std::numbers::pi * k / segments;
      const double r = radius(k, angle);
      points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
    return points;
  }

  double phase_of(const Point& p) const { return p.z() / pitch_ - turns_of(p.x(), p.y()); }

  double hexagon_clearance(const Point& p) const {
    const double y = std::abs(p.y());
    return std::max(y, std::numbers::sqrt3 / 2 * std::abs(p.x()) + y / 2) - apothem_;
  }

  /// Of {r <= R}, for all z. R is between the radii of root and crest. So where r <= root, and where r > crest, the
  /// distance from either cylinder is a bound. Where r >= root / 2, the derivative of r - R is at most 1 along r, tan
  /// 60 along z and tan 60 * pitch / (2 pi r) around; a ball that stays there and has a radius of at most |r - R| over
  /// the length of that vector has r - R of one sign.
  double lateral_clearance(const Point& p) const {
    const double r = std::sqrt(p.x() * p.x() + p.y() * p.y());
    if (r <= root_) return r - root_;
    const double around = std::numbers::sqrt3 * pitch_ / (std::numbers::pi * root_);
    const double slope = std::sqrt(1 + 3 + around * around);
    const double height = r - radius_at(p.z(), phase_of(p));
    const double bound = std::min(std::abs(height) / slope, r - root_ / 2);
    return height < 0 ? -bound : std::max(bound, r - crest_);
  }

  double diameter_;
  double pitch_;
  int turns_;
  double crest_;       // radius
  double root_;        // radius
  double thread_end_;  // heights
  double shaft_end_;
  double head_end_;
  double apothem_;
};

}  // namespace

ProceduralModel bolt_model() {
  ModelInfo info{"bolt", "a bolt with a hexagon head and a helical thread: closed, genus 0", "He Fig. 7", {}};
  info.parameters.specs = {
      ParameterSpec::integer("detail", "48 segments", 1, 8, 1,
                             "segments around the shaft and along each turn; of form=mesh only"),
      ParameterSpec::real("diameter", "model", 1e-3, 1e6, 1, "of the thread's crests and of the shank"),
      form_parameter(),
      ParameterSpec::real("pitch", "diameter", 0.01, 0.4, 0.16, "of the thread, of which it is 0.54 deep"),
      ParameterSpec::real("shank", "diameter", 0, 100, 0.6, "length of the shaft that has no thread"),
      ParameterSpec::integer("turns", "turns", 2, 1000, 10, "of the thread")};
  info.parameters.check = [](const Parameters& parameters) {
    if (parameters.choice("form") != "mesh") return;
    const double segments = kSegments * static_cast<double>(parameters.integer("detail"));
    require_triangles_within_limit("bolt",
                                   2 * segments * (segments * static_cast<double>(parameters.integer("turns")) + 4));
  };
  return {std::move(info),
          [](const Parameters& parameters) {
            return Bolt(parameters).surface(static_cast<int>(parameters.integer("detail")));
          },
          [](const Parameters& parameters) { return implicit_solid(Bolt(parameters)); }};
}

}  // namespace voxcarve
