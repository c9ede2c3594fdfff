// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "kernels/contact/cell_complementarity.hpp"
#include "kernels/contact/cell_contact.hpp"
#include "kernels/contact/cell_parts.hpp"
#include "kernels/contact/moving_cell.hpp"
#include "tests/dice.hpp"
#include "tests/numbers.hpp"

/// Contact integrated over a cell, against closed forms and against sums over many small intervals.
namespace {

using namespace ra2d;
using test::Dice;

using test::eps;

Cubic random_cubic(Dice& dice) {
  return {{dice.uniform(-1, 1), dice.uniform(-2, 2), dice.uniform(-4, 4), dice.uniform(-8, 8)}};
}

/// The contact in a cell, by the parts that the march evaluates side by side.
CellContact contact_in_cell(const CellFaces& faces, double theta, const Cubic& displacement) {
  std::array<double, cell_part_rows * CellParts<HostLanes>::capacity> memory;
  CellParts<HostLanes> parts(HostLanes(), memory.data());
  parts.add_cell(7, faces, theta, displacement);
  parts.integrate();
  CellContact sum;
  for (int part = 0; part < parts.count(); ++part) {
    EXPECT_EQ(parts.cell(part), 7);
    sum = sum + parts.integrals(part);
  }
  return sum;
}

long double at(const Cubic& p, long double x) {
  return p.c[0] + x * (p.c[1] + x * (p.c[2] + x * p.c[3]));
}

TEST(SplinePiece, GoesThroughItsNodesWithTheirBends) {
  const Cubic p = spline_piece(3, 5, 0.5, -0.25);
  EXPECT_EQ(p(0), 3);
  EXPECT_NEAR(p(1), 5, 8 * eps);
  EXPECT_EQ(2 * p.c[2], 0.5);
  EXPECT_NEAR(2 * p.c[2] + 6 * p.c[3], -0.25, 4 * eps);
  const Cubic q = p.about(0.25);
  for (const double x : {-0.25, 0.0, 0.5}) EXPECT_NEAR(q(x), p(x + 0.25), 16 * eps);
  EXPECT_NEAR(q.slope(0.1), p.slope(0.35), 16 * eps);
}

TEST(AddContact, IsTheSumOverManySmallIntervals) {
  Dice dice(1);
  int closed = 0, part = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Cubic o = random_cubic(dice), face = random_cubic(dice);
    const double from = dice.uniform(-0.5, 0), to = dice.uniform(0, 0.5);
    CellContact sum;
    add_contact(o, face, from, to, sum);
    std::array<long double, 6> expected{};
    constexpr int parts = 4000;
    const long double width = (static_cast<long double>(to) - from) / parts;
    int positive = 0;
    for (int i = 0; i < parts; ++i) {
      const long double x = from + (i + 0.5L) * width, over = at(o, x);
      if (over <= 0) continue;
      ++positive;
      for (int j = 0; j < 4; ++j) expected[j] += over * std::pow(x, j) * width;
      expected[4] += over * over * width;
      expected[5] += over * (face.c[1] + x * (2 * face.c[2] + x * 3 * face.c[3])) * width;
    }
    closed += positive == parts;
    part += positive > 0 && positive < parts;
    // the midpoint rule is off by width^2/24 of the second derivatives, below 600 in all of these,
    // and by width^2 of the slope at each of up to four ends
    const auto bound = static_cast<double>(40 * width * width);
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(sum.moment[j], static_cast<double>(expected[j]), bound) << "trial " << trial;
    EXPECT_NEAR(sum.square, static_cast<double>(expected[4]), 10 * bound);
    EXPECT_NEAR(sum.face_work, static_cast<double>(expected[5]), 10 * bound);
  }
  EXPECT_GT(closed, 20);
  EXPECT_GT(part, 100);
}

TEST(AddContact, OfAParabolaWhereverItStands) {
  // o = depth - (eta - place)^2: 4/3 depth^(3/2), about its own middle
  for (const double depth : {1e-12, 1e-6, 1e-3, 0.02})
    for (const double place : {-0.3, -0.01, 0.0, 0.2}) {
      const Cubic o{{depth - place * place, 2 * place, -1, 0}};
      CellContact sum;
      add_contact(o, Cubic{}, -0.5, 0.5, sum);
      const double exact = 4.0 / 3 * depth * std::sqrt(depth);
      // depth is a small difference: half an ulp of place^2 of it, and its root
      const double bound = (8 * eps + 2 * eps * place * place / depth) * exact;
      EXPECT_NEAR(sum.moment[0], exact, bound) << depth << " " << place;
      EXPECT_NEAR(sum.moment[1], place * exact, 2 * bound + 8 * eps * exact);
      EXPECT_NEAR(sum.square, 16.0 / 15 * depth * depth * std::sqrt(depth), 3 * depth * bound);
    }
}

TEST(AddContact, NothingWhereItIsOpenAndAllWhereItIsClosed) {
  CellContact none;
  add_contact({{-1, 0, 0, 0}}, {{0, 1, 0, 0}}, -0.5, 0.5, none);
  add_contact({{-1, 1.9, 0, 0}}, {{0, 1, 0, 0}}, -0.5, 0.5, none);
  add_contact({{-0.26, 0, 1, 0}}, {{0, 1, 0, 0}}, -0.5, 0.5, none);
  add_contact({{std::nan(""), 0, 0, 0}}, {{0, 1, 0, 0}}, -0.5, 0.5, none);
  EXPECT_EQ(none.moment[0], 0);
  EXPECT_EQ(none.square, 0);
  CellContact all;
  add_contact({{2, 0, 0, 0}}, {{0, 3, 0, 0}}, -0.5, 0.5, all);
  EXPECT_EQ(all.moment[0], 2);
  EXPECT_EQ(all.moment[1], 0);
  EXPECT_NEAR(all.moment[2], 2.0 / 12, eps);
  EXPECT_EQ(all.square, 4);
  EXPECT_EQ(all.face_work, 6);
}

TEST(HighestOn, IsAsHighAsAnyOfMany) {
  Dice dice(3);
  int within = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Cubic o = random_cubic(dice);
    const double from = dice.uniform(-0.5, 0), to = dice.uniform(0, 0.5);
    const auto [value, place] = highest_on(o, from, to);
    EXPECT_EQ(value, o(place));
    ASSERT_GE(place, from);
    ASSERT_LE(place, to);
    within += place > from && place < to;
    constexpr int parts = 1000;
    for (int i = 0; i <= parts; ++i)
      EXPECT_LE(o(from + (to - from) * i / parts), o(place) + 8 * eps) << "trial " << trial;
  }
  EXPECT_GT(within, 60);
  EXPECT_EQ(highest_on({{1, 0, 0, 0}}, -0.5, 0.25).place, -0.5);
  EXPECT_EQ(highest_on({{1, 2, 0, 0}}, -0.5, 0.25).place, 0.25);
  EXPECT_EQ(highest_on({{std::nan(""), 0, 0, 0}}, -0.5, 0.25).place, -0.5);
}

/// The force is the slope of the contact's energy: so energy can close.
TEST(ContactInCell, ForceIsTheSlopeOfItsEnergy) {
  Dice dice(2);
  int touching = 0;
  for (int trial = 0; trial < 200; ++trial) {
    CellFaces faces;
    faces.own = random_cubic(dice);
    // two pieces of one spline: equal to the second derivative where they meet
    const double h[3] = {dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)};
    const double b[3] = {dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)};
    faces.passing[0] = spline_piece(h[0], h[1], b[0], b[1]);
    faces.passing[1] = spline_piece(h[1], h[2], b[1], b[2]);
    const double theta = dice.uniform(0, 1);
    const Cubic rest = random_cubic(dice);
    const CellContact contact = contact_in_cell(faces, theta, rest);
    touching += contact.moment[0] > 0;
    for (int j = 0; j < 4; ++j) {
      constexpr double step = 1e-5;
      const auto energy = [&](double shift) {
        Cubic moved = rest;
        moved.c[j] += shift;
        return 0.5 * contact_in_cell(faces, theta, moved).square;
      };
      // the energy's third derivative is some one over the slope at an end of the contact
      EXPECT_NEAR((energy(step) - energy(-step)) / (2 * step), contact.moment[j], 1e-8)
          << "trial " << trial << ", power " << j;
    }
  }
  EXPECT_GT(touching, 100);
}

/// Cells of all kinds beside one another, each as it is by itself: concave ones, others, narrow
/// contacts, ones without; as many as there is room for. And the same whatever stands beside them.
TEST(CellParts, AreEachTheIntegralOverItself) {
  using Parts = CellParts<HostLanes>;
  Dice dice(4);
  int touching = 0, narrow = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::array<double, cell_part_rows * Parts::capacity> memory, other_memory;
    memory.fill(std::nan("")), other_memory.fill(std::nan(""));
    Parts parts(HostLanes(), memory.data());
    const double size = dice.ratio(1e-12, 1), theta = dice.uniform(0, 1);
    struct Cell {
      CellFaces faces;
      Cubic rest;
    };
    std::deque<Cell> cells;  // open ones have no parts: there may be more than there is room for
    for (int count = 0; parts.has_room(); ++count) {
      auto& [faces, rest] = cells.emplace_back();
      const double h[3] = {dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)};
      const double b[3] = {dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1)};
      faces.own = Cubic{};
      faces.passing[0] = spline_piece(h[0], h[1], b[0], b[1]);
      faces.passing[1] = spline_piece(h[1], h[2], b[1], b[2]);
      rest = random_cubic(dice);
      if (dice.one_in(2)) rest.c[2] = -std::abs(rest.c[2]) - 2;
      if (dice.one_in(3)) {  // just in contact, or just not
        const Cubic o = rest + faces.passing[0].about(theta + 0.5);
        rest.c[0] +=
            dice.uniform(-1, 3) * dice.ratio(1e-12, 1e-3) - highest_on(o, -0.5, 0.5 - theta).value;
      }
      for (Cubic* cubic : {&rest, &faces.passing[0], &faces.passing[1]})
        for (double& c : cubic->c) c *= size;
      parts.add_cell(count, faces, theta, rest);
    }
    parts.integrate();
    for (int part = 0; part < parts.count();) {
      const int cell = parts.cell(part);
      const auto& [faces, rest] = cells[cell];
      CellContact sum;
      for (; part < parts.count() && parts.cell(part) == cell; ++part)
        sum = sum + parts.integrals(part);
      CellContact expected;
      const Cubic before = faces.passing[0].about(theta + 0.5),
                  after = faces.passing[1].about(theta - 0.5);
      add_contact(rest + before, before, -0.5, 0.5 - theta, expected);
      add_contact(rest + after, after, 0.5 - theta, 0.5, expected);
      touching += expected.moment[0] > 0;
      narrow += expected.moment[0] > 0 && expected.moment[0] < 1e-6 * size;
      // by the roundings of the cubics, of a size near 10: over the whole cell, and at the summit
      // of a narrow contact
      const double bound = 64 * eps * 10 * size;
      for (int j = 0; j < 4; ++j)
        ASSERT_NEAR(sum.moment[j], expected.moment[j], bound) << "trial " << trial;
      ASSERT_NEAR(sum.square, expected.square, 10 * bound * size) << "trial " << trial;
      ASSERT_NEAR(sum.face_work, expected.face_work, 10 * bound * size) << "trial " << trial;
      Parts alone(HostLanes(), other_memory.data());
      alone.add_cell(cell, faces, theta, rest);
      alone.integrate();
      CellContact same;
      for (int i = 0; i < alone.count(); ++i) same = same + alone.integrals(i);
      for (int j = 0; j < 4; ++j) ASSERT_EQ(sum.moment[j], same.moment[j]) << "trial " << trial;
      ASSERT_EQ(sum.square, same.square);
      ASSERT_EQ(sum.face_work, same.face_work);
    }
  }
  EXPECT_GT(touching, 3000);
  EXPECT_GT(narrow, 300);
}

TEST(CellParts, OfParabolasHaveTheirDigitsHoweverNarrow) {
  // o = depth - (eta - place)^2: 4/3 depth^(3/2), about its own middle
  for (const double depth : {1e-12, 1e-6, 1e-3, 0.02})
    for (const double place : {-0.3, -0.01, 0.0, 0.2}) {
      CellFaces faces{};
      const CellContact sum =
          contact_in_cell(faces, 0, {{depth - place * place, 2 * place, -1, 0}});
      const double exact = 4.0 / 3 * depth * std::sqrt(depth);
      const double bound = (8 * eps + 2 * eps * place * place / depth) * exact;
      EXPECT_NEAR(sum.moment[0], exact, bound) << depth << " " << place;
      EXPECT_NEAR(sum.moment[1], place * exact, 2 * bound + 8 * eps * exact);
      EXPECT_NEAR(sum.square, 16.0 / 15 * depth * depth * std::sqrt(depth), 3 * depth * bound);
    }
}

/// Contact in one part a lane, found from where it began and ended a little before: as found anew.
/// Where that is not enough it says so: never a wrong answer.
TEST(CellParts, FollowContactFromWhereItWas) {
  using Parts = CellParts<HostLanes>;
  using Real = HostLanes::Real;
  constexpr int width = HostLanes::width;
  const HostLanes lanes;
  Dice dice(6);
  int followed = 0, plainly_open = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<double, cell_part_rows * Parts::capacity> memory{};
    Parts parts(lanes, memory.data());
    std::array<Cubic, width> o, face;
    std::array<double, width> left, right, change, near;
    for (int i = 0; i < width; ++i) {
      o[i] = random_cubic(dice), face[i] = random_cubic(dice);
      o[i].c[2] = -std::abs(o[i].c[2]) - (dice.one_in(20) ? 0 : 4);
      o[i].c[3] *= 0.1;
      left[i] = dice.one_in(2) ? -0.5 : dice.uniform(-0.5, 0.4);
      right[i] = dice.uniform(left[i] + 0.05, 0.5);
      change[i] = dice.uniform(-1, 1) * dice.ratio(1e-6, dice.one_in(2) ? 1e-3 : 0.3);
      if (dice.one_in(4)) o[i].c[0] -= 2;  // no contact
    }
    const auto pack = [&](const auto& number) {
      return Real([&](std::size_t i) { return number(static_cast<int>(i)); });
    };
    Real f[4], now[4], then[4], at_left[4], at_right[4];
    for (int j = 0; j < 4; ++j) {
      now[j] = pack([&](int i) { return o[i].c[j]; });
      f[j] = pack([&](int i) { return face[i].c[j]; });
      then[j] = now[j] + (j == 0 ? pack([&](int i) { return change[i]; }) : Real(0.0));
    }
    const Real from = pack([&](int i) { return left[i]; }),
               to = pack([&](int i) { return right[i]; });
    shift_cubic(then, from, at_left);
    shift_cubic(then, to, at_right);
    for (int i = 0; i < width; ++i) {
      Cubic moved = o[i];
      moved.c[0] += change[i];
      near[i] = highest_on(moved, left[i], right[i]).value;
    }
    Parts::Integrals before, found;
    parts.integrate(now, f, from, to, Parts::roots_close, before);
    if (!parts.integrate_from(then, f, from, to, at_left, at_right,
                              pack([&](int i) { return near[i]; }), before.low, before.high, found))
      continue;
    ++followed;
    for (int i = 0; i < width; ++i) {
      Cubic moved = o[i];
      moved.c[0] += change[i];
      CellContact expected;
      add_contact(moved, face[i], left[i], right[i], expected);
      plainly_open += expected.moment[0] == 0;
      // the roots are off by 1e-7 of the contact, what is integrated by the square of that
      for (int j = 0; j < 4; ++j)
        ASSERT_NEAR(found.moment[j][i], expected.moment[j], 640 * eps) << "trial " << trial;
      ASSERT_NEAR(found.square[i], expected.square, 6400 * eps) << "trial " << trial;
      ASSERT_NEAR(found.face_work[i], expected.face_work, 6400 * eps) << "trial " << trial;
    }
  }
  EXPECT_GT(followed, 1000);
  EXPECT_GT(plainly_open, 1000);
}

/// Of any cubic between any two places: no lower than at many places, and as high as at one.
TEST(HighestBetween, IsTheLargestValue) {
  Dice dice(5);
  for (int trial = 0; trial < 2000; ++trial) {
    double c[4];
    for (double& x : c) x = dice.one_in(8) ? 0.0 : dice.uniform(-1, 1);
    const double from = dice.uniform(-0.5, 0.5), to = dice.uniform(from, 0.5);
    const double highest = highest_between(c, from, to);
    const auto at = [&](double x) { return ((c[3] * x + c[2]) * x + c[1]) * x + c[0]; };
    double most = at(to);
    constexpr int places = 400;
    for (int i = 0; i < places; ++i) most = std::max(most, at(from + (to - from) * i / places));
    EXPECT_GE(highest, most - 8 * eps) << "trial " << trial;
    // between two places the cubic rises by no more than its second derivative over 8 allows
    const double step = (to - from) / places, second = 2 * std::abs(c[2]) + 3 * std::abs(c[3]);
    EXPECT_LE(highest, most + second * step * step / 8 + 8 * eps) << "trial " << trial;
  }
}

}  // namespace
