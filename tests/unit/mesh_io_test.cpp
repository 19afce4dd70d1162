#include "common/mesh/io/mesh_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include "common/run/atomic_file.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

/// A folder that lasts as long as the test.
class MeshIo : public ::testing::Test {
 protected:
  MeshIo() {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / ("voxcarve_mesh_io_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder);
  }
  ~MeshIo() override { fs::remove_all(folder); }

  std::size_t files_in_folder() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  fs::path folder;
};

Color bytes_color(int red, int green, int blue) {
  return Color(static_cast<float>(red), static_cast<float>(green), static_cast<float>(blue)) / 255.0F;
}

/// A tetrahedron whose coordinates need all digits, or are tiny, huge or -0.
TriangleSoup sample_soup(bool vertex_colors, bool triangle_colors) {
  TriangleSoup soup;
  soup.positions = {{0.1, 1.0 / 3.0, -0.0}, {1e-300, 5e-324, 1e300}, {-1.5, 123456789.123456789, 2}, {1, 2, 3}};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  if (vertex_colors) {
    soup.vertex_colors = {bytes_color(0, 0, 0), bytes_color(255, 1, 2), bytes_color(17, 254, 128),
                          bytes_color(1, 1, 1)};
  }
  if (triangle_colors) {
    soup.triangle_colors = {bytes_color(1, 0, 1), bytes_color(1, 0, 1), bytes_color(200, 100, 50),
                            bytes_color(0, 0, 0)};
  }
  return soup;
}

/// The message of the InputError that parsing gives; "" when it gives none.
std::string refusal(MeshFormat format, std::string_view bytes) {
  try {
    parse_mesh(format, bytes, "file");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MeshFormat, ComesFromTheExtensionInEitherCase) {
  EXPECT_EQ(mesh_format("a/b.ply"), MeshFormat::kPly);
  EXPECT_EQ(mesh_format("B.OBJ"), MeshFormat::kObj);
  EXPECT_EQ(mesh_format("x.y.Off"), MeshFormat::kOff);
  EXPECT_EQ(mesh_format("x.sTl"), MeshFormat::kStl);
  EXPECT_EQ(mesh_format("x.nrrd"), std::nullopt);
  EXPECT_EQ(mesh_format("ply"), std::nullopt);
}

// Writing and reading back.

struct RoundTrip {
  MeshFormat format;
  bool binary;
};

class MeshRoundTrip : public ::testing::TestWithParam<RoundTrip> {};

TEST_P(MeshRoundTrip, GivesTheSameSoup) {
  for (const bool vertex_colors : {false, true}) {
    for (const bool triangle_colors : {false, true}) {
      const TriangleSoup soup = sample_soup(vertex_colors, triangle_colors);
      const WriteOptions options{.binary = GetParam().binary, .material_library = "m.mtl"};
      const MaterialLoader loader = [&soup](std::string_view file) -> std::optional<std::string> {
        return file == "m.mtl" ? std::optional(serialize_materials(soup)) : std::nullopt;
      };
      const std::string bytes = serialize_mesh(soup, GetParam().format, options);
      const TriangleSoup back = parse_mesh(GetParam().format, bytes, "file", loader);
      EXPECT_EQ(back, soup) << bytes;
      EXPECT_TRUE(std::signbit(back.positions[0][2])) << "-0 lost its sign";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AllFormats, MeshRoundTrip,
                         ::testing::Values(RoundTrip{MeshFormat::kPly, true}, RoundTrip{MeshFormat::kPly, false},
                                           RoundTrip{MeshFormat::kObj, true}, RoundTrip{MeshFormat::kOff, true}));

TEST(MeshWrite, QuantisesColoursToTheNearestByteAndClamps) {
  TriangleSoup soup = sample_soup(true, false);
  // 0.5 * 255 = 127.5 rounds away from zero to 128; 0.3 * 255 = 76.5 + 1.2e-6 in single precision gives 77.
  soup.vertex_colors[0] = {0.5F, -1.0F, 2.0F};
  const TriangleSoup back = parse_mesh(MeshFormat::kPly, serialize_mesh(soup, MeshFormat::kPly), "file");
  EXPECT_EQ(back.vertex_colors[0], bytes_color(128, 0, 255));
}

TEST(MeshWrite, RefusesAnInvalidSoup) {
  TriangleSoup soup = sample_soup(false, false);
  soup.triangles[0][0] = 4;
  EXPECT_THROW(serialize_mesh(soup, MeshFormat::kPly), InputError);
  EXPECT_THROW(serialize_mesh(TriangleSoup{}, MeshFormat::kStl), InputError);
}

// STL keeps single precision in binary, all digits in text, and merges corners at one position.
TEST(Stl, MergesEqualCorners) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.25}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {3, 4, 5}};
  for (const bool binary : {true, false}) {
    const std::string bytes = serialize_mesh(soup, MeshFormat::kStl, {.binary = binary});
    EXPECT_EQ(bytes.size() == 84U + 2 * 50U, binary);
    const TriangleSoup back = parse_mesh(MeshFormat::kStl, bytes, "file");
    EXPECT_EQ(back.positions, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0.25}}));
    EXPECT_EQ(back.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 1, 2}}));
  }
}

TEST(Stl, TextKeepsAllDigits) {
  TriangleSoup soup;
  soup.positions = {{0.1, 0.2, 1e-300}, {1.0 / 3.0, 0, 0}, {0, 1e300, 0}};
  soup.triangles = {{0, 1, 2}};
  EXPECT_EQ(parse_mesh(MeshFormat::kStl, serialize_mesh(soup, MeshFormat::kStl, {.binary = false}), "file"), soup);
}

TEST(Stl, BinaryRefusesWhatSinglePrecisionCannotHold) {
  TriangleSoup soup = sample_soup(false, false);  // holds 1e300
  EXPECT_THROW(serialize_mesh(soup, MeshFormat::kStl), InputError);
}

TEST(Stl, BinaryMayBeginWithSolid) {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}};
  std::string bytes = serialize_mesh(soup, MeshFormat::kStl);
  bytes.replace(0, 9, "solid abc");
  EXPECT_EQ(parse_mesh(MeshFormat::kStl, bytes, "file"), soup);
  // One byte short, it is still recognised as binary and refused with the byte of its count.
  bytes.pop_back();
  EXPECT_EQ(refusal(MeshFormat::kStl, bytes),
            "file, byte 80: 1 facets announced, which take 134 bytes, but the file holds 133");
}

TEST(Stl, TextMayHoldSeveralSolidsAndUpperCase) {
  const std::string facet = "FACET NORMAL 0 0 1 OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 1 0 ENDLOOP ENDFACET\n";
  const std::string text = "SOLID a b\n" + facet + "ENDSOLID a\nsolid\n" + facet + "endsolid";
  EXPECT_EQ(parse_mesh(MeshFormat::kStl, text, "file").triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 2}}));
  EXPECT_NE(refusal(MeshFormat::kStl, text.substr(0, text.size() - 8)), "");
}

// PLY.

/// The same two coloured triangles in all encodings, with unusual types and order and elements to skip.
std::string ply_sample(std::string_view encoding, std::endian order) {
  std::string bytes = "ply\nformat " + std::string(encoding) +
                      " 1.0\ncomment any\nelement camera 1\nproperty float view\nproperty list uchar short extra\n"
                      "element vertex 4\nproperty uchar blue\nproperty short y\nproperty double x\nproperty uchar red\n"
                      "property float z\nproperty uchar green\nelement face 1\nproperty int flag\n"
                      "property list ushort uint vertex_index\nelement empty 0\nproperty float nothing\nend_header\n";
  const auto put = [&bytes, order](auto value) {
    std::string raw;
    append_little_endian(raw, value);
    if (order == std::endian::big) std::ranges::reverse(raw);
    bytes += raw;
  };
  if (encoding == "ascii") {
    return bytes + "1.5 2 -7 8\n255 0 0 0 2.5 51\n0 0 1 0 2.5 51\n\n0 1 1 0 2.5 51\n 0 1 0\t0 2.5 51 \n9 4 0 1 2 3\n";
  }
  put(1.5F), put(std::uint8_t{2}), put(std::int16_t{-7}), put(std::int16_t{8});
  for (int vertex = 0; vertex < 4; ++vertex) {
    put(static_cast<std::uint8_t>(vertex == 0 ? 255 : 0));
    put(static_cast<std::int16_t>(vertex >= 2 ? 1 : 0));
    put(vertex == 1 || vertex == 2 ? 1.0 : 0.0);
    put(std::uint8_t{0}), put(2.5F), put(std::uint8_t{51});
  }
  put(std::int32_t{9}), put(std::uint16_t{4});
  for (std::uint32_t corner = 0; corner < 4; ++corner) put(corner);
  return bytes;
}

TEST(Ply, ReadsEveryEncodingTypeAndOrder) {
  TriangleSoup expected;
  expected.positions = {{0, 0, 2.5}, {1, 0, 2.5}, {1, 1, 2.5}, {0, 1, 2.5}};
  expected.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Color green(0, 0.2F, 0);  // 51 / 255 = 0.2
  expected.vertex_colors = {{0, 0.2F, 1}, green, green, green};
  EXPECT_EQ(parse_mesh(MeshFormat::kPly, ply_sample("ascii", std::endian::little), "file"), expected);
  EXPECT_EQ(parse_mesh(MeshFormat::kPly, ply_sample("binary_little_endian", std::endian::little), "file"), expected);
  EXPECT_EQ(parse_mesh(MeshFormat::kPly, ply_sample("binary_big_endian", std::endian::big), "file"), expected);
}

TEST(Ply, FacesMayComeBeforeVerticesAndColoursMayBeReal) {
  const TriangleSoup soup =
      parse_mesh(MeshFormat::kPly,
                 "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_indices\n"
                 "property float diffuse_red\nproperty float diffuse_green\nproperty float diffuse_blue\n"
                 "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
                 "3 0 1 2 0.5 0.25 1\n2 0 1 0 0 0\n0 0 0\n1 0 0\n0 1 0\n",
                 "file");
  EXPECT_EQ(soup.triangles.size(), 1U);  // a face of two corners is dropped
  EXPECT_EQ(soup.triangle_colors, (std::vector<Color>{{0.5F, 0.25F, 1.0F}}));
}

std::string ply_text(std::string_view vertices, std::string_view faces, std::string_view body) {
  return "ply\nformat ascii 1.0\nelement vertex " + std::string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n" + std::string(body);
}

TEST(Ply, RefusalsNameTheLine) {
  const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";  // lines 10 to 12
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "1", vertices + "3 0 1 3\n")),
            "file, line 13: a face refers to vertex 3, outside 0 to 2");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "1", vertices + "3 0 1 -1\n")),
            "file, line 13: a face refers to vertex -1, outside 0 to 2");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "1", "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n")),
            "file, line 11: coordinate 'y' is not finite");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "1", "0 0 0\n1 0 1.0x\n0 1 0\n3 0 1 2\n")),
            "file, line 11: z is not a number: '1.0x'");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "2", vertices + "3 0 1 2\n")),
            "file, line 13: the file ends after 1 of 2 'face' elements");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("4000000000", "1", vertices + "3 0 1 2\n")),
            "file, line 9: 4000000000 'vertex' elements announced, but only 26 bytes follow; the file is truncated or "
            "its counts are wrong");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("-3", "1", "")), "file, line 3: element 'vertex' has a negative count");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "0", vertices)), "file: the mesh has no triangle");
  EXPECT_EQ(refusal(MeshFormat::kPly, ply_text("3", "1", vertices + "3 0 1 2 4\n")),
            "file, line 13: unexpected '4' at the end of the line");
}

TEST(Ply, RefusalsNameTheByte) {
  const std::string bytes = ply_sample("binary_big_endian", std::endian::big);
  // The face is the last item: 4 bytes of flag, 2 of length, 4 indices of 4 bytes each.
  const std::size_t indices = bytes.size() - 16;
  std::string wrong = bytes;
  wrong[indices + 4 * 2] = 1;  // the third index becomes 2^24 + 2
  EXPECT_EQ(refusal(MeshFormat::kPly, wrong),
            "file, byte " + std::to_string(indices + 8) + ": a face refers to vertex 16777218, outside 0 to 3");
  EXPECT_EQ(refusal(MeshFormat::kPly, std::string_view(bytes).substr(0, bytes.size() - 1)),
            "file, byte " + std::to_string(indices) +
                ": 4 values of list 'vertex_index' announced, but only 15 bytes follow; the file is truncated or its "
                "counts are wrong");
}

TEST(Ply, RefusesStripsAndMissingProperties) {
  EXPECT_EQ(
      refusal(MeshFormat::kPly, "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int vertex_indices\n"),
      "file, line 3: triangle strips are not supported; write the mesh with an element 'face'");
  EXPECT_EQ(refusal(MeshFormat::kPly,
                    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float z\nend_header\n"),
            "file, line 3: element 'vertex' has no property 'y'");
  EXPECT_EQ(refusal(MeshFormat::kPly, "solid"), "file, line 1: this is no PLY file: it does not begin with 'ply'");
}

// OBJ.

TEST(Obj, ReadsAllFormsOfCorners) {
  const TriangleSoup soup =
      parse_mesh(MeshFormat::kObj,
                 "# comment \\\r\nv 0 0 0\r\nv +1 0 0 1.0\r\nv 1 \\\r\n1 0\r\nvt 0 0\r\nvn 0 0 1\r\n"
                 "v 0 1 0 # inline\r\nf 1/1 2//1 3/1/1\r\nf -4 -2 \\\r\n -1\r\nl 1 2\r\np 1\r\nf 1 2\r\n",
                 "file");
  EXPECT_EQ(soup.positions, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
  EXPECT_EQ(soup.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(soup.vertex_colors.empty());
}

TEST(Obj, ReadsColoursOfVerticesAndMaterials) {
  const std::string text =
      "mtllib my colours.mtl\nv 0 0 0 1 0 0.5\nv 1 0 0\nv 0 1 0 0 1 0\nusemtl red\nf 1 2 3\nusemtl none\nf 1 3 2\n";
  const MaterialLoader loader = [](std::string_view file) -> std::optional<std::string> {
    return file == "my colours.mtl" ? std::optional<std::string>("newmtl red\nKd 1 0.2 0\nnewmtl none\nKd spectral x\n")
                                    : std::nullopt;
  };
  const TriangleSoup soup = parse_mesh(MeshFormat::kObj, text, "file", loader);
  // What has no colour among coloured ones is mid-grey.
  EXPECT_EQ(soup.vertex_colors, (std::vector<Color>{{1, 0, 0.5F}, {0.5F, 0.5F, 0.5F}, {0, 1, 0}}));
  EXPECT_EQ(soup.triangle_colors, (std::vector<Color>{{1, 0.2F, 0}, {0.5F, 0.5F, 0.5F}}));
  EXPECT_TRUE(parse_mesh(MeshFormat::kObj, text, "file").triangle_colors.empty()) << "no loader, no colours";
}

TEST(Obj, RealColoursAboveOneAreBytes) {
  const TriangleSoup soup = parse_mesh(MeshFormat::kObj, "v 0 0 0 255 0 51\nv 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n", "file");
  EXPECT_EQ(soup.vertex_colors, (std::vector<Color>{{1, 0, 0.2F}, {0.5F, 0.5F, 0.5F}, bytes_color(1, 0, 0)}));
}

TEST(Obj, RefusalsNameTheLine) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices + "f 1 2 9\n"),
            "file, line 4: a face refers to vertex 9, outside 1 to 3");
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices + "f 1 2 0\n"), "file, line 4: vertex index 0; indices count from 1");
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices + "f 1 2 -4\n"),
            "file, line 4: a face refers to vertex -4, but only 3 come before it");
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices + "f 1 2 3a\n"),
            "file, line 4: a face corner is not of the form v/vt/vn: '3a'");
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices + "f 1 2 x\n"), "file, line 4: a vertex index is not a number: 'x'");
  EXPECT_EQ(refusal(MeshFormat::kObj, "v 0 inf 0\n"), "file, line 1: a coordinate is not finite");
  EXPECT_EQ(refusal(MeshFormat::kObj, "v 0 1e400 0\n"), "file, line 1: a coordinate is not finite");
  EXPECT_EQ(refusal(MeshFormat::kObj, "v 0 0\n"), "file, line 1: a coordinate is missing; the file may be truncated");
  EXPECT_EQ(refusal(MeshFormat::kObj, vertices), "file: the mesh has no triangle");
  EXPECT_EQ(refusal(MeshFormat::kObj, ""), "file: the mesh has no triangle");
}

// OFF.

TEST(Off, ReadsCommentsColoursAndCountsAnywhere) {
  const TriangleSoup plain = parse_mesh(
      MeshFormat::kOff, "# first\nOFF 4 1 4 # counts\n\n0 0 0 # a\n1 0 0\n# b\n1 1 0\n0 1 0\n4 0 1 2 3\n", "file");
  EXPECT_EQ(plain.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(plain.triangle_colors.empty());
  const TriangleSoup colored = parse_mesh(MeshFormat::kOff,
                                          "COFF\n3 2 0\n0 0 0 51 0 255 255\n1 0 0 0 0 0 255\n0 1 0 0 0 0 255\n"
                                          "3 0 1 2 0.5 1 0.25\n3 0 2 1\n",
                                          "file");
  EXPECT_EQ(colored.vertex_colors, (std::vector<Color>{{0.2F, 0, 1}, {0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(colored.triangle_colors, (std::vector<Color>{{0.5F, 1, 0.25F}, {0.5F, 0.5F, 0.5F}}));
  const TriangleSoup others = parse_mesh(
      MeshFormat::kOff,
      "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 1 .5 .5\n1 0 0 0 0 1 1 0 0 1 0 0\n0 1 0 0 0 1 1 0 0 1 1 1\n3 0 1 2\n", "file");
  EXPECT_EQ(others.vertex_colors, (std::vector<Color>(3, Color(1, 0, 0))));
}

TEST(Off, RefusalsNameTheLine) {
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF BINARY\n"),
            "file, line 1: binary OFF is not supported; convert it to text or to PLY");
  EXPECT_EQ(refusal(MeshFormat::kOff, "4OFF\n1 1 1\n"),
            "file, line 1: unsupported kind of OFF: '4OFF'; only three-dimensional OFF, COFF, NOFF and STOFF are read");
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF\n0 0 0\n"), "file: the mesh has no triangle");
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF\n4000000000 1 0\n0 0 0\n"),
            "file, line 2: 4000000000 vertices announced, but only 6 bytes follow; the file is truncated or its counts "
            "are wrong");
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "file, line 6: a face refers to vertex 3, outside 0 to 2");
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n5000000000 0 1 2\n"),
            "file, line 6: a vertex index is missing; the file may be truncated");
  EXPECT_EQ(refusal(MeshFormat::kOff, "OFF\n3 1 0\n0 0 0\n1.0 0.0 0.0\n"),
            "file, line 4: the file ends after 2 of 3 vertices");
}

// Files.

TEST_F(MeshIo, ObjWritesItsMaterialsBeside) {
  const TriangleSoup soup = sample_soup(true, true);
  write_mesh(soup, folder / "a.obj");
  EXPECT_EQ(files_in_folder(), 2U);
  EXPECT_TRUE(fs::exists(folder / "a.mtl"));
  EXPECT_EQ(read_mesh(folder / "a.obj"), soup);
  fs::remove(folder / "a.mtl");
  EXPECT_EQ(read_mesh(folder / "a.obj"), sample_soup(true, false)) << "a missing library means no colours";
}

TEST_F(MeshIo, WritingLeavesNothingBehindOnFailure) {
  EXPECT_THROW(write_mesh(sample_soup(false, false), folder / "none" / "a.ply"), ResourceError);
  EXPECT_THROW(write_mesh(sample_soup(false, false), folder / "a.xyz"), ParameterError);
  EXPECT_THROW(write_mesh(TriangleSoup{}, folder / "a.ply"), InputError);
  EXPECT_EQ(files_in_folder(), 0U);
}

// Real models.

struct ManifestRow {
  std::string file;
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  bool refused = false;
};

/// Splits a line of CSV with quotes.
std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool in_quotes = false;
  for (const char c : line) {
    if (c == '"') {
      in_quotes = !in_quotes;
    } else if (c == ',' && !in_quotes) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

std::vector<ManifestRow> mesh_rows(const fs::path& manifest) {
  std::istringstream lines(read_file(manifest));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> header = csv_fields(line);
  std::vector<ManifestRow> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> fields = csv_fields(line);
    std::map<std::string, std::string> row;
    for (std::size_t i = 0; i < std::min(header.size(), fields.size()); ++i) row[header[i]] = fields[i];
    if (row["kind"] != "mesh" || !mesh_format(row["file"])) continue;
    rows.push_back({row["file"], std::stoul(row["vertices"]), std::stoul(row["triangles"]),
                    row["triangles"] == "0" || row["bad_index_tris"] != "0" || row["nonfinite_vertices"] != "0"});
  }
  return rows;
}

TEST(MeshData, EveryModelMatchesItsManifest) {
  const char* const data = std::getenv("VOXCARVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "set VOXCARVE_DATA to the folder of real models";
  const std::vector<ManifestRow> rows = mesh_rows(fs::path(data) / "MANIFEST.csv");
  ASSERT_FALSE(rows.empty());
  for (const ManifestRow& row : rows) {
    SCOPED_TRACE(row.file);
    const fs::path path = fs::path(data) / row.file;
    if (row.refused) {
      EXPECT_THROW(read_mesh(path), InputError);
      continue;
    }
    const TriangleSoup soup = read_mesh(path);
    EXPECT_NO_THROW(validate(soup, row.file));
    EXPECT_EQ(soup.triangles.size(), row.triangles);
    if (mesh_format(path) == MeshFormat::kStl) continue;  // merging may leave fewer
    EXPECT_EQ(soup.positions.size(), row.vertices);
  }
}

}  // namespace
}  // namespace voxcarve
