// Based on [HE10]; what it leaves open, and how it is decided here: README.md beside this file.
#include "methods/hagbi_elsana/hagbi_elsana.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/mesh/quadric_reduction.h"
#include "common/model_source.h"
#include "common/run/errors.h"
#include "common/run/text.h"
#include "methods/hagbi_elsana/carving.h"
#include "methods/hagbi_elsana/invariants.h"
#include "methods/hagbi_elsana/valid_complex.h"

namespace voxcarve {

namespace {

class CarvingLevels final : public LevelSequence {
 public:
  explicit CarvingLevels(std::shared_ptr<const CarvingStream> stream) : stream_(std::move(stream)) {}

  std::int64_t size() const override { return std::ssize(stream_->levels()); }
  TriangleSoup extract(std::int64_t index) const override { return stream_->extract(step(index)); }
  LevelCounts counts(std::int64_t index) const override {
    return {stream_->triangles(step(index)), stream_->vertices(step(index))};
  }
  const std::shared_ptr<const CarvingStream>& stream() const { return stream_; }

 private:
  std::uint32_t step(std::int64_t index) const { return stream_->levels().at(static_cast<std::size_t>(index)); }

  std::shared_ptr<const CarvingStream> stream_;
};

MethodInfo make_info() {
  MethodInfo info;
  info.name = "hagbi-elsana";
  info.summary = "carve the convex hull down to the model, tetrahedron by tetrahedron: a stream of nested solids";
  info.citation = "HE10";
  info.accepts = {ModelKind::kSoup, ModelKind::kScalarVolume, ModelKind::kBinaryVolume};
  info.parameters.specs = {
      ParameterSpec::choice("priority", {"longest-edge", "volume", "circumradius-ratio"}, "longest-edge",
                            "what is carved first: long edges, large volumes, or round shapes (by shortest edge over "
                            "circumradius)"),
      ParameterSpec::real("depth_power", "", 0, 100, 0,
                          "dp: priorities are divided by this power of the depth; higher carves more evenly"),
      ParameterSpec::choice("depth_measure", {"level", "distance"}, "level",
                            "depth: tetrahedra on the way from the hull, or 1 + distance from it in mean edges"),
      ParameterSpec::real("breadth", "diag", 0, 1, 0,
                          "bp: a step carves all that lies within a ball of this radius and can be reached"),
      ParameterSpec::real("breadth_model", "model", 0, 1e300, 0,
                          "the same in model units, as in the paper; 0: breadth says it"),
      ParameterSpec::choice("initial", {"hull", "box"}, "hull", "what is carved: the convex hull, or the bounding box"),
      ParameterSpec::toggle("exposed", true, "carve at once what has two faces or more on the outside"),
      ParameterSpec::choice("open_mesh", {"fold", "solidify"}, "fold",
                            "surfaces with a boundary: stay as two-sided sheets, or count as solid where their "
                            "generalised winding number is above 1/2"),
      ParameterSpec::real("smallest_void", "diag^3", 0, 1, 0, "enclosed voids of less volume are left shut"),
      ParameterSpec::integer("decimate", "triangles", 0, 1000000000, 0,
                             "first collapse the model's edges, keeping its topology, down to so many; 0: leave it"),
      ParameterSpec::integer(
          "rounds", "", 1, 16, 1,
          "with decimate: reach it in so many rounds, each of collapses and of carving away the last "
          "vertices"),
      ParameterSpec::real("tetgen_seconds", "s", 0.001, 1e6, 600, "limit of TetGen's time"),
      ParameterSpec::real("tetgen_memory", "GiB", 0, 1e6, 0, "limit of TetGen's memory; 0: the memory budget"),
  };
  info.parameters.check = [](const Parameters& parameters) {
    if (parameters.real("breadth") > 0 && parameters.real("breadth_model") > 0) {
      throw ParameterError("hagbi-elsana: breadth and breadth_model say the same in two units; set one of them");
    }
    if (parameters.integer("rounds") > 1 && parameters.integer("decimate") == 0) {
      throw ParameterError("hagbi-elsana: rounds are of decimation; set decimate too");
    }
  };
  info.closed_manifold = true;
  info.gives_stream = true;
  return info;
}

CarvingOptions carving_options(const Parameters& parameters, double diagonal) {
  CarvingOptions options;
  const std::string& priority = parameters.choice("priority");
  options.priority = priority == "volume"               ? CarvingPriority::kVolume
                     : priority == "circumradius-ratio" ? CarvingPriority::kCircumradiusRatio
                                                        : CarvingPriority::kLongestEdge;
  options.depth_power = parameters.real("depth_power");
  options.depth_measure =
      parameters.choice("depth_measure") == "distance" ? DepthMeasure::kDistance : DepthMeasure::kLevel;
  options.breadth =
      parameters.real("breadth_model") > 0 ? parameters.real("breadth_model") : parameters.real("breadth") * diagonal;
  options.exposed = parameters.toggle("exposed");
  options.smallest_void = parameters.real("smallest_void") * diagonal * diagonal * diagonal;
  return options;
}

ComplexOptions complex_options(const Parameters& parameters) {
  ComplexOptions options;
  options.box = parameters.choice("initial") == "box";
  options.limits.seconds = parameters.real("tetgen_seconds");
  options.limits.bytes = static_cast<std::uint64_t>(parameters.real("tetgen_memory") * 0x1p30);
  return options;
}

class HagbiElSana final : public Method {
 public:
  const MethodInfo& info() const override { return info_; }

 protected:
  MethodResult do_run(const Model& model, const Parameters& parameters, RunContext& context) const override {
    TriangleSoup surface = reference_surface(model, context);
    surface.vertex_colors.clear();
    surface.triangle_colors.clear();
    if (parameters.integer("decimate") > 0) surface = decimated(std::move(surface), parameters, context);
    MethodResult result;
    result.levels = make_levels(carved(surface, parameters, context));
    return result;
  }

  std::vector<InvariantCheck> own_invariants(const Model&, const Parameters&, const MethodResult& result,
                                             RunContext& context) const override {
    return check_stream(*stream_of(*result.levels), context);
  }

 private:
  std::shared_ptr<const CarvingStream> carved(const TriangleSoup& surface, const Parameters& parameters,
                                              RunContext& context) const {
    const ValidComplex valid = make_valid_complex(surface, complex_options(parameters), context);
    const InsideRule rule =
        parameters.choice("open_mesh") == "solidify" ? InsideRule::kWindingNumber : InsideRule::kWinding;
    Classification classified = classify(valid.tetrahedralization, valid.complex, valid.multiplicity, rule, context);
    tell(valid, classified, context);
    CarvingReport report;
    std::vector<std::uint32_t> steps =
        carve(classified.complement, classified.voids, carving_options(parameters, bounds(valid.complex).diagonal()),
              context, &report);
    context.notice(fmt::format("snaking {:.3f}, spiking {:.4f}", report.snaking, report.spiking));
    if (report.shut_voids > 0) context.notice(std::to_string(report.shut_voids) + " voids were left shut");
    return std::make_shared<const CarvingStream>(std::move(classified.complement), std::move(steps),
                                                 parameters.canonical(), context);
  }

  static void tell(const ValidComplex& valid, const Classification& classified, RunContext& context) {
    const auto number = [](std::size_t count) { return with_thousands(static_cast<std::int64_t>(count)); };
    context.notice(number(valid.complex.positions.size()) + " vertices, " + number(classified.hull_points) +
                   " on the hull, " + number(valid.complex.triangles.size()) + " triangles, " +
                   number(classified.tetrahedra) + " tetrahedra, " + number(classified.complement.first_ghost) +
                   " of them to carve, " + number(valid.tetrahedralization.steiner_points) + " Steiner points");
    if (!classified.voids.empty()) context.notice(number(classified.voids.size()) + " enclosed voids");
    if (classified.folds > 0) {
      context.notice(with_thousands(classified.folds) +
                     " triangles have the outside on both sides: they stay as two-sided sheets");
    }
    if (classified.nested_regions > 0) {
      context.notice(with_thousands(classified.nested_regions) +
                     " regions lie inside several parts at once: walls between them are never seen");
    }
    if (classified.contradictory_regions > 0) {
      context.notice(
          "orientations contradict each other around " + with_thousands(classified.contradictory_regions) +
          " regions: inside is what lies behind an odd number of walls, or where the winding number says so");
    }
  }

  /// [HE10, 7]: geometry first, by collapses that keep the topology; in rounds, with steps back in the stream between
  /// them. Each round ends with as many triangles as its share of the way, on a logarithmic scale.
  TriangleSoup decimated(TriangleSoup surface, const Parameters& parameters, RunContext& context) const {
    const std::int64_t rounds = parameters.integer("rounds");
    const auto goal = static_cast<double>(parameters.integer("decimate"));
    const auto first = static_cast<double>(surface.triangles.size());
    if (goal >= first) return surface;
    surface = merge_equal_positions(surface);
    for (std::int64_t round = 1; round <= rounds; ++round) {
      const double share = static_cast<double>(round) / static_cast<double>(rounds);
      const auto triangles = static_cast<std::int64_t>(std::llround(first * std::pow(goal / first, share)));
      if (round > 1) {
        // Half of the round's way by carving less, the other half by collapses.
        const auto stream = carved(surface, parameters, context);
        const double half = std::sqrt(static_cast<double>(triangles) * static_cast<double>(surface.triangles.size()));
        surface = stream->extract(stream->step_for_triangles(std::llround(half)), &context);
      }
      surface = reduce_quadric(surface, {.triangles = triangles}, context);
    }
    return surface;
  }

  MethodInfo info_ = make_info();
};

}  // namespace

std::unique_ptr<Method> make_hagbi_elsana() {
  return std::make_unique<HagbiElSana>();
}

std::shared_ptr<const CarvingStream> stream_of(const LevelSequence& levels) {
  const auto* carving = dynamic_cast<const CarvingLevels*>(&levels);
  return carving != nullptr ? carving->stream() : nullptr;
}

std::shared_ptr<const LevelSequence> make_levels(std::shared_ptr<const CarvingStream> stream) {
  return std::make_shared<CarvingLevels>(std::move(stream));
}

}  // namespace voxcarve
