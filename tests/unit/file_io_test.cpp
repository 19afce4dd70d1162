// Whole files, and the numbers in them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "common/run/atomic_file.h"
#include "common/run/errors.h"
#include "common/run/text_scanner.h"

namespace voxcarve {
namespace {

namespace fs = std::filesystem;

TEST(TextNumbers, AreReadWholeOrNotAtAll) {
  EXPECT_EQ(parse_real("+1.5"), 1.5);
  EXPECT_EQ(parse_real("-2e3"), -2000.0);
  EXPECT_EQ(parse_real(".5"), 0.5);
  for (const std::string_view bad : {"", "+", "-", "1,5", "1.5x", "0x10", "+-1", "++1", "1e", "abc", "1.#INF"}) {
    EXPECT_EQ(parse_real(bad), std::nullopt) << bad;
    EXPECT_EQ(parse_integer(bad), std::nullopt) << bad;
  }
  EXPECT_EQ(parse_integer("+7"), 7);
  EXPECT_EQ(parse_integer("1.0"), std::nullopt);
  EXPECT_EQ(parse_integer("9223372036854775808"), std::nullopt);  // 2^63
}

TEST(TextNumbers, OutOfRangeBecomesZeroOrInfinity) {
  EXPECT_EQ(parse_real("1e400"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_real("-1e99999999999999999999"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_real("1e-400"), 0.0);
  EXPECT_EQ(parse_real("1e-99999999999999999999"), 0.0);
  EXPECT_TRUE(std::signbit(*parse_real("-1e-400")));
  EXPECT_EQ(parse_real("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_EQ(parse_real("1" + std::string(400, '0')), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_real("5e-324"), std::numeric_limits<double>::denorm_min());
}

TEST(TextScannerTest, KnowsAllLineEnds) {
  TextScanner scanner("a\nb\r\nc\rd\n\ne", "file");
  std::string lines;
  while (scanner.next_line()) lines += std::to_string(scanner.line_number()) + std::string(scanner.rest()) + ' ';
  EXPECT_EQ(lines, "1a 2b 3c 4d 5 6e ");
}

/// A folder that lasts as long as the test.
class FileIo : public ::testing::Test {
 protected:
  FileIo() {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / ("voxcarve_file_io_" + std::to_string(::getpid()) + "_" + test->name());
    fs::create_directories(folder);
  }
  ~FileIo() override { fs::remove_all(folder); }

  fs::path folder;
};

TEST_F(FileIo, AnUnfinishedFileVanishes) {
  const auto files = [this] { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); };
  {
    AtomicFile unfinished(folder / "a.ply");
    unfinished.write("half");
    EXPECT_EQ(files(), 1);
    EXPECT_FALSE(fs::exists(folder / "a.ply"));
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(FileIo, AtomicFilesReplaceWholeFilesAndFollowLinks) {
  write_file_atomically(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  write_file_atomically(folder / "link", std::string("new\0bytes", 9));
  EXPECT_EQ(read_file(folder / "target"), std::string("new\0bytes", 9));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_THROW(write_file_atomically(folder, "x"), ResourceError);
  write_file_atomically("/dev/null", "x");
  EXPECT_TRUE(fs::is_character_file("/dev/null")) << "a device must not be replaced";
}

TEST_F(FileIo, ReadFileRefusesWhatIsNoFile) {
  EXPECT_THROW(read_file(folder / "none"), InputError);
  EXPECT_THROW(read_file(folder), InputError);
  EXPECT_THROW(read_file("/dev/zero"), InputError);
  write_file_atomically(folder / "file", "12345");
  EXPECT_EQ(read_file(folder / "file", 5), "12345");
  EXPECT_THROW(read_file(folder / "file", 4), InputError);
}

TEST_F(FileIo, ErrorsNameTheFileAndTheReason) {
  try {
    write_file_atomically(folder / "none" / "a", "x");
    FAIL() << "the folder does not exist";
  } catch (const ResourceError& error) {
    EXPECT_EQ(error.what(), "cannot write " + (folder / "none" / "a").string() + ": No such file or directory");
  }
}

}  // namespace
}  // namespace voxcarve
