// PNG, PBM and PGM.
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "common/run/errors.h"
#include "common/volume/io/png.h"
#include "common/volume/io/volume_io.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

/// The message of the InputError that parsing gives; "" when it gives none.
std::string refusal(VolumeFormat format, std::string_view bytes) {
  try {
    parse_volume(format, bytes, "file");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Netpbm, RowsComeFromTheTopAndBlackIsInterior) {
  // Top row 1 0 0, bottom row 0 0 1; digits need no blanks.
  const VolumeFile file = parse_volume(VolumeFormat::kNetpbm, "P1\n# comment\n3 2\n100 0 0#x\n1", "file");
  EXPECT_TRUE(file.is_binary);
  EXPECT_EQ(file.values(0, 1, 0), 1);
  EXPECT_EQ(file.values(2, 0, 0), 1);
  EXPECT_EQ(std::ranges::count(file.values.values, 1.0F), 2);
}

TEST(Netpbm, ASingleValueKeepsItsMeaning) {
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, "P1 2 1 1 1", "file").values.values, (GridValues<float>{1, 1}));
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, "P1 2 1 0 0", "file").values.values, (GridValues<float>{0, 0}));
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, "P2 2 1 255 200 200", "file").values.values, (GridValues<float>{1, 1}));
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, "P2 2 1 255 20 20", "file").values.values, (GridValues<float>{0, 0}));
}

TEST(Netpbm, GreyValuesAreScaled) {
  const GridValues<float> expected = {0, 85, 255};  // 0, 1 and 3 of 3
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, "P2\n3 1\n3\n0 1 3", "file").values.values, expected);
  EXPECT_EQ(parse_volume(VolumeFormat::kNetpbm, std::string("P5\n3 1\n3\n\0\1\3", 12), "file").values.values, expected);
  // 257 and 65535 of 65535 in two bytes, the upper one first: 1 and 255.
  const VolumeFile deep = parse_volume(VolumeFormat::kNetpbm, std::string("P5 3 1 65535 \0\0\1\1\xff\xff", 19), "file");
  EXPECT_EQ(deep.values.values, (GridValues<float>{0, 1, 255}));
}

TEST(Netpbm, Refusals) {
  EXPECT_EQ(refusal(VolumeFormat::kNetpbm, "P4\n4000000000 4000000000\n"),
            "file, byte 24: an image of 4000000000 x 4000000000 exceeds the 1 bytes that follow; the file is truncated "
            "or its sizes are wrong");
  EXPECT_EQ(refusal(VolumeFormat::kNetpbm, "P1 2 1 1 2"), "file, byte 9: a pixel is neither 0 nor 1: '2'");
  EXPECT_EQ(refusal(VolumeFormat::kNetpbm, "P2 2 1 9 1 10"),
            "file, byte 13: pixel 1 has grey value 10, above the largest, 9");
  EXPECT_EQ(refusal(VolumeFormat::kNetpbm, "P6 1 1 255 abc"),
            "file, byte 0: colour images (PPM) are not supported; convert it to PGM or PNG");
  EXPECT_NE(refusal(VolumeFormat::kNetpbm, "P5 0 1 255 "), "");
  EXPECT_NE(refusal(VolumeFormat::kNetpbm, "P5 1 1 65536 aaaa"), "");
  EXPECT_NE(refusal(VolumeFormat::kNetpbm, "P5 2 1 255 a"), "");
}

TEST(Png, LuminanceOverWhite) {
  // Opaque pure red, opaque grey 7, black of alpha 51: white shows through by 204 / 255.
  const std::vector<std::uint8_t> pixels = {255, 0, 0, 255, 7, 7, 7, 255, 0, 0, 0, 51};
  const GreyImage image = decode_png(encode_png(3, 1, 4, pixels), "file");
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(image.height, 1);
  EXPECT_FLOAT_EQ(image.values[0], 0.299F * 255.0F);
  EXPECT_EQ(image.values[1], 7.0F);
  EXPECT_FLOAT_EQ(image.values[2], 204.0F);
}

TEST(Png, EncodingIsCheckedAndDeterministic) {
  std::vector<std::uint8_t> pixels(64 * 48 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * i / 7);
  EXPECT_EQ(encode_png(64, 48, 3, pixels), encode_png(64, 48, 3, pixels));
  EXPECT_THROW(encode_png(64, 48, 4, pixels), ParameterError);
  EXPECT_THROW(encode_png(0, 48, 3, {}), ParameterError);
  EXPECT_THROW(encode_png(64, 48, 5, pixels), ParameterError);
  EXPECT_THROW(encode_png(1 << 30, 1 << 30, 1, pixels), ParameterError);
}

TEST(Png, Refusals) {
  const std::vector<std::uint8_t> pixels = {1, 2, 3, 4};
  const std::string bytes = encode_png(2, 2, 1, pixels);
  EXPECT_EQ(refusal(VolumeFormat::kPng, bytes), "");
  EXPECT_EQ(refusal(VolumeFormat::kPng, "GIF89a"), "file, byte 0: this is no PNG file");
  // The chunk of pixels follows 8 bytes of signature and 25 of header.
  std::string damaged = bytes;
  damaged[33 + 10] = static_cast<char>(damaged[33 + 10] ^ 1);
  EXPECT_EQ(refusal(VolumeFormat::kPng, damaged), "file, byte 33: a chunk's checksum is wrong; the file is damaged");
  // A header that announces 2^20 x 2^20 pixels, with the right checksum.
  std::string absurd = bytes;
  absurd[16 + 1] = absurd[20 + 1] = 0x10;
  absurd[16 + 3] = absurd[20 + 3] = 0;
  const auto sum = static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(absurd.data() + 12), 17));
  for (unsigned i = 0; i < 4; ++i) absurd[29 + i] = static_cast<char>(sum >> (24 - 8 * i));
  EXPECT_EQ(refusal(VolumeFormat::kPng, absurd),
            "file: the compressed pixels of 1048576 x 1048576 are damaged or incomplete");
}

TEST(ImageData, PngAndPgmOfOneImageAgree) {
  const char* const data = std::getenv("VOXCARVE_DATA");
  if (data == nullptr) GTEST_SKIP() << "set VOXCARVE_DATA to the folder of real images";
  for (const std::string name : {"horse", "clock_motion", "coins", "page", "text", "bw_text"}) {
    SCOPED_TRACE(name);
    const VolumeFile png = read_volume(fs::path(data) / "images" / (name + ".png"));
    const VolumeFile pgm = read_volume(fs::path(data) / "images" / (name + ".pgm"));
    ASSERT_EQ(png.values.frame, pgm.values.frame);
    ASSERT_EQ(png.is_binary, pgm.is_binary);
    for (std::size_t i = 0; i < png.values.values.size(); ++i) {
      // The PGM was rounded to 8 bits, once after laying over white and once after weighing the channels.
      ASSERT_NEAR(png.values.values[i], pgm.values.values[i], 1.0F) << i;
    }
  }
}

}  // namespace
}  // namespace voxcarve
