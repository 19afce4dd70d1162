// What the tests of the procedural models check again and again.
#pragma once

#include <gmock/gmock-matchers.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/mesh/models/catalogue.h"
#include "common/mesh/models/primitives.h"
#include "common/mesh/models/procedural.h"
#include "common/run/errors.h"

namespace voxcarve::test {

using std::numbers::pi;
using testing::HasSubstr;

// Relative error of sums of up to a few hundred thousand products of doubles.
constexpr double kRounding = 1e-11;

inline void expect_relative(double actual, double expected) {
  EXPECT_NEAR(actual, expected, kRounding * std::abs(expected));
}

/// The connected components by shared vertices, each with the vertices that it uses.
inline std::vector<TriangleSoup> parts_of(const TriangleSoup& soup) {
  std::vector<std::uint32_t> parent(soup.positions.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b, c] : soup.triangles) {
    parent[root(b)] = root(a);
    parent[root(c)] = root(a);
  }
  std::map<std::uint32_t, std::vector<std::size_t>> triangles_of;
  for (std::size_t t = 0; t < soup.triangles.size(); ++t) triangles_of[root(soup.triangles[t][0])].push_back(t);
  std::vector<TriangleSoup> parts;
  for (const auto& [name, triangles] : triangles_of) {
    TriangleSoup part;
    std::map<std::uint32_t, std::uint32_t> renamed;
    for (const std::size_t t : triangles) {
      Triangle triangle{};
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = soup.triangles[t][corner];
        const auto [entry, added] = renamed.try_emplace(vertex, static_cast<std::uint32_t>(part.positions.size()));
        if (added) part.positions.push_back(soup.positions[vertex]);
        triangle[corner] = entry->second;
      }
      part.triangles.push_back(triangle);
      if (!soup.triangle_colors.empty()) part.triangle_colors.push_back(soup.triangle_colors[t]);
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

using Edge = std::array<std::uint32_t, 2>;

inline std::vector<Edge> sorted_directed_edges(const TriangleSoup& soup) {
  std::vector<Edge> edges;
  for (const auto& [a, b, c] : soup.triangles) edges.insert(edges.end(), {{a, b}, {b, c}, {c, a}});
  std::ranges::sort(edges);
  return edges;
}

/// True when the triangles about every vertex form a single fan: as many as the fan that starts at one of them.
inline bool has_single_fans(const TriangleSoup& soup) {
  std::map<Edge, std::uint32_t> opposite;
  std::vector<std::size_t> degree(soup.positions.size(), 0);
  std::vector<Edge> start(soup.positions.size());
  for (const Triangle& t : soup.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      opposite[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
      ++degree[t[i]];
      start[t[i]] = {t[i], t[(i + 1) % 3]};
    }
  }
  for (std::uint32_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    std::size_t steps = 0;
    Edge edge = start[vertex];
    do {
      edge[1] = opposite.at(edge);
      ++steps;
    } while (edge != start[vertex] && steps <= degree[vertex]);
    if (steps != degree[vertex]) return false;
  }
  return true;
}

/// Closed, consistently oriented, without degenerate triangles, without unused vertices.
inline void expect_closed(const TriangleSoup& soup, const std::string& name) {
  SCOPED_TRACE(name);
  validate(soup, name);
  const std::vector<Edge> edges = sorted_directed_edges(soup);
  EXPECT_EQ(std::ranges::adjacent_find(edges), edges.end()) << "a directed edge stands in two triangles";
  std::size_t unmatched = 0;
  for (const Edge& edge : edges) unmatched += std::ranges::binary_search(edges, Edge{edge[1], edge[0]}) ? 0 : 1;
  EXPECT_EQ(unmatched, 0U);
  const auto degenerate = [&](const Triangle& triangle) { return is_degenerate(soup, triangle); };
  EXPECT_EQ(std::ranges::count_if(soup.triangles, degenerate), 0);
  TriangleSoup used = soup;
  remove_unused_vertices(used);
  EXPECT_EQ(used.positions.size(), soup.positions.size());
}

/// Of one closed component: 2 - 2 genus = V - E + F, and E = 3 F / 2.
inline long genus_of(const TriangleSoup& part) {
  const auto vertices = static_cast<long>(part.positions.size());
  const auto triangles = static_cast<long>(part.triangles.size());
  const long euler = vertices - 3 * triangles / 2 + triangles;
  EXPECT_EQ(euler % 2, 0);
  return (2 - euler) / 2;
}

inline std::string parameter_error(const std::string& spec) {
  try {
    make_procedural(spec);
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no ParameterError";
}

inline double polygon_area(int sides, double circumradius) {
  return sides / 2.0 * circumradius * circumradius * std::sin(2 * pi / sides);
}

// --- building blocks ---------------------------------------------------------------------------------------------

inline std::vector<std::string> model_names() {
  std::vector<std::string> names;
  for (const ProceduralModel& model : procedural_models()) names.push_back(model.info.name);
  return names;
}

}  // namespace voxcarve::test
