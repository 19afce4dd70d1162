// Based on TetGen 1.5 [Si15] as [HE10, 3.1] uses it; differs in that unused points, repeated points and repeated
// triangles never reach the library, which renumbers or rejects them, in multiplying by a power of two, for it has
// absolute thresholds, and in checking what it promises before anyone relies on it.
#include "methods/hagbi_elsana/tetgen_child.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>

#include "common/run/text.h"
#include "methods/hagbi_elsana/compact_complex.h"
#include "methods/hagbi_elsana/watched_child.h"

// The library ends a run by its weak terminatetetgen(), which frees the mesh and throws an int; unwinding then frees
// it again. Ours, defined below, takes its place; the header's inline twin steps aside under another name.
#define TETLIBRARY
#define terminatetetgen terminatetetgen_of_the_header
#include <tetgen.h>
#undef terminatetetgen
#undef REAL

namespace voxcarve {

namespace {

/// What our terminatetetgen() throws, out of the library.
struct Terminated {
  int code;
};

}  // namespace

}  // namespace voxcarve

void terminatetetgen(tetgenmesh* mesh, int code);
void terminatetetgen(tetgenmesh* /*mesh*/, int code) {
  throw voxcarve::Terminated{code};
}

namespace voxcarve {

namespace {

using Kind = TetgenFailure::Kind;

constexpr int kOutOfMemoryCode = 1;  // of terminatetetgen()
constexpr std::int32_t kNoCode = -1;

// Of this process and its child together, of a surface; measured.
constexpr std::uint64_t kBytesPerTriangle = 2000;
constexpr std::uint64_t kBytesPerPoint = 2000;

/// TetGen counts in `int`, three coordinates a point and some seven tetrahedra with four corners.
constexpr std::size_t kMostElements = std::size_t{1} << 25;

/// What the child says when TetGen ended. Without a code follow Steiner coordinates, corners, neighbours, facets and
/// markers.
struct Report {
  std::int32_t code = kNoCode;  ///< of terminatetetgen()
  std::uint64_t points = 0;
  std::uint64_t tetrahedra = 0;
  std::uint64_t facets = 0;
  std::uint64_t peak_resident = 0;  ///< bytes
};

/// The same, in the parent, still in TetGen's indices.
struct Answer {
  std::vector<double> steiner;
  std::vector<std::array<std::int32_t, 4>> tetrahedra;
  std::vector<std::array<std::int32_t, 4>> neighbors;
  std::vector<std::array<std::int32_t, 3>> facets;
  std::vector<std::int32_t> markers;
};

/// The arrays of a tetgenio, in a few blocks that are never freed: the child ends by _exit().
void fill(tetgenio& input, const TriangleSoup& complex, const CompactComplex& shape) {
  input.numberofpoints = static_cast<int>(shape.vertices.size());
  input.pointlist = new double[3 * shape.vertices.size()];
  double* next = input.pointlist;
  for (const std::uint32_t v : shape.vertices) {
    for (const double coordinate : complex.positions[v]) *next++ = std::ldexp(coordinate, -shape.exponent);
  }
  const std::size_t facets = shape.triangles.size();
  input.numberoffacets = static_cast<int>(facets);
  input.facetlist = new tetgenio::facet[facets];
  input.facetmarkerlist = new int[facets];
  auto* const polygons = new tetgenio::polygon[facets];
  int* const corners = new int[3 * facets];
  for (std::size_t f = 0; f < facets; ++f) {
    std::ranges::copy(shape.triangles[f], corners + 3 * f);
    polygons[f].vertexlist = corners + 3 * f;
    polygons[f].numberofvertices = 3;
    tetgenio::init(&input.facetlist[f]);
    input.facetlist[f].polygonlist = &polygons[f];
    input.facetlist[f].numberofpolygons = 1;
    input.facetmarkerlist[f] = static_cast<int>(f) + 1;  // 0 is TetGen's word for "not of the complex"
  }
}

/// What the child does.
void run_tetgen(const TriangleSoup& complex, const CompactComplex& shape, FacetSplitting splitting, int pipe) {
  Report report;
  // Never destroyed: the destructors would be one more thing that can fail after a failure.
  auto* const input = new tetgenio;
  auto* const output = new tetgenio;
  try {
    fill(*input, complex, shape);
    // p a complex, c all of its hull, Y no splitting, T tolerance, J keep the numbering, Q quiet, n neighbours.
    std::string switches = splitting == FacetSplitting::kNone       ? "pcYJQn"
                           : splitting == FacetSplitting::kNoneNear ? "pcYT1e-14JQn"
                                                                    : "pcT1e-14JQn";
    ::tetrahedralize(switches.data(), input, output, nullptr, nullptr);
    report.points = static_cast<std::uint64_t>(output->numberofpoints);
    report.tetrahedra = static_cast<std::uint64_t>(output->numberoftetrahedra);
    report.facets = static_cast<std::uint64_t>(output->numberoftrifaces);
  } catch (const Terminated& terminated) {
    report.code = terminated.code;
  } catch (const std::bad_alloc&) {
    report.code = kOutOfMemoryCode;
  }
  report.peak_resident = peak_resident_bytes();
  send_to_parent(pipe, &report, sizeof report);
  if (report.code != kNoCode) return;
  const std::size_t given = 3 * shape.vertices.size();
  send_to_parent(pipe, output->pointlist + given, (3 * report.points - given) * sizeof(double));
  send_to_parent(pipe, output->tetrahedronlist, 4 * report.tetrahedra * sizeof(int));
  send_to_parent(pipe, output->neighborlist, 4 * report.tetrahedra * sizeof(int));
  send_to_parent(pipe, output->trifacelist, 3 * report.facets * sizeof(int));
  send_to_parent(pipe, output->trifacemarkerlist, report.facets * sizeof(int));
}

/// Why TetGen gave up, by its code.
std::string refusal(int code) {
  switch (code) {
    case 3:
      return "some of its triangles intersect";
    case 4:
      return "some of its points or triangles are closer than it can tell apart";
    case 5:
      return "some of its triangles are too close to each other";
    case 10:
      return "it sees no complex of triangles in it";
    default:
      return "it could not recover all edges and triangles (code " + std::to_string(code) + ")";
  }
}

[[noreturn]] void throw_refused(const std::string& why) {
  throw TetgenFailure(Kind::kRefused, "TetGen refused the model: " + why);
}

[[noreturn]] void throw_nonsense() {
  throw TetgenFailure(Kind::kCrashed, "TetGen's answer makes no sense");
}

TetgenFailure explained(const ChildFailure& failure, const ChildLimits& limits) {
  switch (failure.end) {
    case ChildEnd::kTimeLimit:
      return {Kind::kTimeLimit, "TetGen took longer than " + format_real(limits.seconds) + " s; raise its time limit"};
    case ChildEnd::kMemoryLimit:
      return {Kind::kMemoryLimit, "TetGen needs more than " + format_bytes(limits.bytes) + "; raise its memory limit"};
    case ChildEnd::kCrashed:
      break;
  }
  const std::string signal = failure.signal == 0 ? "" : " (signal " + std::to_string(failure.signal) + ")";
  return {Kind::kCrashed, "TetGen crashed" + signal + ", as it does where triangles intersect or nearly do"};
}

Answer ask_tetgen(const TriangleSoup& complex, const CompactComplex& shape, FacetSplitting splitting,
                  const ChildLimits& limits, Stage& stage, Tetrahedralization& result) {
  WatchedChild child(limits, stage, [&](int pipe) { run_tetgen(complex, shape, splitting, pipe); });
  Report report;
  child.receive(&report, sizeof report);
  if (report.code == kOutOfMemoryCode) throw ChildFailure{ChildEnd::kMemoryLimit, 0};
  child.note_peak(report.peak_resident);
  if (report.code != kNoCode) throw_refused(refusal(report.code));
  // No more is allocated here than the child held, whatever a broken heap there made of the counts.
  const auto receive = [&]<class T>(std::vector<T>& values, std::uint64_t count) {
    if (count > std::min<std::uint64_t>(limits.bytes / sizeof(T), std::numeric_limits<std::int32_t>::max())) {
      throw_nonsense();
    }
    values.resize(count);
    child.receive(values.data(), count * sizeof(T));
  };
  if (report.points < shape.vertices.size()) throw_nonsense();
  Answer answer;
  receive(answer.steiner, 3 * (report.points - shape.vertices.size()));
  receive(answer.tetrahedra, report.tetrahedra);
  receive(answer.neighbors, report.tetrahedra);
  receive(answer.facets, report.facets);
  receive(answer.markers, report.facets);
  result.peak_bytes = child.peak_bytes();
  return answer;
}

/// Indices in range, neighbours mutual, and every point of the model in use: TetGen drops points that it finds too
/// close to another one, without a word. Returns which points are in use; Steiner points that were taken out again are
/// not.
std::vector<char> check_cells(const Answer& answer, const CompactComplex& shape) {
  const auto cells = static_cast<std::int64_t>(answer.tetrahedra.size());
  const std::size_t given = shape.vertices.size();
  const auto points = static_cast<std::int64_t>(given + answer.steiner.size() / 3);
  if (cells == 0) throw_nonsense();
  std::vector<char> used(static_cast<std::size_t>(points), 0);
  for (std::int64_t t = 0; t < cells; ++t) {
    for (const std::int32_t v : answer.tetrahedra[static_cast<std::size_t>(t)]) {
      if (v < 0 || v >= points) throw_nonsense();
      used[static_cast<std::size_t>(v)] = 1;
    }
    for (const std::int32_t n : answer.neighbors[static_cast<std::size_t>(t)]) {
      if (n < -1 || n >= cells) throw_nonsense();
      if (n >= 0 && std::ranges::count(answer.neighbors[static_cast<std::size_t>(n)], t) == 0) throw_nonsense();
    }
  }
  const auto unused = static_cast<std::size_t>(std::ranges::find(used, 0) - used.begin());
  if (unused < given) {
    throw_refused("vertex " + std::to_string(shape.vertices[unused]) + " is too close to another one");
  }
  return used;
}

void check_facets(const Answer& answer, const CompactComplex& shape, const std::vector<char>& used) {
  const std::size_t sources = shape.triangles.size();
  for (std::size_t f = 0; f < answer.facets.size(); ++f) {
    if (answer.markers[f] < 0 || static_cast<std::size_t>(answer.markers[f]) > sources) throw_nonsense();
    for (const std::int32_t v : answer.facets[f]) {
      if (v < 0 || static_cast<std::size_t>(v) >= used.size() || used[static_cast<std::size_t>(v)] == 0) {
        throw_nonsense();
      }
    }
  }
}

/// Points of the result; returns what each of TetGen's has become.
std::vector<std::uint32_t> take_points(const Answer& answer, const TriangleSoup& complex, const CompactComplex& shape,
                                       const std::vector<char>& used, Tetrahedralization& result) {
  result.points = complex.positions;
  std::vector<std::uint32_t> index_of = shape.vertices;
  for (std::size_t i = 0; i < answer.steiner.size() / 3; ++i) {
    index_of.push_back(static_cast<std::uint32_t>(result.points.size()));
    if (used[shape.vertices.size() + i] == 0) continue;
    const Point scaled(answer.steiner[3 * i], answer.steiner[3 * i + 1], answer.steiner[3 * i + 2]);
    result.points.push_back(scaled.unaryExpr([&](double c) { return std::ldexp(c, shape.exponent); }));
  }
  result.steiner_points = result.points.size() - complex.positions.size();
  return index_of;
}

/// The facets that are parts of the complex's triangles, in the order of these, facing where they do.
void take_facets(const Answer& answer, const CompactComplex& shape, FacetSplitting splitting,
                 const std::vector<std::uint32_t>& index_of, Tetrahedralization& result) {
  std::vector<std::size_t> order;
  for (std::size_t f = 0; f < answer.facets.size(); ++f) {
    if (answer.markers[f] > 0) order.push_back(f);
  }
  std::ranges::stable_sort(order, {}, [&](std::size_t f) { return answer.markers[f]; });
  std::size_t next = 0;
  for (std::size_t s = 0; s < shape.triangles.size(); ++s) {
    Triangle whole = shape.triangles[s];
    for (std::uint32_t& v : whole) v = index_of[v];
    const std::size_t first = next;
    for (; next < order.size() && static_cast<std::size_t>(answer.markers[order[next]]) == s + 1; ++next) {
      Triangle part{};
      std::ranges::transform(answer.facets[order[next]], part.begin(),
                             [&](std::int32_t v) { return index_of[static_cast<std::size_t>(v)]; });
      const auto corners = [&](const Triangle& t) {
        return std::array<Point, 3>{result.points[t[0]], result.points[t[1]], result.points[t[2]]};
      };
      if (std::ranges::is_permutation(part, whole)) {
        part = whole;
      } else if (faces_the_other_way(corners(part), corners(whole))) {
        std::swap(part[1], part[2]);
      }
      result.facets.push_back(part);
      result.facet_source.push_back(shape.sources[s]);
    }
    const bool is_whole = next == first + 1 && result.facets.back() == whole;
    if (next > first && (is_whole || splitting == FacetSplitting::kAllowed)) continue;
    throw_refused("it could not recover triangle " + std::to_string(shape.sources[s]));
  }
}

/// Split facets are not always faces of tetrahedra, where points nearly coincide; whole ones are.
void require_faces(const Tetrahedralization& result) {
  const auto sorted = [](Triangle t) {
    std::ranges::sort(t);
    return t;
  };
  std::vector<Triangle> faces;
  faces.reserve(4 * result.tetrahedra.size());
  for (const auto& [a, b, c, d] : result.tetrahedra) {
    for (const Triangle& face : {Triangle{a, b, c}, Triangle{a, b, d}, Triangle{a, c, d}, Triangle{b, c, d}}) {
      faces.push_back(sorted(face));
    }
  }
  std::ranges::sort(faces);
  for (std::size_t f = 0; f < result.facets.size(); ++f) {
    if (std::ranges::binary_search(faces, sorted(result.facets[f]))) continue;
    throw_refused("it lost a part of triangle " + std::to_string(result.facet_source[f]));
  }
}

/// TetGen orders the corners of all tetrahedra by one rule; which one, the sense of most of a few of them tells, for a
/// single one may have been turned inside out when a Steiner point was rounded.
bool negatively_oriented(const Tetrahedralization& result) {
  constexpr std::size_t kFew = 1024;
  int sum = 0;
  for (std::size_t t = 0; t < std::min(kFew, result.tetrahedra.size()); ++t) {
    const auto& [a, b, c, d] = result.tetrahedra[t];
    sum += orientation(result.points[a], result.points[b], result.points[c], result.points[d]);
  }
  return sum < 0;
}

}  // namespace

Tetrahedralization tetrahedralize(const TriangleSoup& model, FacetSplitting splitting, const TetgenLimits& limits,
                                  RunContext& context, std::span<const Point> more_points) {
  validate(model, "the complex");
  TriangleSoup complex = model;
  complex.positions.insert(complex.positions.end(), more_points.begin(), more_points.end());
  ChildLimits child_limits{.seconds = limits.seconds,
                           .bytes = limits.bytes == 0 ? context.memory_budget : limits.bytes};
  Stage stage(context, "tetrahedralization", static_cast<std::int64_t>(complex.triangles.size()));
  context.require_memory(kBytesPerTriangle * complex.triangles.size() + kBytesPerPoint * complex.positions.size(),
                         "the tetrahedralization");
  if (std::max(complex.triangles.size(), complex.positions.size()) > kMostElements) {
    throw TetgenFailure(Kind::kRefused, "the model has more elements than TetGen can number");
  }
  const CompactComplex shape = compact(complex, more_points.size());
  require_solid(complex, shape, stage);

  Tetrahedralization result;
  Answer answer;
  try {
    answer = ask_tetgen(complex, shape, splitting, child_limits, stage, result);
  } catch (const ChildFailure& failure) {
    throw explained(failure, child_limits);
  }
  const std::vector<char> used = check_cells(answer, shape);
  check_facets(answer, shape, used);
  stage.advance(0);

  const std::vector<std::uint32_t> index_of = take_points(answer, complex, shape, used, result);
  for (const auto& cell : answer.tetrahedra) {
    std::ranges::transform(cell, result.tetrahedra.emplace_back().begin(),
                           [&](std::int32_t v) { return index_of[static_cast<std::size_t>(v)]; });
  }
  result.neighbors = std::move(answer.neighbors);
  if (negatively_oriented(result)) {
    for (auto& cell : result.tetrahedra) std::swap(cell[0], cell[1]);
    for (auto& cell : result.neighbors) std::swap(cell[0], cell[1]);
  }
  take_facets(answer, shape, splitting, index_of, result);
  if (splitting == FacetSplitting::kAllowed) require_faces(result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - child_limits.start).count();
  return result;
}

}  // namespace voxcarve
