#include "methods/hagbi_elsana/stream_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "common/mesh/models/primitives.h"
#include "common/mesh/topology.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"
#include "tests/support/carving.h"
#include "tests/support/shapes.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kNone = 0xffffffffU;
constexpr std::size_t kHeader = 32;

/// Where the parts of a file are, by the table in stream_file.h.
struct Layout {
  explicit Layout(const CarvingStream& stream)
      : points(stream.complement().points.size()),
        tetrahedra(stream.complement().size()),
        carvable(stream.complement().first_ghost),
        coordinates(kHeader + stream.provenance().size()),
        solids(coordinates + 24 * points),
        corners(solids + 4 * points),
        neighbors(corners + 16 * tetrahedra),
        walls(neighbors + 16 * tetrahedra),
        steps(walls + tetrahedra),
        checksum(steps + 4 * carvable) {}

  std::size_t points, tetrahedra, carvable;
  std::size_t coordinates, solids, corners, neighbors, walls, steps, checksum;
};

std::uint32_t word(const std::string& bytes, std::size_t at) {
  return load<std::uint32_t>(bytes.data() + at, std::endian::little);
}

void set_word(std::string& bytes, std::size_t at, std::uint32_t value) {
  std::string text;
  append_little_endian(text, value);
  bytes.replace(at, text.size(), text);
}

/// Makes the checksum that of the bytes.
std::string sealed(std::string bytes) {
  const std::size_t length = bytes.size() - 4;
  const uLong checksum =
      crc32(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(length));
  set_word(bytes, length, static_cast<std::uint32_t>(checksum));
  return bytes;
}

class StreamFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "voxcarve-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    path_ = folder_ / "altered.vcs";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string bytes_of(const CarvingStream& stream) const {
    const fs::path path = folder_ / "stream.vcs";
    write_stream(stream, path);
    return content(path);
  }
  static std::string content(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }
  CarvingStream read_bytes(const std::string& bytes) const {
    fs::remove(path_);  // some file systems wait for the disk when a file is overwritten
    std::ofstream(path_, std::ios::binary) << bytes;
    RunContext context;
    return read_stream(path_, context);
  }
  /// Nothing when the bytes are read, else the reason.
  std::optional<std::string> refusal(const std::string& bytes) const {
    try {
      read_bytes(bytes);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(path_.string() + ": "));
      return error.what();
    }
    return std::nullopt;
  }
  void expect_refused(const std::string& bytes, const std::string& part) const {
    const auto reason = refusal(bytes);
    ASSERT_TRUE(reason.has_value()) << part;
    EXPECT_THAT(*reason, testing::HasSubstr(part));
  }

  fs::path folder_;
  fs::path path_;
};

/// Two tetrahedra, one of which lies askew behind the other.
TriangleSoup two_tetrahedra() {
  TriangleSoup one;
  one.positions = {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)};
  one.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  TriangleSoup other = one;
  for (Point& p : other.positions) p += Point(2, 0.3, 0.2);
  return test::joined({one, other});
}

/// Voids, one of them shut; a sheet beside.
CarvingStream rich_stream() {
  const auto sphere = [](double radius) { return uv_sphere(Point(0, 0, 0), radius, 8, 6); };
  TriangleSoup model = test::joined({sphere(3), as_cavity(sphere(2)), sphere(1), as_cavity(sphere(0.5))});
  TriangleSoup sheet;
  sheet.positions = {Point(4, 0, 0), Point(5, 0, 0.1), Point(4.5, 1, 0.3)};
  sheet.triangles = {{0, 1, 2}};
  append(model, sheet);
  CarvingOptions options;
  options.smallest_void = 1;
  return test::carved(model, options, true);
}

TEST_F(StreamFile, GivesBackEveryByteOfEveryLevel) {
  for (const CarvingStream& stream : {test::carved(two_tetrahedra()), test::carved(torus(2, 0.7, 16, 8)), rich_stream(),
                                      test::carved(box(Point(0, 0, 0), Point(1, 1, 1)))}) {
    const std::string bytes = bytes_of(stream);
    const CarvingStream again = read_bytes(bytes);
    ASSERT_EQ(again.last_step(), stream.last_step());
    EXPECT_EQ(again.provenance(), "test");
    EXPECT_EQ(again.levels(), stream.levels());
    EXPECT_EQ(again.closed_components(RunContext()), stream.closed_components(RunContext()));
    EXPECT_EQ(again.steps(), stream.steps());
    EXPECT_EQ(again.complement().model_points, stream.complement().model_points);
    for (std::uint32_t step = 0; step <= stream.last_step(); ++step) {
      EXPECT_EQ(again.vertices(step), stream.vertices(step));
      EXPECT_EQ(again.triangles(step), stream.triangles(step));
      EXPECT_EQ(again.extract(step), stream.extract(step));
    }
    EXPECT_EQ(bytes_of(again), bytes);
    EXPECT_EQ(bytes.size(), Layout(stream).checksum + 4);
  }
}

TEST_F(StreamFile, KeepsAnyProvenance) {
  const CarvingStream stream = test::carved(two_tetrahedra());
  RunContext context;
  for (const std::string& text : {std::string(), std::string("a\0b\n", 4), std::string(3 << 20, 'x')}) {
    const CarvingStream other(stream.complement(), stream.steps(), text, context);
    EXPECT_EQ(read_bytes(bytes_of(other)).provenance(), text);
  }
}

TEST_F(StreamFile, IsRefusedAtEveryOtherLength) {
  const std::string bytes = bytes_of(test::carved(two_tetrahedra()));
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_TRUE(refusal(bytes.substr(0, length)).has_value()) << length;
    // With a checksum of its own, too.
    if (length < 4) continue;
    EXPECT_TRUE(refusal(sealed(bytes.substr(0, length))).has_value()) << length;
  }
  EXPECT_TRUE(refusal(bytes + '\0').has_value());
  EXPECT_TRUE(refusal(bytes + bytes).has_value());
  EXPECT_FALSE(refusal(bytes).has_value());
}

TEST_F(StreamFile, IsRefusedWithAnyByteAltered) {
  const std::string bytes = bytes_of(test::carved(two_tetrahedra()));
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int flip : {0x01, 0x80, 0xff}) {
      std::string altered = bytes;
      altered[at] = static_cast<char>(altered[at] ^ flip);
      EXPECT_TRUE(refusal(altered).has_value()) << at << " ^ " << flip;
    }
  }
}

TEST_F(StreamFile, SaysWhatIsWrong) {
  const CarvingStream stream = test::carved(two_tetrahedra());
  const std::string bytes = bytes_of(stream);
  const Layout at(stream);
  const auto with_word = [&](std::size_t where, std::uint32_t value) {
    std::string altered = bytes;
    set_word(altered, where, value);
    return sealed(altered);
  };
  expect_refused("", "is no carving stream");
  expect_refused("PLY" + bytes.substr(3), "is no carving stream");
  expect_refused(bytes.substr(0, 20), "ends within its header");
  expect_refused(with_word(8, 2), "version 2");
  for (const std::size_t count : {12U, 16U, 24U, 28U}) {
    expect_refused(with_word(count, word(bytes, count) + 1), "where its header says");
    expect_refused(with_word(count, kNone), "where its header says");
  }
  expect_refused(with_word(20, static_cast<std::uint32_t>(at.points) + 1), "header contradicts itself");
  std::string flipped = bytes;
  flipped[at.coordinates] = static_cast<char>(flipped[at.coordinates] ^ 1);
  expect_refused(flipped, "checksum");
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::string text;
    append_little_endian(text, bad);
    std::string altered = bytes;
    expect_refused(sealed(altered.replace(at.coordinates + 8, text.size(), text)), "not finite");
  }
  expect_refused(with_word(at.solids, static_cast<std::uint32_t>(at.points)), "component");
  expect_refused(with_word(at.corners, static_cast<std::uint32_t>(at.points)), "corner that is no point");
  expect_refused(with_word(at.corners, word(bytes, at.corners + 4)), "corner twice");
  expect_refused(with_word(at.corners + 12, kNone), "ghost");
  expect_refused(with_word(at.corners + 16 * at.carvable + 12, 0), "ghost");
  expect_refused(with_word(at.neighbors, 0), "does not fit its neighbours");  // tetrahedron 0 beside itself
  expect_refused(with_word(at.neighbors, static_cast<std::uint32_t>(at.tetrahedra)), "does not fit its neighbours");
  expect_refused(with_word(at.neighbors + 16 * at.carvable, kNone), "does not fit its neighbours");
  expect_refused(with_word(at.steps, 0), "impossible step");
  expect_refused(with_word(at.steps, 0x7fffffff), "steps that carve nothing");
  std::string walls = bytes;
  walls[at.walls] = 16;
  expect_refused(sealed(walls), "walls");
}

/// Whatever is accepted can be used: every level is closed, and every query ends.
void use(const CarvingStream& stream) {
  EXPECT_EQ(stream.closed_components(RunContext()).size(), std::size_t{stream.last_step()} + 1);
  for (std::uint32_t step = 0; step <= stream.last_step(); ++step) {
    const TriangleSoup surface = stream.extract(step);
    EXPECT_EQ(surface.triangles.size(), stream.triangles(step));
    const SurfaceTopology topology = analyze_topology(surface);
    EXPECT_TRUE(topology.closed && topology.oriented) << step;
    EXPECT_LE(stream.step_for_vertices(stream.vertices(step)), stream.last_step());
  }
}

TEST_F(StreamFile, ContradictionsUnderATrueChecksumAreRefused) {
  const CarvingStream stream = test::carved(two_tetrahedra());
  const std::string bytes = bytes_of(stream);
  const Layout at(stream);
  const auto points = static_cast<std::uint32_t>(at.points);
  const auto tetrahedra = static_cast<std::uint32_t>(at.tetrahedra);
  const auto carvable = static_cast<std::uint32_t>(at.carvable);
  std::vector<std::size_t> words;  // all but the provenance and the coordinates, of which any will do
  for (const auto& [begin, end] :
       {std::pair<std::size_t, std::size_t>{8, kHeader}, {at.solids, at.walls}, {at.steps, at.checksum}}) {
    for (std::size_t where = begin; where < end; where += 4) words.push_back(where);
  }
  for (const std::size_t where : words) {
    const std::uint32_t before = word(bytes, where);
    for (const std::uint32_t value : {0U, 1U, before + 1, before - 1, before ^ 3, points - 1, points, tetrahedra - 1,
                                      tetrahedra, carvable - 1, carvable, 0x7fffffffU, 0x80000000U, kNone - 1, kNone}) {
      if (value == before) continue;
      std::string altered = bytes;
      set_word(altered, where, value);
      altered = sealed(altered);
      const bool refused = refusal(altered).has_value();
      if (!refused) use(read_bytes(altered));
      // Counts are contradicted by the length, but for that of the model's points; neighbours by those on their side.
      const bool in_neighbors = where >= at.neighbors && where < at.walls;
      if ((where < kHeader && where != 20) || in_neighbors) {
        EXPECT_TRUE(refused) << "at " << where << ": " << value;
      }
    }
  }
  for (std::size_t t = 0; t < at.tetrahedra; ++t) {
    for (const int bits : {1, 2, 4, 8, 15, 16, 128}) {
      std::string altered = bytes;
      altered[at.walls + t] = static_cast<char>(altered[at.walls + t] ^ bits);
      altered = sealed(altered);
      if (!refusal(altered)) use(read_bytes(altered));
    }
  }
}

TEST_F(StreamFile, ChangesThatFitTogetherLeadNowhereAstray) {
  // Walls and solids on both sides of a face, any points and any steps: nothing for which extraction may not end.
  const CarvingStream stream = test::carved(torus(2, 0.7, 8, 5));
  const std::string bytes = bytes_of(stream);
  const Layout at(stream);
  const Complement& mesh = stream.complement();
  std::mt19937_64 generator(11);
  const auto random = [&](std::size_t count) { return static_cast<std::size_t>(generator() % count); };
  int used = 0;
  for (int round = 0; round < 60; ++round) {
    std::string altered = bytes;
    for (int change = 0; change < 40; ++change) {
      const std::size_t t = random(at.carvable);
      const std::size_t i = random(4);
      const std::uint32_t other = mesh.neighbors[t][i];
      if (other == Complement::kSolid) continue;
      const auto j = static_cast<std::size_t>(std::ranges::find(mesh.neighbors[other], static_cast<std::uint32_t>(t)) -
                                              mesh.neighbors[other].begin());
      if (change % 2 == 0) {
        set_word(altered, at.neighbors + 16 * t + 4 * i, kNone);
        set_word(altered, at.neighbors + 16 * other + 4 * j, kNone);
      } else {
        altered[at.walls + t] = static_cast<char>(altered[at.walls + t] | 1 << i);
        altered[at.walls + other] = static_cast<char>(altered[at.walls + other] | 1 << j);
      }
    }
    if (round % 2 == 0) {
      for (std::size_t t = 0; t < at.carvable; ++t) {
        const std::size_t step = random(at.carvable + 1);
        set_word(altered, at.steps + 4 * t, step == 0 ? kNone : static_cast<std::uint32_t>(step));
      }
    }
    altered = sealed(altered);
    if (refusal(altered)) continue;
    ++used;
    use(read_bytes(altered));
  }
  EXPECT_GT(used, 0);
}

TEST_F(StreamFile, PermutedCornersAndExchangedNeighboursAreRefused) {
  const CarvingStream stream = test::carved(torus(2, 0.7, 8, 5));
  const std::string bytes = bytes_of(stream);
  const Layout at(stream);
  for (std::size_t t = 0; t < at.tetrahedra; ++t) {
    for (const std::size_t list : {at.corners, at.neighbors}) {
      const std::size_t where = list + 16 * t;
      if (word(bytes, where) == word(bytes, where + 4)) continue;  // twice the solid
      std::string altered = bytes;
      set_word(altered, where, word(bytes, where + 4));
      set_word(altered, where + 4, word(bytes, where));
      EXPECT_TRUE(refusal(sealed(altered)).has_value()) << t;
    }
  }
}

TEST_F(StreamFile, WritesTheWholeFileOrNothing) {
  const CarvingStream stream = test::carved(two_tetrahedra());
  const auto count = [](const fs::path& folder) {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  };
  EXPECT_THROW(write_stream(stream, folder_ / "missing" / "x.vcs"), ResourceError);
  EXPECT_EQ(count(folder_), 0);
  fs::create_directory(folder_ / "folder.vcs");
  EXPECT_THROW(write_stream(stream, folder_ / "folder.vcs"), ResourceError);
  EXPECT_EQ(count(folder_), 1);  // no partial file beside it
  EXPECT_EQ(count(folder_ / "folder.vcs"), 0);
  std::ofstream(folder_ / "x.vcs") << "old";
  write_stream(stream, folder_ / "x.vcs");
  EXPECT_EQ(count(folder_), 2);
  EXPECT_EQ(content(folder_ / "x.vcs").size(), Layout(stream).checksum + 4);
}

TEST_F(StreamFile, MissingFilesAndFoldersAreNoStreams) {
  RunContext context;
  EXPECT_THROW(read_stream(folder_ / "none.vcs", context), InputError);
  EXPECT_THROW(read_stream(folder_, context), InputError);
}

TEST_F(StreamFile, StaysWithinTheMemoryBudget) {
  const fs::path path = folder_ / "x.vcs";
  write_stream(test::carved(two_tetrahedra()), path);
  RunContext context;
  context.memory_budget = 1000;
  EXPECT_THROW(read_stream(path, context), ResourceError);
}

TEST(StreamFileName, EndsInVcs) {
  EXPECT_TRUE(is_stream_file("a/b.vcs"));
  EXPECT_FALSE(is_stream_file("b.ply"));
  EXPECT_FALSE(is_stream_file("vcs"));
  EXPECT_FALSE(is_stream_file(""));
}

}  // namespace
}  // namespace voxcarve
