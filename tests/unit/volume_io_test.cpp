#include "common/volume/io/volume_io.h"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "common/run/atomic_file.h"
#include "common/run/byte_order.h"
#include "common/run/errors.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

/// A folder that lasts as long as the test.
class VolumeIo : public ::testing::Test {
 protected:
  VolumeIo() {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / ("voxcarve_volume_io_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder);
  }
  ~VolumeIo() override { fs::remove_all(folder); }

  fs::path folder;
};

/// A frame whose corner does not follow exactly from the centre of its first voxel: 0.1 + 1 - 1 is not 0.1.
const GridFrame kFrame{{3, 2, 4}, {0.1, -1e6, 1.0 / 3.0}, 2.0};

BinaryVolume sample_binary(const GridFrame& frame) {
  BinaryVolume volume(frame);
  for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = i % 3 == 0 ? 1 : 0;
  return volume;
}

DensityVolume sample_density(const GridFrame& frame) {
  DensityVolume volume(frame);
  for (std::size_t i = 0; i < volume.values.size(); ++i) volume.values[i] = 0.1F * static_cast<float>(i % 10);
  return volume;
}

Grid<float> as_float(const BinaryVolume& volume) {
  Grid<float> result(volume.frame);
  std::ranges::transform(volume.values, result.values.begin(),
                         [](std::uint8_t value) { return static_cast<float>(value); });
  return result;
}

/// The message of the InputError that parsing gives; "" when it gives none.
std::string refusal(VolumeFormat format, std::string_view bytes) {
  try {
    parse_volume(format, bytes, "file");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(VolumeFormat, ComesFromTheExtensionInEitherCase) {
  EXPECT_EQ(volume_format("a.NRRD"), VolumeFormat::kNrrd);
  EXPECT_EQ(volume_format("a.nhdr"), VolumeFormat::kNrrd);
  EXPECT_EQ(volume_format("a.mhd"), VolumeFormat::kMetaImage);
  EXPECT_EQ(volume_format("a.Mha"), VolumeFormat::kMetaImage);
  EXPECT_EQ(volume_format("a.png"), VolumeFormat::kPng);
  EXPECT_EQ(volume_format("a.pbm"), VolumeFormat::kNetpbm);
  EXPECT_EQ(volume_format("a.pgm"), VolumeFormat::kNetpbm);
  EXPECT_FALSE(is_volume_file("a.ply"));
}

TEST_F(VolumeIo, VolumesReadBackOnTheSameGrid) {
  for (const char* const name : {"a.nrrd", "a.mhd", "a.mha"}) {
    SCOPED_TRACE(name);
    write_volume(sample_binary(kFrame), folder / name);
    const VolumeFile binary = read_volume(folder / name);
    EXPECT_EQ(binary.values, as_float(sample_binary(kFrame)));
    EXPECT_TRUE(binary.is_binary);
    EXPECT_TRUE(binary.notices.empty());
    write_volume(sample_density(kFrame), folder / name);
    const VolumeFile density = read_volume(folder / name);
    EXPECT_EQ(density.values, sample_density(kFrame));
    EXPECT_FALSE(density.is_binary);
  }
  EXPECT_TRUE(fs::exists(folder / "a.raw"));
}

TEST_F(VolumeIo, AnImageReadsBackFromEveryFormat) {
  // Nine columns, so that rows of PBM end within a byte.
  const BinaryVolume image = sample_binary({{9, 4, 1}, {0, 0, 0}, 1.0});
  for (const char* const name : {"a.png", "a.pbm", "a.pgm", "a.nrrd", "a.mha"}) {
    SCOPED_TRACE(name);
    write_volume(image, folder / name);
    const VolumeFile file = read_volume(folder / name);
    EXPECT_EQ(file.values, as_float(image));
    EXPECT_TRUE(file.is_binary);
  }
}

TEST_F(VolumeIo, DensitiesBecomeGreyValues) {
  DensityVolume image({{4, 1, 1}, {0, 0, 0}, 1.0});
  image.values = {0.0F, 0.5F, 1.0F, 2.0F};
  for (const char* const name : {"a.png", "a.pgm"}) {
    write_volume(image, folder / name);
    // 255 * 0.5 = 127.5, rounded away from zero; 2 is clamped.
    EXPECT_EQ(read_volume(folder / name).values.values, (GridValues<float>{0, 128, 255, 255}));
  }
}

TEST_F(VolumeIo, WritersRefuseWhatTheFormatCannotHold) {
  EXPECT_THROW(write_volume(sample_binary(kFrame), folder / "a.png"), ParameterError);
  EXPECT_THROW(write_volume(sample_binary(kFrame), folder / "a.xyz"), ParameterError);
  EXPECT_THROW(write_volume(sample_density({{2, 2, 1}, {0, 0, 0}, 1}), folder / "a.pbm"), ParameterError);
  EXPECT_THROW(write_volume(BinaryVolume{}, folder / "a.nrrd"), ParameterError);
  EXPECT_THROW(write_volume(sample_binary(kFrame), folder / "none" / "a.nrrd"), ResourceError);
  DensityVolume broken = sample_density(kFrame);
  broken.values[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(write_volume(broken, folder / "a.nrrd"), InputError);
  EXPECT_TRUE(fs::is_empty(folder));
}

// NRRD.

std::string nrrd(std::string_view fields, std::string_view data) {
  return "NRRD0005\n# comment\ndimension: 3\nsizes: 2 1 2\n" + std::string(fields) + "\n" + std::string(data);
}

template <class T>
std::string samples(std::endian order) {
  std::string bytes;
  for (const int value : {3, 0, 100, 1}) {
    std::string raw;
    append_little_endian(raw, static_cast<T>(value));
    if (order == std::endian::big) std::ranges::reverse(raw);
    bytes += raw;
  }
  return bytes;
}

TEST(Nrrd, ReadsEveryTypeAndByteOrder) {
  const GridValues<float> expected = {3, 0, 100, 1};
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const std::string rest =
        std::string("encoding: raw\nendian: ") + (order == std::endian::big ? "big\n" : "little\n");
    const auto read = [&](const std::string& type, const std::string& data) {
      SCOPED_TRACE(type);
      EXPECT_EQ(parse_volume(VolumeFormat::kNrrd, nrrd("type: " + type + "\n" + rest, data), "file").values.values,
                expected);
    };
    read("signed char", samples<std::int8_t>(order));
    read("uint8", samples<std::uint8_t>(order));
    read("short", samples<std::int16_t>(order));
    read("unsigned short int", samples<std::uint16_t>(order));
    read("int", samples<std::int32_t>(order));
    read("uint32_t", samples<std::uint32_t>(order));
    read("long long int", samples<std::int64_t>(order));
    read("uint64", samples<std::uint64_t>(order));
    read("float", samples<float>(order));
    read("double", samples<double>(order));
  }
}

std::string gzip(const std::string& raw) {
  std::string packed(compressBound(raw.size()) + 32, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string input = raw;
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  return packed;
}

TEST(Nrrd, ReadsEveryEncoding) {
  const GridValues<float> expected = {3, 0, 100, 1};
  const auto values = [](const std::string& bytes) {
    return parse_volume(VolumeFormat::kNrrd, bytes, "file").values.values;
  };
  const std::string raw = samples<std::uint8_t>(std::endian::little);
  EXPECT_EQ(values(nrrd("type: uchar\nencoding: gzip\n", gzip(raw))), expected);
  EXPECT_EQ(values(nrrd("type: uchar\nencoding: gz\nbyte skip: 3\n", gzip("abc" + raw))), expected);
  EXPECT_EQ(values(nrrd("type: uchar\nencoding: ascii\n", "3 0\n100\t1\n")), expected);
  EXPECT_EQ(values(nrrd("type: uchar\nencoding: raw\nline skip: 2\nbyte skip: 1\n", "a\nb\nc" + raw)), expected);
  EXPECT_EQ(values(nrrd("type: uchar\nencoding: raw\nbyte skip: -1\n", "whatever" + raw)), expected);
  std::string cut = gzip(raw);
  cut.resize(cut.size() - 11);
  EXPECT_NE(refusal(VolumeFormat::kNrrd, nrrd("type: uchar\nencoding: gzip\n", cut)), "");
}

TEST_F(VolumeIo, DataMayStandInAFileOfTheirOwn) {
  write_file_atomically(folder / "data.raw", samples<std::uint8_t>(std::endian::little));
  write_file_atomically(folder / "a.nhdr", nrrd("type: uchar\nencoding: raw\ndata file: data.raw\n", ""));
  EXPECT_EQ(read_volume(folder / "a.nhdr").values.values, (GridValues<float>{3, 0, 100, 1}));
  fs::remove(folder / "data.raw");
  EXPECT_THROW(read_volume(folder / "a.nhdr"), InputError);
}

TEST(Nrrd, TheOriginIsTheCentreOfTheFirstSample) {
  const std::string type = "type: uchar\nencoding: raw\n";
  const auto frame = [&](const std::string& fields) {
    return parse_volume(VolumeFormat::kNrrd, nrrd(type + fields, std::string("\1\0\1\0", 4)), "file").values.frame;
  };
  EXPECT_EQ(frame(""), (GridFrame{{2, 1, 2}, {-0.5, -0.5, -0.5}, 1.0}));
  EXPECT_EQ(frame("spacings: 2 2 2\n"), (GridFrame{{2, 1, 2}, {-1, -1, -1}, 2.0}));
  EXPECT_EQ(frame("space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (10, 20, 30)\n"),
            (GridFrame{{2, 1, 2}, {9, 19, 29}, 2.0}));
  EXPECT_EQ(frame("spacings: 2 2 2\naxis mins: 1 2 3\ncenters: cell node cell\n"),
            (GridFrame{{2, 1, 2}, {1, 1, 3}, 2.0}));
}

TEST(Nrrd, ATurnedVolumeIsKeptWithANotice) {
  const VolumeFile file = parse_volume(
      VolumeFormat::kNrrd,
      nrrd("type: uchar\nencoding: raw\nspace directions: (-2,0,0) (0,2,0) (0,0,2)\n", std::string("\1\0\1\0", 4)),
      "file");
  ASSERT_EQ(file.notices.size(), 1U);
  EXPECT_NE(file.notices[0].find("mirror"), std::string::npos);
  EXPECT_EQ(file.values.values, (GridValues<float>{1, 0, 1, 0}));
}

TEST(Nrrd, AnisotropicVolumesAreResampledTrilinearly) {
  // Two samples 0 and 8 of spacing 2 along z become four of spacing 1. Their centres lie at -1/4, 1/4, 3/4 and 5/4
  // between the old ones: 0 (clamped), 2, 6 and 8 (clamped).
  const VolumeFile file = parse_volume(
      VolumeFormat::kNrrd,
      "NRRD0004\ndimension: 3\nsizes: 1 1 2\nspacings: 1 1 2\ntype: uchar\nencoding: ascii\naxis mins: 0 0 0\n\n0 8",
      "file");
  EXPECT_EQ(file.values.frame, (GridFrame{{1, 1, 4}, {-0.5, -0.5, -1}, 1.0}));
  EXPECT_EQ(file.values.values, (GridValues<float>{0, 2, 6, 8}));
  ASSERT_EQ(file.notices.size(), 1U);
  EXPECT_EQ(file.notices[0],
            "anisotropic spacing 1 x 1 x 2: resampled trilinearly from 1 x 1 x 2 to 1 x 1 x 4 voxels of size 1");
}

TEST(Nrrd, Refusals) {
  const std::string raw = "type: uchar\nencoding: raw\n";
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, nrrd(raw, "abc")),
            "file: 2 x 1 x 2 samples take 4 bytes, but the data hold 3; the file is truncated or its sizes are wrong");
  EXPECT_EQ(
      refusal(VolumeFormat::kNrrd, "NRRD0004\ndimension: 3\nsizes: 4000000000 4000000000 4000000000\n" + raw + "\n"),
      "file: absurd sizes 4000000000 x 4000000000 x 4000000000");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, "NRRD0004\ndimension: 3\nsizes: 2 -1 2\n" + raw + "\n"),
            "file: the volume is empty: one of its sizes is -1");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, "NRRD0004\ndimension: 4\n"),
            "file, line 2: 4 axes; only volumes of 3 and images of 2 are supported");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, "P5"),
            "file, line 1: this is no NRRD file: it does not begin with 'NRRD000' and a version");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, nrrd(raw + "spacings: 1 0 1\n", "abcd")),
            "file: spacing 0 is not positive and finite");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, nrrd("type: short\nencoding: raw\n", "abcdabcd")),
            "file: the header has no field 'endian'");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, nrrd("type: uchar\nencoding: bzip2\n", "abcd")),
            "file, line 6: unsupported encoding 'bzip2'; known are raw, gzip and ascii");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, nrrd("type: float\nencoding: ascii\n", "1 2 nan 4")),
            "file: sample 2 is not a finite number: 'nan'");
  std::string infinite = samples<float>(std::endian::little);
  infinite.replace(4, 4, std::string("\0\0\x80\x7f", 4));
  const std::string header = nrrd("type: float\nendian: little\nencoding: raw\n", "");
  EXPECT_EQ(refusal(VolumeFormat::kNrrd, header + infinite),
            "file, byte " + std::to_string(header.size() + 4) + ": a sample is not finite in single precision");
  EXPECT_NE(refusal(VolumeFormat::kNrrd, nrrd(raw + "spacings: 1 1 1e-9\n", "abcd")), "");
  EXPECT_NE(refusal(VolumeFormat::kNrrd, nrrd(raw + "data file: x.raw\n", "")), "") << "no loader";
}

// MetaImage.

std::string metaimage(std::string_view keys, std::string_view data) {
  return "ObjectType = Image\nNDims = 3\nDimSize = 2 1 2\n" + std::string(keys) + "ElementDataFile = LOCAL\n" +
         std::string(data);
}

TEST(MetaImage, ReadsOrdersEncodingsAndGeometry) {
  const GridValues<float> expected = {3, 0, 100, 1};
  const auto read = [](const std::string& bytes) {
    return parse_volume(VolumeFormat::kMetaImage, bytes, "file").values;
  };
  const std::string big = samples<std::int16_t>(std::endian::big);
  EXPECT_EQ(read(metaimage("ElementType = MET_SHORT\nElementByteOrderMSB = True\n", big)).values, expected);
  EXPECT_EQ(read(metaimage("ElementType = MET_FLOAT\n", samples<float>(std::endian::little))).values, expected);
  EXPECT_EQ(read(metaimage("ElementType = MET_UCHAR\nBinaryData = False\n", "3 0 100 1")).values, expected);
  EXPECT_EQ(
      read(metaimage("ElementType = MET_SHORT\nBinaryDataByteOrderMSB = True\nCompressedData = True\n", gzip(big)))
          .values,
      expected);
  EXPECT_EQ(
      read(metaimage("ElementType = MET_SHORT\nBinaryDataByteOrderMSB = True\nHeaderSize = -1\n", "xyz" + big)).values,
      expected);
  const std::string bytes = samples<std::uint8_t>(std::endian::little);
  EXPECT_EQ(read(metaimage("ElementType = MET_UCHAR\nElementSpacing = 2 2 2\nOffset = 10 20 30\n", bytes)).frame,
            (GridFrame{{2, 1, 2}, {9, 19, 29}, 2.0}));
}

TEST(MetaImage, Refusals) {
  EXPECT_EQ(refusal(VolumeFormat::kMetaImage, metaimage("ElementType = MET_UCHAR\n", "abc")),
            "file: 2 x 1 x 2 samples take 4 bytes, but the data hold 3; the file is truncated or its sizes are wrong");
  EXPECT_EQ(refusal(VolumeFormat::kMetaImage, metaimage("ElementType = MET_OTHER\n", "abcd")),
            "file, line 4: unsupported sample type 'MET_OTHER'");
  EXPECT_EQ(
      refusal(VolumeFormat::kMetaImage, metaimage("ElementType = MET_UCHAR\nElementNumberOfChannels = 3\n", "abcd")),
      "file, line 5: only volumes of one channel are supported");
  EXPECT_EQ(refusal(VolumeFormat::kMetaImage, "NDims = 3\n"), "file, line 1: the file ends before 'ElementDataFile'");
  EXPECT_EQ(refusal(VolumeFormat::kMetaImage, metaimage("ElementType = MET_UCHAR\nElementSpacing = 1 1 nan\n", "abcd")),
            "file: spacing nan is not positive and finite");
}

// Real volumes.

TEST(VolumeData, VolumesAreReadOnCubicVoxels) {
  const char* const data = std::getenv("VOXCARVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "set VOXCARVE_DATA to the folder of real volumes";
  const VolumeFile bolt = read_volume(fs::path(data) / "bolt_70x123x66.nrrd");
  EXPECT_EQ(bolt.values.frame.dims, Index3(70, 123, 66));
  EXPECT_TRUE(bolt.notices.empty());
  // 16 bits, the upper byte first, aspect 1:1:2, values up to 3272: 226 slices of twice the density.
  const VolumeFile head = read_volume(fs::path(data) / "ct_head_256x256x113.nrrd");
  EXPECT_EQ(head.values.frame.dims, Index3(256, 256, 226));
  EXPECT_EQ(head.notices.size(), 1U);
  EXPECT_LE(*std::ranges::max_element(head.values.values), 3272.0F);
  EXPECT_GT(*std::ranges::max_element(head.values.values), 3000.0F);
  // 3.2 x 64 / 1.5 = 136.5 voxels, rounded up.
  EXPECT_EQ(read_volume(fs::path(data) / "ct_headsq_64x64x93.nrrd").values.frame.dims, Index3(137, 137, 93));
}

}  // namespace
}  // namespace voxcarve
