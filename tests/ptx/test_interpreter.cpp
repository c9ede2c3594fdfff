// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/ptx/interpreter.hpp"

/// The interpreter on small programs, written as nvcc writes them.
namespace ra2d::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Order = PtxWarp::Order;
constexpr Order orders[] = {Order::in_step, Order::ascending, Order::descending, Order::shuffled};

/// A kernel of one address: %rd1, and %rd2 of the lane's own place there. Its lines begin at 10.
std::string kernel(const std::string& body) {
  return R"(.version 9.0
.visible .entry march(
	.param .u64 march_param_0
)
{
	ld.param.u64 	%rd1, [march_param_0];
	mov.u32 	%r1, %tid.x;
	mul.wide.u32 	%rd9, %r1, 8;  add.s64 %rd2, %rd1, %rd9;
	setp.eq.s32 	%p1, %r1, 0;
)" + body +
         "\n\tret;\n}\n";
}

struct Outcome {
  std::array<double, warp_width> values{};
  std::vector<std::string> races;
  std::vector<std::uint64_t> counts;
  std::uint64_t reductions = 0;
};

/// Runs a kernel on 32 values: 0, 1, ...
Outcome run(const std::string& body, Order order = Order::in_step,
            std::size_t ignored = static_cast<std::size_t>(-1)) {
  const Program program(kernel(body));
  Outcome outcome;
  for (int lane = 0; lane < warp_width; ++lane) outcome.values[lane] = lane;
  PtxWarp warp(program, order);
  warp.allow("values", outcome.values.data(), sizeof outcome.values, true);
  warp.ignore(ignored);
  warp.run({{reinterpret_cast<std::uint64_t>(outcome.values.data())}});
  outcome.races = warp.races();
  outcome.counts = warp.counts();
  outcome.reductions = warp.reductions();
  return outcome;
}

/// The fault that a warp, or a parser, finds in a kernel; empty: none.
std::string said_of(const std::string& body, Order order = Order::in_step) {
  try {
    run(body, order);
  } catch (const WarpFault& fault) {
    return fault.what();
  } catch (const PtxError& fault) {
    return fault.what();
  }
  return "";
}

TEST(Interpreter, ComputesInEachLane) {
  const Outcome outcome = run(R"(
	ld.global.f64 	%fd1, [%rd2];
	fma.rn.f64 	%fd2, %fd1, %fd1, 0d3FF0000000000000;
	sqrt.rn.f64 	%fd3, %fd2;
	neg.f64 	%fd4, %fd3;
	selp.f64 	%fd5, %fd4, %fd3, %p1;
	st.global.f64 	[%rd2], %fd5;)");
  EXPECT_EQ(outcome.values[0], -1);
  for (int lane = 1; lane < warp_width; ++lane)
    EXPECT_EQ(outcome.values[lane], std::sqrt(std::fma(lane, lane, 1.0)));
  EXPECT_THAT(outcome.races, IsEmpty());
}

// each result is known by hand
TEST(Interpreter, KnowsWholeNumbers) {
  const std::vector<std::pair<std::string, double>> cases = {
      {"add.s32 %r2, -2, 1", -1},
      {"sub.s32 %r2, 3, 5", -2},
      {"mul.lo.s32 %r2, -3, 5", -15},
      {"mad.lo.s32 %r2, -3, 5, 1", -14},
      {"div.s32 %r2, -7, 2", -3},
      {"rem.s32 %r2, -7, 2", -1},
      {"min.s32 %r2, -7, 2", -7},
      {"max.u32 %r2, -7, 2", -7},
      {"shr.s32 %r2, -8, 1", -4},
      {"shr.u32 %r2, -1, 28", 15},
      {"shr.s32 %r2, -8, 40", -1},
      {"shr.u32 %r2, -8, 40", 0},
      {"shl.b32 %r2, 3, 4", 48},
      {"shl.b32 %r2, 3, 32", 0},
      {"and.b32 %r2, 12, 10", 8},
      {"or.b32 %r2, 12, 10", 14},
      {"xor.b32 %r2, 12, 10", 6},
      {"not.b32 %r2, 0", -1},
      {"brev.b32 %r2, 1", -2147483648.0},
      {"bfind.shiftamt.u32 %r2, 1", 31},
      {"bfind.shiftamt.u32 %r2, 0", -1},
      {"clz.b32 %r2, 255", 24},
      {"popc.b32 %r2, 255", 8},
      {"abs.s32 %r2, -5", 5},
      {"neg.s32 %r2, 5", -5},
      {"cvt.rzi.s32.f64 %r2, 0dC004000000000000", -2},
      {"cvt.rmi.s32.f64 %r2, 0dC004000000000000", -3},
      {"cvt.rpi.s32.f64 %r2, 0dC004000000000000", -2},
      {"cvt.rni.s32.f64 %r2, 0dC004000000000000", -2},  // -2.5 to even
      {"cvt.rzi.s32.f64 %r2, 0d7FF0000000000000", 2147483647},
      {"cvt.rzi.s32.f64 %r2, 0d7FF8000000000000", 0}};
  for (const auto& [text, value] : cases)
    EXPECT_EQ(run(text + ";\n cvt.rn.f64.s32 %fd1, %r2; st.global.f64 [%rd2], %fd1;").values[5],
              value)
        << text;
}

TEST(Interpreter, KnowsHowNoNumbersAndZerosCompare) {
  const std::string none = "0d7FF8000000000000", one = "0d3FF0000000000000",
                    zero = "0d0000000000000000", minus_zero = "0d8000000000000000";
  const auto holds = [](const std::string& word, const std::string& a, const std::string& b) {
    return run("setp." + word + ".f64 %p2, " + a + ", " + b +
               "; selp.f64 %fd1, 0d3FF0000000000000, 0d0000000000000000, %p2;"
               " st.global.f64 [%rd2], %fd1;")
               .values[0] == 1;
  };
  for (const std::string word : {"eq", "ne", "lt", "le", "gt", "ge", "num"})
    EXPECT_FALSE(holds(word, none, one)) << word;
  for (const std::string word : {"equ", "neu", "ltu", "leu", "gtu", "geu", "nan"})
    EXPECT_TRUE(holds(word, none, one)) << word;
  EXPECT_TRUE(holds("eq", zero, minus_zero));
  EXPECT_FALSE(holds("neu", zero, minus_zero));
  const auto value = [](const std::string& text) {
    return run(text + "; st.global.f64 [%rd2], %fd1;").values[0];
  };
  EXPECT_EQ(value("max.f64 %fd1, " + none + ", " + one), 1);
  EXPECT_EQ(value("min.f64 %fd1, " + one + ", " + none), 1);
  EXPECT_TRUE(std::signbit(value("min.f64 %fd1, " + zero + ", " + minus_zero)));
  EXPECT_FALSE(std::signbit(value("max.f64 %fd1, " + minus_zero + ", " + zero)));
  EXPECT_EQ(value("copysign.f64 %fd1, " + minus_zero + ", " + one), -1);
}

/// The sum of the lanes' values, as WarpLanes computes it.
const std::string sum = [] {
  std::string text = "ld.global.f64 %fd1, [%rd2];";
  for (const int distance : {16, 8, 4, 2, 1})
    text += "\n mov.b64 {%r5, %r6}, %fd1; shfl.sync.bfly.b32 %r7|%p5, %r5, " +
            std::to_string(distance) + ", 31, -1; shfl.sync.bfly.b32 %r8|%p6, %r6, " +
            std::to_string(distance) +
            ", 31, -1; mov.b64 %fd2, {%r7, %r8}; add.rn.f64 %fd1, %fd1, %fd2;";
  return text + "\n";
}();

TEST(Interpreter, ExchangesBetweenLanesInAnyOrder) {
  for (const Order order : orders) {
    const Outcome outcome = run(sum + "st.global.f64 [%rd2], %fd1;", order);
    EXPECT_THAT(outcome.values, testing::Each(31 * 32 / 2));
    EXPECT_EQ(outcome.reductions, 1);
    const auto down =
        run("shfl.sync.down.b32 %r5|%p5, %r1, 1, 31, -1; cvt.rn.f64.s32 %fd1, %r5;"
            " st.global.f64 [%rd2], %fd1;",
            order);
    for (int lane = 0; lane < warp_width; ++lane)
      EXPECT_EQ(down.values[lane], std::min(lane + 1, warp_width - 1));
    const auto first =
        run("shfl.sync.idx.b32 %r5|%p5, %r1, 7, 31, -1; cvt.rn.f64.s32 %fd1, %r5;"
            " st.global.f64 [%rd2], %fd1;",
            order);
    EXPECT_THAT(first.values, testing::Each(7));
    const auto word =
        run("setp.lt.s32 %p2, %r1, 5; vote.sync.ballot.b32 %r5, %p2, -1; cvt.rn.f64.u32 %fd1, %r5;"
            " st.global.f64 [%rd2], %fd1;",
            order);
    EXPECT_THAT(word.values, testing::Each(31));
  }
}

TEST(Interpreter, TheClockCountsMeetings) {
  const Outcome outcome = run(R"(
	bar.warp.sync 	-1;
	bar.warp.sync 	-1;
	mov.u64 	%rd3, %globaltimer;
	cvt.rn.f64.u64 	%fd1, %rd3;
	st.f64 	[%rd2], %fd1;)");
  EXPECT_THAT(outcome.values, testing::Each(2.0));
}

/// The first lane alone goes round a loop, its others wait; then all go on together.
TEST(Interpreter, LanesPartAndGoOnTogether) {
  const std::string body = R"(
	@!%p1 bra 	$L__BB0_2;
	mov.u32 	%r2, 0;
$L__BB0_1:
	add.s32 	%r2, %r2, 1;
	setp.lt.s32 	%p2, %r2, 10;
	@%p2 bra 	$L__BB0_1;
	cvt.rn.f64.s32 	%fd1, %r2;
	st.global.f64 	[%rd2], %fd1;
$L__BB0_2:
	bar.warp.sync 	-1;
	ld.global.f64 	%fd2, [%rd1];
	bar.warp.sync 	-1;
	st.global.f64 	[%rd2], %fd2;)";
  for (const Order order : orders) {
    const Outcome outcome = run(body, order);
    EXPECT_THAT(outcome.values, testing::Each(10));
    EXPECT_THAT(outcome.races, IsEmpty());
  }
  const Outcome outcome = run(body);
  // before the loop 5 instructions and its branch; in it 1 + 10 * 3 + 2; then 4 and the end
  std::uint64_t all = 0;
  for (const std::uint64_t count : outcome.counts) all += count;
  EXPECT_EQ(all, 5 + 1 + 1 + 30 + 2 + 4 + 1);
}

/// Teams of eight lanes: each has its own exchanges, and goes round a loop as often as its first
/// value says. In the loop those that still do so go on together.
TEST(Interpreter, TeamsOfAWarpGoOnTogetherWhereTheyMeet) {
  const std::string text = R"(.version 9.0
.visible .entry march(
	.param .u64 march_param_0, .param .u64 march_param_1
)
{
	ld.param.u64 	%rd1, [march_param_0];
	ld.param.u32 	%r9, [march_param_1];
	mov.u32 	%r1, %tid.x;
	mov.u32 	%r2, %tid.y;
	mul.wide.u32 	%rd9, %r1, 8;  add.s64 %rd2, %rd1, %rd9;
	shl.b32 	%r3, %r2, 3;
	shl.b32 	%r4, 255, %r3;
	mov.u32 	%r5, 0;
	bra.uni 	$L__BB0_2;
$L__BB0_1:
	add.s32 	%r5, %r5, 1;
	shfl.sync.bfly.b32 %r6|%p5, %r1, 1, 6175, %r4;
	shfl.sync.down.b32 %r7|%p5, %r6, 1, 6175, %r4;
$L__BB0_2:
	bar.sync 	0;
	setp.lt.s32 	%p1, %r5, %r9;
	@%p1 bra 	$L__BB0_1;
	cvt.rn.f64.s32 	%fd1, %r7;
	st.global.f64 	[%rd2], %fd1;
	ret;
}
)";
  for (const Order order : orders) {
    const Program program(text);
    std::array<std::array<double, 8>, 4> values{};
    PtxWarp warp(program, order, 8);
    ASSERT_EQ(warp.teams(), 4);
    std::vector<std::vector<std::uint64_t>> parameters;
    const std::uint64_t rounds[] = {3, 5, 1, 2};
    for (int team = 0; team < 4; ++team) {
      warp.allow("values", values[team].data(), sizeof values[team], true, team);
      parameters.push_back({reinterpret_cast<std::uint64_t>(values[team].data()), rounds[team]});
    }
    warp.run(parameters);
    for (const auto& of_team : values) EXPECT_THAT(of_team, ElementsAre(0, 3, 2, 5, 4, 7, 6, 6));
    std::uint64_t adds = 0;
    for (std::size_t k = 0; k < program.instructions().size(); ++k)
      if (program.instructions()[k].opcode == "add.s32") adds += warp.counts()[k];
    if (order == Order::in_step) {
      EXPECT_EQ(adds, 5);  // as often as the one with most rounds
    }
    parameters[1][0] = parameters[0][0];  // what another team has
    EXPECT_THROW(warp.run(parameters), WarpFault);
  }
}

TEST(Interpreter, AMissingSyncIsARaceInAnyOrder) {
  // the first lane writes what all read
  const std::string reads = "ld.global.f64 %fd1, [%rd1];\n";
  const std::string writes = R"(
	@!%p1 bra $L__BB0_1;
	st.global.f64 [%rd1], 0d3FF0000000000000;
$L__BB0_1:
)";
  for (const Order order : orders) {
    for (const std::string& body :
         {reads + "bar.warp.sync -1;\n" + writes, writes + "bar.warp.sync -1;\n" + reads}) {
      EXPECT_THAT(run(body, order).races, IsEmpty());
      const Program program(kernel(body));
      ASSERT_THAT(program.syncs(), SizeIs(1));
      EXPECT_THAT(run(body, order, program.syncs()[0]).races, SizeIs(1));
    }
    // two writers; a shuffle, and a block's sync, which are taken to order no memory
    EXPECT_THAT(run("st.global.f64 [%rd1], 0d0000000000000000;", order).races, SizeIs(1));
    EXPECT_THAT(run(writes + "shfl.sync.idx.b32 %r5|%p5, %r1, 7, 31, -1;\n" + reads, order).races,
                SizeIs(1));
    EXPECT_THAT(run(writes + "bar.sync 0;\n" + reads, order).races, SizeIs(1));
  }
}

TEST(Interpreter, NamesTheLinesOfARace) {
  const auto races = run(".file 1 \"kernels/gap.hpp\"\n.loc 1 34 5\nst.global.f64 [%rd1], "
                         "0d0000000000000000;")
                         .races;
  ASSERT_THAT(races, SizeIs(1));
  EXPECT_THAT(races[0], HasSubstr("line 12 (gap.hpp:34): st.global.f64"));
}

TEST(Interpreter, AnAccessOutsideTheArraysIsAFault) {
  for (const std::string access :
       {"ld.global.f64 %fd1, [%rd2+8];", "st.global.f64 [%rd2+8], 0d0000000000000000;",
        "ld.f64 %fd1, [%rd2+-8];", "ld.global.v2.f64 {%fd1, %fd2}, [%rd2];"})
    EXPECT_THAT(said_of(access), HasSubstr("outside its arrays at line 10: ")) << access;
  EXPECT_THAT(said_of("ld.global.f64 %fd1, [%rd2+4];"), HasSubstr("not aligned at line 10: "));
  EXPECT_THAT(said_of("ld.local.f64 %fd1, [%rd2];"), HasSubstr("outside its arrays"));
}

TEST(Interpreter, LocalMemoryIsALanesOwn) {
  const std::string own = R"(
	.local .align 16 .b8 	__local_depot0[16];
	mov.u64 	%SPL, __local_depot0;
	cvt.rn.f64.s32 	%fd1, %r1;
	st.local.f64 	[%SPL+8], %fd1;
	ld.local.f64 	%fd2, [%SPL+8];
	st.global.f64 	[%rd2], %fd2;)";
  for (const Order order : orders) {
    const Outcome outcome = run(own, order);
    for (int lane = 0; lane < warp_width; ++lane) EXPECT_EQ(outcome.values[lane], lane);
  }
  EXPECT_THAT(said_of(own + "\n ld.local.f64 %fd2, [%SPL+16];"), HasSubstr("outside its arrays"));
  EXPECT_THAT(said_of(own + "\n ld.f64 %fd2, [%SPL+-8];"), HasSubstr("outside its arrays"));
}

TEST(Interpreter, LanesThatMeetElsewhereAreAFault) {
  const std::string parted = R"(
	@%p1 bra 	$L__BB0_1;
	bar.warp.sync 	-1;
	ret;
$L__BB0_1:
	bar.warp.sync 	-1;)";
  const std::string one_ended = "@!%p1 bra $L__BB0_1;\n ret;\n$L__BB0_1:\n bar.warp.sync -1;";
  for (const Order order : orders) {
    EXPECT_THAT(said_of(parted, order), HasSubstr("is to meet the others at line"));
    EXPECT_THAT(said_of(one_ended, order), HasSubstr("has ended, and others are to meet"));
    EXPECT_THAT(said_of("@%p1 bra $L__BB0_1;\n bar.sync 0;\n$L__BB0_1:", order),
                HasSubstr("has ended, and others are to meet"));
    EXPECT_THAT(said_of("bar.warp.sync 1;", order),
                HasSubstr("a meeting of other lanes than a team's"));
  }
}

TEST(Interpreter, WhatItDoesNotKnowIsNamedWithItsLine) {
  for (const std::string text :
       {"sin.approx.f32 %f1, %f2;", "add.f16 %h1, %h2, %h3;", "call.uni f, ();",
        "mov.u32 %r1, %ctaid.x;", "ld.shared.f64 %fd1, [%rd1];", "bra nowhere;", "@%p1 ret;",
        "shfl.sync.up.b32 %r5|%p5, %r1, 1, 0, -1;", ".shared .b8 tile[64];"})
    EXPECT_THAT(said_of(text), HasSubstr("PTX line ")) << text;
  EXPECT_THAT(said_of("sin.approx.f32 %f1, %f2;"),
              testing::StrEq("PTX line 10: this instruction is not known here: "
                             "sin.approx.f32 %f1, %f2;"));
  EXPECT_THROW(Program("not a program"), PtxError);
  EXPECT_THROW(Program::read("nowhere.ptx"), PtxError);
}

TEST(Interpreter, ACacheMissesWhatItNeverSawAndWhatItHadToDrop) {
  alignas(ModelCache::sector) std::array<double, warp_width> values{};
  const Program program(kernel("ld.f64 %fd1, [%rd2]; ld.f64 %fd2, [%rd1];"));
  ModelCache cache(1 << 10);
  for (int times = 0; times < 2; ++times) {
    PtxWarp warp(program);
    warp.allow("values", values.data(), sizeof values, false);
    warp.add_cache(cache);
    warp.run({{reinterpret_cast<std::uint64_t>(values.data())}});
    EXPECT_EQ(cache.missed_bytes(), sizeof values);  // then it has them
  }
  ModelCache one_set(16 * ModelCache::sector);
  for (std::uint64_t round = 0; round < 3; ++round)
    for (std::uint64_t sector = 1; sector <= 16; ++sector) one_set.access(sector);
  EXPECT_EQ(one_set.missed_bytes(), 16 * ModelCache::sector);
  one_set.access(17);  // in place of 1, then 1 of 2
  one_set.access(1);
  one_set.access(3);
  EXPECT_EQ(one_set.missed_bytes(), 18 * ModelCache::sector);
}

}  // namespace
}  // namespace ra2d::test
