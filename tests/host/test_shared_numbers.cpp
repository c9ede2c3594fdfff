// SPDX-License-Identifier: BSD-3-Clause
#include "host/base/shared_numbers.hpp"

#include <gtest/gtest.h>

#include "host/run/result_header.hpp"
#include "tests/scenes.hpp"

namespace ra2d {
namespace {

TEST(SharedNumbers, AreHeldOnceUntilOneChangesThem) {
  SharedNumbers one{1, 2, 3};
  SharedNumbers other = one;
  EXPECT_EQ(one.data(), other.data());
  other.edit()[1] = 7;
  EXPECT_EQ(one, (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(other, (std::vector<double>{1, 7, 3}));
  const double* const own = other.data();
  other.edit()[0] = 4;  // nobody else has them any more
  EXPECT_EQ(other.data(), own);
}

TEST(SharedNumbers, HoldTheHeightsOfAModelItsCopiesAndItsResult) {
  const Model model = make_model(test::pressed_plate());
  const Model copy = model;
  EXPECT_EQ(copy.resonator_height.data(), model.resonator_height.data());
  EXPECT_EQ(copy.slider_height.data(), model.slider_height.data());
  const ResultHeader header = result_header(copy, "key");
  EXPECT_EQ(header.resonator_height.data(), model.resonator_height.data());
  EXPECT_EQ(header.slider_height.data(), model.slider_height.data());
}

}  // namespace
}  // namespace ra2d
