// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/csv.hpp"

#include <gtest/gtest.h>

namespace ra2d {
namespace {

TEST(Csv, QuotesAFieldThatNeedsIt) {
  EXPECT_EQ(csv_field("out.h5"), "out.h5");
  EXPECT_EQ(csv_field(""), "");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("a \"b\""), "\"a \"\"b\"\"\"");
  EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
}

}  // namespace
}  // namespace ra2d
