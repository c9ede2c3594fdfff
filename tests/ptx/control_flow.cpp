// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/control_flow.hpp"

#include <algorithm>
#include <utility>

namespace ra2d::test {
namespace {

using Kind = Instruction::Kind;

/// Instructions that run one after the other, and where they go on.
struct Block {
  std::size_t begin = 0, end = 0;
  std::vector<int> next, before;
};

/// The blocks of a program, and one more for its end.
std::vector<Block> blocks_of(const std::vector<Instruction>& program) {
  const std::size_t count = program.size();
  std::vector<char> begins(count + 1, 0);
  begins[0] = begins[count] = 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (program[i].kind == Kind::branch) begins[static_cast<std::size_t>(program[i].target)] = 1;
    if (program[i].kind == Kind::branch || program[i].kind == Kind::end) begins[i + 1] = 1;
  }
  std::vector<Block> blocks;
  std::vector<int> block_at(count + 1, 0);
  for (std::size_t i = 0; i <= count; ++i) {
    if (begins[i] != 0) {
      if (!blocks.empty()) blocks.back().end = i;
      blocks.emplace_back().begin = i;
    }
    block_at[i] = static_cast<int>(blocks.size()) - 1;
  }
  const int exit = static_cast<int>(blocks.size()) - 1;
  blocks.back().end = count;
  for (int b = 0; b < exit; ++b) {
    Block& block = blocks[static_cast<std::size_t>(b)];
    const Instruction& last = program[block.end - 1];
    if (last.kind == Kind::branch)
      block.next.push_back(block_at[static_cast<std::size_t>(last.target)]);
    if (last.kind == Kind::end)
      block.next.push_back(exit);
    else if (last.kind != Kind::branch || last.guard >= 0)
      block.next.push_back(block_at[block.end]);
    for (const int next : block.next) blocks[static_cast<std::size_t>(next)].before.push_back(b);
  }
  return blocks;
}

}  // namespace

// Cooper, Harvey and Kennedy, "A simple, fast dominance algorithm" (2001), from the end backwards.
std::vector<std::size_t> ways_join_at(const std::vector<Instruction>& program) {
  const std::vector<Block> blocks = blocks_of(program);
  const auto of = [&](int b) -> const Block& { return blocks[static_cast<std::size_t>(b)]; };
  const int exit = static_cast<int>(blocks.size()) - 1;
  std::vector<int> rank(blocks.size(), -1), join(blocks.size(), -1), order;  // deepest first
  std::vector<std::pair<int, std::size_t>> path = {{exit, 0}};
  rank[static_cast<std::size_t>(exit)] = 0;
  while (!path.empty()) {
    auto& [b, done] = path.back();
    if (done < of(b).before.size()) {
      const int other = of(b).before[done++];
      if (int& seen = rank[static_cast<std::size_t>(other)]; seen < 0) {
        seen = 0;
        path.emplace_back(other, 0);
      }
    } else {
      rank[static_cast<std::size_t>(b)] = static_cast<int>(order.size());
      order.push_back(b);
      path.pop_back();
    }
  }
  join[static_cast<std::size_t>(exit)] = exit;
  const auto common = [&](int a, int b) {
    while (a != b) {
      int& lower = rank[static_cast<std::size_t>(a)] < rank[static_cast<std::size_t>(b)] ? a : b;
      lower = join[static_cast<std::size_t>(lower)];
    }
    return a;
  };
  for (bool changed = true; changed;) {
    changed = false;
    for (auto b = order.rbegin() + 1; b < order.rend(); ++b) {
      int found = -1;
      for (const int next : of(*b).next)
        if (join[static_cast<std::size_t>(next)] >= 0)
          found = found < 0 ? next : common(next, found);
      changed = changed || join[static_cast<std::size_t>(*b)] != found;
      join[static_cast<std::size_t>(*b)] = found;
    }
  }
  std::vector<std::size_t> ways(program.size(), nowhere);
  for (int b = 0; b < exit; ++b) {
    const int to = join[static_cast<std::size_t>(b)];
    if (program[of(b).end - 1].kind == Kind::branch && to >= 0 && to != exit)
      ways[of(b).end - 1] = of(to).begin;
  }
  return ways;
}

}  // namespace ra2d::test
