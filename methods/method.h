// The interface that every method stands behind.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/mesh/triangle_soup.h"
#include "common/model.h"
#include "common/run/context.h"
#include "common/run/parameters.h"
#include "common/volume/grid.h"

namespace voxcarve {

/// What a method says of itself.
struct MethodInfo {
  std::string name;      ///< "nooruddin-turk": as typed on the command line
  std::string summary;   ///< one line: what it does
  std::string citation;  ///< key in docs/bibliography.bib, or "" for a method that needs none
  std::vector<ModelKind> accepts;
  ParameterSchema parameters;
  bool closed_manifold = false;  ///< promises that every level is a closed, oriented 2-manifold
  bool gives_stream = false;     ///< results hold a carving stream, that a stream file can take
  bool gives_volume = false;     ///< results hold a volume, that a volume file can take
  bool baseline = false;         ///< stands in tables to be compared with
};

/// Why a method does not apply to a model: a skip, not a failure.
struct SkipReason {
  std::string text;
};

/// How large a level is.
struct LevelCounts {
  std::int64_t triangles = 0;
  std::int64_t vertices = 0;  ///< distinct positions, not the copies that cutting to a manifold makes
};

/// An ordered sequence of surfaces from coarse to fine, extracted on demand.
class LevelSequence {
 public:
  virtual ~LevelSequence() = default;
  virtual std::int64_t size() const = 0;
  /// Level `index` in [0, size()). May be called from several threads.
  virtual TriangleSoup extract(std::int64_t index) const = 0;
  /// Counts of a level. The base extracts it.
  virtual LevelCounts counts(std::int64_t index) const;
};

/// The levels of a method that makes them all at once.
std::shared_ptr<const LevelSequence> make_levels(std::vector<TriangleSoup> coarse_to_fine);

/// A volume that a method made on its way, by the name of the stage that it left.
struct NamedVolume {
  std::string name;
  std::variant<BinaryVolume, DensityVolume> volume;
  std::int64_t level = 0;  ///< the level that it belongs to
};

/// A surface of a level that is drawn together with others, the outer ones translucent, for a gradual transition from
/// the solid to what surrounds it.
struct TranslucentLayer {
  std::int64_t level = 0;  ///< the level that it belongs to
  double iso_density = 0.5;
  double opacity = 1;
  TriangleSoup surface;
};

/// A figure that says what a level is like, to be listed beside it.
struct LevelProperty {
  std::string name;  ///< "support"; results/README.md lists them all with units
  double value = 0;
};

struct MethodResult {
  /// Never null, at least one level. Where the run's context asked for no surfaces, they may be empty.
  std::shared_ptr<const LevelSequence> levels;
  /// In the order of the stages; the last one of each level is that level as a volume.
  std::vector<NamedVolume> volumes;
  std::vector<TranslucentLayer> layers;  ///< by level, from the innermost outward; most methods make none
  std::vector<std::vector<LevelProperty>> level_properties;  ///< one list a level, or empty: there is nothing to say
  std::vector<StageTiming> timings;
  std::vector<std::string> notices;
};

/// Whether something that a method guarantees holds of one result.
struct InvariantCheck {
  std::string name;  ///< "closed 2-manifold"
  bool holds = false;
  std::string detail;  ///< what was counted
};

/// A topology-simplifying method. Objects are stateless: every member is const and may run on several threads at once.
class Method {
 public:
  virtual ~Method() = default;

  virtual const MethodInfo& info() const = 0;

  /// The reason why `run` cannot be asked for this model with these parameters, or nothing. The base asks for the kinds
  /// that info() lists; methods add their own conditions in `unsupported_shape`.
  std::optional<SkipReason> unsupported(const Model& model, const Parameters& parameters) const;

  /// Runs the method. The same model, parameters and seed give the same bytes on any number of threads.
  /// Throws InputError for a model that is empty, not finite or of an unsupported kind, ResourceError before exceeding
  /// the context's memory budget, MethodFailure when there is no result, and Cancelled.
  MethodResult run(const Model& model, const Parameters& parameters, RunContext& context) const;

  /// Verifies what the method promises of a result of `run` with the same model and parameters: that every level (of
  /// more than kCheckedLevels, so many evenly spread ones with the first and the last) is a closed, oriented 2-manifold
  /// where info() says so, then the method's own invariants.
  std::vector<InvariantCheck> check_invariants(const Model& model, const Parameters& parameters,
                                               const MethodResult& result, RunContext& context) const;
  static constexpr std::int64_t kCheckedLevels = 64;

 protected:
  virtual std::optional<SkipReason> unsupported_shape(const Model& model, const Parameters& parameters) const;
  virtual std::vector<InvariantCheck> own_invariants(const Model& model, const Parameters& parameters,
                                                     const MethodResult& result, RunContext& context) const;
  virtual MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const = 0;
};

}  // namespace voxcarve
