#include "experiments/runner/table.h"

#include <gtest/gtest.h>

namespace voxcarve {
namespace {

TEST(Table, AlignsNumbersRightAndTextLeft) {
  const Table table{{"method", "genus"}, {{"qslim", "1"}, {"alpha-wrap", "12"}}};
  EXPECT_EQ(to_text(table),
            "method      genus\n"
            "----------  -----\n"
            "qslim           1\n"
            "alpha-wrap     12\n");
}

TEST(Table, CsvQuotesWhatNeedsIt) {
  const Table table{{"a", "b"}, {{"plain", "with, comma"}, {"say \"so\"", "two\nlines"}}};
  EXPECT_EQ(to_csv(table), "a,b\nplain,\"with, comma\"\n\"say \"\"so\"\"\",\"two\nlines\"\n");
}

TEST(Table, Numbers) {
  EXPECT_EQ(with_thousands(0), "0");
  EXPECT_EQ(with_thousands(999), "999");
  EXPECT_EQ(with_thousands(1234567), "1,234,567");
  EXPECT_EQ(with_thousands(-1000), "-1,000");
  EXPECT_EQ(with_thousands(-100), "-100");
  EXPECT_EQ(rounded(0.123456, 3), "0.123");
  EXPECT_EQ(rounded(1234.5, 6), "1234.5");
}

}  // namespace
}  // namespace voxcarve
