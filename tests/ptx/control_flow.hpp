// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <vector>

#include "tests/ptx/program.hpp"

namespace ra2d::test {

inline constexpr std::size_t nowhere = static_cast<std::size_t>(-1);

/// For each branch of a program the instruction at which all ways from it come together first (its
/// immediate post-dominator), by indices: there a compiler has lanes that parted wait for one
/// another. `nowhere` if they end apart, and for what is no branch.
std::vector<std::size_t> ways_join_at(const std::vector<Instruction>& program);

}  // namespace ra2d::test
