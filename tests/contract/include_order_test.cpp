// Who may include whom: common <- methods, common <- metrics, these <- experiments <- tests; no method includes another
// or a metric, no metric a method; heavy third-party headers stay in .cpp files.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace voxcarve {
namespace {

struct Include {
  std::string from;  ///< path in the project, '/' separated
  std::string to;
};

std::vector<Include> all_includes() {
  const std::filesystem::path root = VOXCARVE_SOURCE_DIR;
  static const std::regex kInclude(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const char* folder : {"common", "methods", "metrics", "experiments", "tests"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / folder)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      std::smatch match;
      for (std::string line; std::getline(file, line);) {
        if (std::regex_search(line, match, kInclude))
          includes.push_back({std::filesystem::relative(entry.path(), root).generic_string(), match[1]});
      }
    }
  }
  return includes;
}

std::string top(const std::string& path) {
  return path.substr(0, path.find('/'));
}

/// "nooruddin_turk" for a file in methods/nooruddin_turk, "" for methods/ itself.
std::string method_folder(const std::string& path) {
  const std::size_t first = path.find('/');
  const std::size_t second = path.find('/', first + 1);
  return second == std::string::npos ? "" : path.substr(first + 1, second - first - 1);
}

TEST(IncludeOrder, EveryLayerIncludesOnlyThoseBelow) {
  const std::map<std::string, std::set<std::string>> allowed = {
      {"common", {"common"}},
      {"methods", {"common", "methods"}},
      {"metrics", {"common", "metrics"}},
      {"experiments", {"common", "methods", "metrics", "experiments"}},
      {"tests", {"common", "methods", "metrics", "experiments", "tests"}},
  };
  std::size_t ours = 0;
  for (const Include& include : all_includes()) {
    if (!allowed.contains(top(include.to)) || include.to.find('/') == std::string::npos)
      continue;  // not of this project
    ++ours;
    EXPECT_TRUE(allowed.at(top(include.from)).contains(top(include.to))) << include.from << " includes " << include.to;
    if (top(include.from) == "methods" && !method_folder(include.to).empty() && top(include.to) == "methods") {
      EXPECT_EQ(method_folder(include.from), method_folder(include.to)) << include.from << " includes " << include.to;
    }
  }
  EXPECT_GT(ours, 100U);  // the reading itself works
}

TEST(IncludeOrder, HeavyHeadersStayInSourceFiles) {
  static const std::regex kHeavy(R"(^(CGAL/|OpenMesh/|vtk|tetgen|EGL/|GL/|epoxy/).*)");
  std::size_t heavy = 0;
  for (const Include& include : all_includes()) {
    if (!std::regex_match(include.to, kHeavy)) continue;
    ++heavy;
    EXPECT_TRUE(include.from.ends_with(".cpp")) << include.from << " includes " << include.to;
  }
  EXPECT_GT(heavy, 5U);
}

}  // namespace
}  // namespace voxcarve
