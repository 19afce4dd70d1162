// Every reader, fed with every truncation, thousands of seeded mutations and hand-made absurd headers of small valid
// files: it gives something valid or throws InputError, and never allocates much.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/io/mesh_io.h"
#include "common/run/byte_order.h"
#include "common/volume/io/png.h"
#include "common/volume/io/volume_io.h"
#include "tests/fuzz/fuzz_targets.h"

namespace voxcarve {
namespace {

using Target = bool (*)(const std::uint8_t*, std::size_t);

/// A valid file behind the byte that selects its format.
struct Sample {
  std::string name;
  Target target;
  std::string bytes;
};

bool feed(const Sample& sample, const std::string& bytes) {
  return sample.target(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

std::string select(int format, const std::string& bytes) {
  return static_cast<char>(format) + bytes;
}
std::string select(MeshFormat format, const std::string& bytes) {
  return select(static_cast<int>(format), bytes);
}
std::string select(VolumeFormat format, const std::string& bytes) {
  return select(static_cast<int>(format), bytes);
}

bool reads(MeshFormat format, const std::string& bytes) {
  return feed({"", fuzz::mesh, ""}, select(format, bytes));
}
bool reads(VolumeFormat format, const std::string& bytes) {
  return feed({"", fuzz::volume, ""}, select(format, bytes));
}

TriangleSoup colored_tetrahedron() {
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {1.5, 0, 0}, {0, -2.25, 0}, {0, 0, 1e3}};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  soup.vertex_colors.assign(4, Color(1, 0.2F, 0));
  soup.triangle_colors.assign(4, Color(0, 0.4F, 1));
  return soup;
}

/// A quadrilateral in big-endian PLY, which is not written but read.
std::string big_endian_ply() {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty short x\nproperty short y\nproperty float z\n"
      "element face 1\nproperty list ushort uint vertex_index\nproperty list uchar double skipped\nend_header\n";
  const auto put = [&bytes](auto value) {
    std::string raw;
    append_little_endian(raw, value);
    bytes.append(raw.rbegin(), raw.rend());
  };
  for (int vertex = 0; vertex < 4; ++vertex) {
    put(static_cast<std::int16_t>(vertex == 1 || vertex == 2 ? 1 : 0));
    put(static_cast<std::int16_t>(vertex / 2));
    put(0.5F);
  }
  put(std::uint16_t{4});
  for (std::uint32_t corner = 0; corner < 4; ++corner) put(corner);
  put(std::uint8_t{1});
  put(2.5);
  return bytes;
}

std::vector<Sample> mesh_samples() {
  const TriangleSoup soup = colored_tetrahedron();
  const auto add = [&soup](MeshFormat format, bool binary) {
    return select(format, serialize_mesh(soup, format, {.binary = binary, .material_library = "m.mtl"}));
  };
  const std::string polygon =
      "v 0 0 0\nv 3 -3 0\nv 1 0 \\\n 0\nv 3 3 0 1\nvt 0 0\nvn 0 0 1\nf 2/1 3//1 4/1/1 -4\nf -1 1 2 3 4 1 2\n";
  return {
      {"binary PLY", fuzz::mesh, add(MeshFormat::kPly, true)},
      {"text PLY", fuzz::mesh, add(MeshFormat::kPly, false)},
      {"big-endian PLY", fuzz::mesh, select(MeshFormat::kPly, big_endian_ply())},
      {"OBJ", fuzz::mesh, add(MeshFormat::kObj, true) + std::string(1, '\0') + serialize_materials(soup)},
      {"OBJ of polygons", fuzz::mesh, select(MeshFormat::kObj, polygon)},
      {"OFF", fuzz::mesh, add(MeshFormat::kOff, true)},
      {"STNOFF", fuzz::mesh,
       select(MeshFormat::kOff, "STNOFF # x\n3 1 0\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 0 0\n0 1 0 0 0 1 1 .5\n3 0 1 2 7\n")},
      {"binary STL", fuzz::mesh, add(MeshFormat::kStl, true)},
      {"text STL", fuzz::mesh, add(MeshFormat::kStl, false)}};
}

std::string zlib_stream(const std::string& raw) {
  std::string packed(compressBound(raw.size()), '\0');
  uLongf size = packed.size();
  EXPECT_EQ(
      compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()), raw.size()),
      Z_OK);
  return packed.substr(0, size);
}

std::vector<Sample> volume_samples() {
  const std::string eight(8, '\1');
  const std::string floats(32, '\0');
  const std::string nrrd = "NRRD0004\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 2\naxis mins: 0 1 2\n";
  const std::string directions =
      "NRRD0005\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: "
      "(0.5,0.5,0.5)\nvoxcarve_lower_corner:=(0,0,0)\nencoding: raw\n\n";
  const std::string meta = "NDims = 3\nDimSize = 2 2 2\nElementSpacing = 1 1 1\nOffset = 1 2 3\n";
  std::vector<std::uint8_t> pixels(12 * 5 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(31 * i);
  return {{"raw NRRD", fuzz::volume, select(VolumeFormat::kNrrd, directions + eight)},
          {"NRRD of floats", fuzz::volume,
           select(VolumeFormat::kNrrd, nrrd + "type: float\nendian: big\nencoding: raw\n\n" + floats)},
          {"NRRD of text", fuzz::volume,
           select(VolumeFormat::kNrrd, nrrd + "type: int\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n")},
          {"compressed NRRD", fuzz::volume,
           select(VolumeFormat::kNrrd, nrrd + "type: uchar\nencoding: gzip\n\n" + zlib_stream(eight))},
          {"detached NRRD", fuzz::volume,
           select(VolumeFormat::kNrrd, nrrd + "type: uchar\nbyte skip: -1\nencoding: raw\ndata file: x.raw\n")},
          {"MetaImage", fuzz::volume,
           select(VolumeFormat::kMetaImage, meta + "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + eight)},
          {"compressed MetaImage", fuzz::volume,
           select(VolumeFormat::kMetaImage,
                  meta + "ElementType = MET_FLOAT\nCompressedData = True\nElementDataFile = LOCAL\n" +
                      zlib_stream(floats))},
          {"PNG", fuzz::volume, select(VolumeFormat::kPng, encode_png(12, 5, 3, pixels))},
          {"plain PBM", fuzz::volume, select(VolumeFormat::kNetpbm, "P1 # c\n3 2\n1 0 1\n0 1 0\n")},
          {"raw PBM", fuzz::volume, select(VolumeFormat::kNetpbm, "P4\n9 2\nabcd")},
          {"plain PGM", fuzz::volume, select(VolumeFormat::kNetpbm, "P2\n3 2 99\n1 0 1\n50 1 99\n")},
          {"raw PGM", fuzz::volume, select(VolumeFormat::kNetpbm, "P5 3 1 65535\nabcdef")}};
}

/// Makes the checksums of a PNG (behind its selecting byte) right again, so that mutations get past them.
std::string with_png_checksums(std::string bytes) {
  std::size_t offset = 1 + 8;
  while (offset + 12 <= bytes.size()) {
    const std::size_t length = load<std::uint32_t>(bytes.data() + offset, std::endian::big);
    if (length > bytes.size() - offset - 12) break;
    const uLong sum = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data() + offset + 4), 4 + length);
    for (unsigned i = 0; i < 4; ++i) bytes[offset + 8 + length + i] = static_cast<char>(sum >> (24 - 8 * i));
    offset += 12 + length;
  }
  return bytes;
}

/// Mutations that only depend on the seed: no distributions of the standard library, which differ between versions.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::string mutate(std::string bytes) {
    const std::size_t steps = 1 + below(4);
    for (std::size_t step = 0; step < steps && bytes.size() > 1; ++step) mutate_once(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t bound) { return static_cast<std::size_t>(random_() % bound); }

  void mutate_once(std::string& bytes) {
    static const std::array<std::string, 12> kTokens = {
        "-1", "0", "4294967295", "4294967296", "9223372036854775807", "nan", "inf", "1e999", "-", "255", "\n", " "};
    const std::size_t at = 1 + below(bytes.size() - 1);  // the byte that selects the format stays
    const std::size_t length = 1 + below(std::min<std::size_t>(16, bytes.size() - at));
    switch (below(7)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 2:
        bytes.insert(at, 1, static_cast<char>(below(256)));
        break;
      case 3:
        bytes.erase(at, length);
        break;
      case 4:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 5:
        bytes.replace(at, std::min<std::size_t>(length, 3), kTokens[below(kTokens.size())]);
        break;
      default:
        replace_number(bytes, at, kTokens[below(kTokens.size())]);
        break;
    }
  }

  static void replace_number(std::string& bytes, std::size_t at, const std::string& token) {
    const std::size_t begin = bytes.find_first_of("0123456789", at);
    if (begin == std::string::npos) return;
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789", begin), bytes.size());
    bytes.replace(begin, end - begin, token);
  }

  std::mt19937_64 random_;
};

/// Caps the memory of the process during a test, so that an allocation on the word of a header fails. The address
/// sanitizer reserves terabytes, so that nothing can be capped under it.
class ReaderFuzz : public ::testing::Test {
 protected:
#ifndef __SANITIZE_ADDRESS__
  ReaderFuzz() {
    constexpr rlim_t kAllowance = rlim_t{64} << 20;
    std::ifstream("/proc/self/statm") >> pages_;
    EXPECT_GT(pages_, 0U) << "the process does not know its size";
    EXPECT_EQ(getrlimit(RLIMIT_AS, &before_), 0);
    rlimit capped = before_;
    capped.rlim_cur = std::min(before_.rlim_max, pages_ * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + kAllowance);
    EXPECT_EQ(setrlimit(RLIMIT_AS, &capped), 0);
  }
  ~ReaderFuzz() override {
    setrlimit(RLIMIT_AS, &before_);
  }

 private:
  rlim_t pages_ = 0;
  rlimit before_{};
#endif
};

std::vector<Sample> all_samples() {
  std::vector<Sample> samples = mesh_samples();
  for (Sample& sample : volume_samples()) samples.push_back(std::move(sample));
  return samples;
}

TEST_F(ReaderFuzz, SamplesAreValid) {
  for (const Sample& sample : all_samples()) {
    EXPECT_NO_THROW(EXPECT_TRUE(feed(sample, sample.bytes)) << sample.name) << sample.name;
  }
}

TEST_F(ReaderFuzz, EveryTruncationIsReadOrRefused) {
  for (const Sample& sample : all_samples()) {
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      EXPECT_NO_THROW(feed(sample, sample.bytes.substr(0, size))) << sample.name << " cut to " << size;
    }
  }
}

TEST_F(ReaderFuzz, BinaryFilesRefuseEveryTruncation) {
  for (const Sample& sample : all_samples()) {
    const bool whole_or_nothing = sample.name.starts_with("binary") || sample.name.starts_with("big") ||
                                  sample.name.starts_with("raw") || sample.name == "PNG";
    if (!whole_or_nothing) continue;
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      EXPECT_FALSE(feed(sample, sample.bytes.substr(0, size))) << sample.name << " cut to " << size;
    }
  }
}

TEST_F(ReaderFuzz, MutationsAreReadOrRefused) {
  constexpr int kMutations = 3000;
  std::uint64_t seed = 1;
  for (const Sample& sample : all_samples()) {
    Mutator mutator(seed++);
    int accepted = 0;
    for (int mutation = 0; mutation < kMutations; ++mutation) {
      std::string bytes = mutator.mutate(sample.bytes);
      if (sample.name == "PNG" && mutation % 4 != 0) bytes = with_png_checksums(std::move(bytes));
      ASSERT_NO_THROW(accepted += feed(sample, bytes) ? 1 : 0) << sample.name << ", mutation " << mutation;
    }
    // Both ways out are taken, so that the mutations are neither too tame nor too wild.
    EXPECT_GT(accepted, 0) << sample.name;
    EXPECT_LT(accepted, kMutations) << sample.name;
  }
}

TEST_F(ReaderFuzz, AbsurdMeshHeadersAreRefused) {
  for (const std::string count : {"4000000000", "-4000000000", "9223372036854775807", "18446744073709551616", "1e9"}) {
    for (const std::string encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      const std::string begin = "ply\nformat " + encoding + " 1.0\nelement vertex ";
      const std::string middle = "\nproperty float x\nproperty float y\nproperty float z\nelement face ";
      const std::string end = "\nproperty list uint int vertex_indices\nend_header\n";
      EXPECT_FALSE(reads(MeshFormat::kPly, begin + count + middle + "1" + end + "0 0 0\n3 0 0 0\n"));
      EXPECT_FALSE(reads(MeshFormat::kPly, begin + "0" + middle + count + end + "3 0 0 0\n"));
      // A list that announces 2^32 - 1 entries, and an element without properties, which takes no bytes at all.
      EXPECT_FALSE(reads(MeshFormat::kPly, begin + "0" + middle + "1" + end + "\xff\xff\xff\xff\1\1\1\1"));
      EXPECT_FALSE(reads(MeshFormat::kPly, begin + "0" + middle + "0" +
                                               "\nproperty list uint int vertex_indices\nelement none " + count +
                                               "\nend_header\n"));
    }
    EXPECT_FALSE(reads(MeshFormat::kOff, "OFF\n" + count + " 1 0\n0 0 0\n3 0 0 0\n"));
    EXPECT_FALSE(reads(MeshFormat::kOff, "OFF\n1 " + count + " 0\n0 0 0\n3 0 0 0\n"));
    EXPECT_FALSE(reads(MeshFormat::kOff, "OFF\n1 1 0\n0 0 0\n" + count + " 0 0 0\n"));
    EXPECT_FALSE(reads(MeshFormat::kObj, "v 0 0 0\nf 1 1 " + count + "\n"));
  }
  EXPECT_FALSE(reads(MeshFormat::kStl, std::string(80, 'x') + "\xff\xff\xff\xff" + std::string(50, '\0')));
}

TEST_F(ReaderFuzz, AbsurdVolumeHeadersAreRefused) {
  for (const std::string size :
       {"4000000000", "-1", "0", "2097152", "9223372036854775807", "18446744073709551617", "1e3", "nan"}) {
    const std::string sizes = size + " " + size + " " + size;
    for (const std::string encoding : {"raw", "gzip", "ascii"}) {
      EXPECT_FALSE(reads(VolumeFormat::kNrrd, "NRRD0004\ntype: double\nendian: little\ndimension: 3\nsizes: " + sizes +
                                                  "\nencoding: " + encoding + "\n\n" +
                                                  zlib_stream(std::string(1000, '0'))));
    }
    EXPECT_FALSE(reads(VolumeFormat::kMetaImage, "NDims = 3\nDimSize = " + sizes +
                                                     "\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\nabcdefgh"));
    for (const std::string kind : {"P1", "P4"}) {
      EXPECT_FALSE(reads(VolumeFormat::kNetpbm, kind + "\n" + size + " " + size + "\n0000"));
    }
    for (const std::string kind : {"P2", "P5"}) {
      EXPECT_FALSE(reads(VolumeFormat::kNetpbm, kind + "\n" + size + " " + size + " 255\n0000"));
    }
  }
  for (const std::string spacing : {"0", "-1", "inf", "1e-300", "1e308", "1e-5"}) {
    EXPECT_FALSE(reads(VolumeFormat::kNrrd, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 " +
                                                spacing + "\nencoding: raw\n\nabcdefgh"));
  }
}

TEST_F(ReaderFuzz, CoordinatesThatAreNotFiniteAreRefused) {
  for (const std::string value :
       {"nan", "-nan", "NaN", "inf", "-inf", "Infinity", "1e400", "-1e400", "nan(1)", "1.#QNAN", "0x1p3"}) {
    const std::string points = "0 0 0\n1 " + value + " 0\n0 1 0\n";
    EXPECT_FALSE(reads(MeshFormat::kOff, "OFF\n3 1 0\n" + points + "3 0 1 2\n")) << value;
    EXPECT_FALSE(reads(MeshFormat::kObj, "v 0 0 0\nv 1 0 0\nv 0 1 " + value + "\nf 1 2 3\n")) << value;
    EXPECT_FALSE(reads(MeshFormat::kPly,
                       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                       "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n" +
                           points + "3 0 1 2\n"))
        << value;
    EXPECT_FALSE(reads(MeshFormat::kStl, "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 " + value +
                                             "\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"))
        << value;
    EXPECT_FALSE(reads(VolumeFormat::kNrrd,
                       "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 2\nencoding: ascii\n\n1 " + value + "\n"))
        << value;
  }
}

}  // namespace
}  // namespace voxcarve
