// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/compare.hpp"
#include "tests/numbers.hpp"
#include "tests/outcomes.hpp"

/// Messages of the tests about two runs that differ: a test of tests.
namespace ra2d::test {
namespace {

using testing::HasSubstr;

/// Four samples of two and one modes, a microsecond apart, and two shocks.
Recording small_recording() {
  Recording r;
  r.model.tick = 1e-7;
  SampleBlock& s = r.samples;
  s.time = {0, 1e-6, 2e-6, 3e-6};
  s.resonator_displacement = {1, 2, 3, 4, 5, 6, 7, 8};
  s.resonator_velocity = {0, 0, 0.25, 0.5, -1, 2, 0.125, 1};
  s.slider_displacement = {1, 1, 1, 1};
  s.slider_velocity = {0, 0, 0, 0};
  s.force = {0, 0, 3, 0};
  r.shocks = {
      {.serial = 0, .start = 5, .last = 9, .peak = 2, .impulse = 3, .moment = 4, .place = 0},
      {.serial = 1, .start = 12, .last = 13, .peak = 1, .impulse = 1, .moment = 1, .place = 0}};
  r.end.resonator_u = {7, 8};
  return r;
}

double next(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }

std::string said(const testing::AssertionResult& result) { return result.message(); }

TEST(Compare, TheSameIsTheSame) {
  EXPECT_TRUE(same(small_recording(), small_recording()));
  Recording r = small_recording();
  r.samples.force[1] = r.end.energy = std::nan("");
  EXPECT_TRUE(same(r, r)) << "bits, not values";
}

TEST(Compare, OneBitOfOneSampleIsNamed) {
  const Recording a = small_recording();
  Recording b = a;
  b.samples.resonator_velocity[5] = next(2.0);
  const testing::AssertionResult result = same(a, b);
  EXPECT_FALSE(result);
  EXPECT_EQ(said(result),
            "1 of 50 quantities differ:\n"
            "  resonator velocity: sample 2 (t = 2e-06 s), mode 1: 2 and 2.0000000000000004, 1 ulp "
            "apart; 1 of 8 differ");
}

TEST(Compare, TheEarliestIsSaidFirst) {
  const Recording a = small_recording();
  Recording b = a;
  b.end.resonator_u[1] = 9;
  b.samples.force[3] = 1;
  b.samples.slider_displacement = {1, 2, 2, 2};
  b.shocks[0].impulse = next(next(3.0));
  const std::string text = said(same(a, b));
  EXPECT_EQ(
      text,
      "4 of 50 quantities differ:\n"
      "  shocks: impulse: shock 0 (t = 5e-07 s): 3 and 3.000000000000001, 2 ulps apart; 1 of 2 "
      "differ\n"
      "  slider displacement: sample 1 (t = 1e-06 s): 1 and 2, 4503599627370496 ulps apart; 3 "
      "of 4 differ\n"
      "  force: sample 3 (t = 3e-06 s): 0 and 1, 4607182418800017408 ulps apart; 1 of 4 differ\n"
      "  last resonator displacement: mode 1: 8 and 9, 562949953421312 ulps apart; 1 of 2 "
      "differ");
}

TEST(Compare, ASignOfZeroAndWhatIsNoNumberDiffer) {
  EXPECT_THAT(said(same("x", {0.0}, {-0.0})), HasSubstr("0 and -0, which is a zero's sign"));
  EXPECT_THAT(said(same("x", {nan}, {1.0})), HasSubstr("nan and 1; 1 of 1"));
  EXPECT_FALSE(same("x", {nan}, {-nan}));
  // across zero
  EXPECT_THAT(said(same("x", {-5e-324}, {5e-324})), HasSubstr("2 ulps apart"));
  EXPECT_THAT(said(same("x", {1e308}, {-1e308})), HasSubstr("ulps apart"));
}

TEST(Compare, OneThatIsShorterIsSo) {
  const Recording a = small_recording();
  Recording b = a;
  b.shocks.pop_back();
  b.samples.force.pop_back();
  const std::string text = said(same(a, b));
  EXPECT_THAT(text,
              HasSubstr("shocks: peak: 2 and 1 numbers; the same up to shock 1 (t = 1.2e-06 s)"));
  EXPECT_THAT(text, HasSubstr("force: 4 and 3 numbers; the same up to sample 3 (t = 3e-06 s)"));
  b.samples.force[0] = 1;
  EXPECT_THAT(said(same(a, b)), HasSubstr("force: 4 and 3 numbers; sample 0 (t = 0 s): 0 and 1"));
}

TEST(Compare, WholeNumbersAreTold) {
  const Recording a = small_recording();
  Recording b = a;
  b.shocks[1].start = (std::int64_t{1} << 60) + 1;
  b.end.status = Status::unstable;
  const std::string text = said(same(a, b));
  EXPECT_THAT(text,
              HasSubstr("shocks: start: shock 1 (t = 1.2e-06 s): 12 and 1152921504606846977"));
  EXPECT_THAT(text, HasSubstr("status: 0 and 2"));
}

TEST(Compare, WhatIsDrainedIsNamed) {
  Outcome a;
  a.lanes = 2;
  a.sample_interval = 1e-6;
  for (int i = 0; i < 3 * (4 + sample::columns); ++i) a.rows.push_back(i);
  Outcome b = a;
  EXPECT_TRUE(same(a, b));
  b.rows[10 + 3] = next(13.0);
  b.rows[20 + 4 + sample::sliding_work] = 0;
  const std::string text = said(same(a, b));
  EXPECT_THAT(text,
              HasSubstr("velocity: sample 1 (t = 1e-06 s), mode 1: 13 and 13.000000000000002"));
  EXPECT_THAT(text, HasSubstr("sliding work: sample 2 (t = 2e-06 s): 28 and 0"));
}

}  // namespace
}  // namespace ra2d::test
