// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/interpreter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

namespace ra2d::test {

using Kind = Instruction::Kind;

void ModelCache::access(std::uint64_t sector_number) {
  std::array<std::uint64_t, ways>& set = sets_[sector_number % sets_.size()];
  const auto found = std::find(set.begin(), set.end(), sector_number);
  if (found == set.end()) ++misses_;
  const auto last = found == set.end() ? set.end() - 1 : found;
  std::rotate(set.begin(), last, last + 1);
  set.front() = sector_number;
}

PtxWarp::PtxWarp(const Program& program, Order order)
    : program_{program},
      order_{order},
      registers_(program.registers()),
      hints_(program.instructions().size()),
      counts_(program.instructions().size()) {
  constexpr std::size_t alignment = 16;
  local_.resize(warp_width * program.local_bytes() + alignment);
  const auto address = reinterpret_cast<std::uint64_t>(local_.data());
  local_begin_ = (address + alignment - 1) / alignment * alignment;
  if (program.local_begin() >= 0)
    for (std::uint64_t lane = 0; lane < warp_width; ++lane)
      registers_[static_cast<std::size_t>(program.local_begin())][lane] =
          local_begin_ + lane * program.local_bytes();
}

void PtxWarp::allow(std::string name, const void* begin, std::size_t bytes, bool writable) {
  memory_.allow(std::move(name), begin, bytes, writable);
}

void PtxWarp::fault(const Instruction& instruction, const std::string& problem) const {
  throw WarpFault(problem + " at " + program_.place(instruction));
}

bool PtxWarp::is_meeting(std::size_t index) const {
  if (index == ignored_) return false;
  const Kind kind = program_.instructions()[index].kind;
  return kind == Kind::sync || kind == Kind::block_sync || kind == Kind::exchange ||
         kind == Kind::ballot;
}

void PtxWarp::run(const std::vector<std::uint64_t>& parameters) {
  if (parameters.size() != program_.parameters().size())
    throw WarpFault(fmt::format("The kernel has {} parameters and was given {}",
                                program_.parameters().size(), parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    registers_[static_cast<std::size_t>(program_.parameters()[k])].fill(parameters[k]);
  if (program_.clock() >= 0) registers_[static_cast<std::size_t>(program_.clock())].fill(0);
  at_.fill(0);
  alive_ = all;
  memory_.sync();
  if (order_ == Order::in_step)
    run_in_step();
  else
    run_by_turns(order_ == Order::shuffled);
}

/// The lanes that are furthest behind go on, until they come to others.
void PtxWarp::run_in_step() {
  while (alive_ != 0) {
    std::size_t first = static_cast<std::size_t>(-1), next = first;
    std::uint32_t lanes = 0;
    for (std::uint32_t rest = alive_; rest != 0; rest &= rest - 1) {
      const int lane = std::countr_zero(rest);
      const std::size_t at = at_[static_cast<std::size_t>(lane)];
      if (is_meeting(at)) continue;  // waits
      if (at < first) {
        next = first;
        first = at;
        lanes = 0;
      } else if (at > first) {
        next = std::min(next, at);
      }
      if (at == first) lanes |= 1u << lane;
    }
    if (lanes == 0)
      meet();
    else
      run_group(lanes, next);
  }
}

/// Each lane by itself to where they meet.
void PtxWarp::run_by_turns(bool shuffle) {
  std::array<int, warp_width> turn;
  std::iota(turn.begin(), turn.end(), 0);
  if (order_ == Order::descending) std::reverse(turn.begin(), turn.end());
  std::mt19937 random{1};
  while (alive_ != 0) {
    if (shuffle) std::shuffle(turn.begin(), turn.end(), random);
    for (const int lane : turn)
      while ((alive_ >> lane & 1) != 0 && !is_meeting(at_[static_cast<std::size_t>(lane)]))
        run_group(1u << lane, static_cast<std::size_t>(-1));
    if (alive_ != 0) meet();
  }
}

/// Instructions of lanes that are at one place and not at a meeting, until they part, meet, end,
/// or come to `limit`, where others are.
void PtxWarp::run_group(std::uint32_t lanes, std::size_t limit) {
  const std::vector<Instruction>& instructions = program_.instructions();
  std::size_t at = at_[static_cast<std::size_t>(std::countr_zero(lanes))];
  const auto leave = [&] {
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1)
      at_[static_cast<std::size_t>(std::countr_zero(rest))] = at;
  };
  while (true) {
    const Instruction& i = instructions[at];
    switch (i.kind) {
      case Kind::value:
        issue(at);
        i.compute(registers_.data(), i, guarded(i, lanes));
        ++at;
        break;
      case Kind::load:
      case Kind::store:
      case Kind::compare_and_swap:
        issue(at);
        access(i, at, guarded(i, lanes));
        ++at;
        break;
      case Kind::branch: {
        issue(at);
        const std::uint32_t taken = guarded(i, lanes);
        const auto target = static_cast<std::size_t>(i.target);
        if (taken != 0 && taken != lanes) {
          for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
            const int lane = std::countr_zero(rest);
            at_[static_cast<std::size_t>(lane)] = (taken >> lane & 1) != 0 ? target : at + 1;
          }
          return;
        }
        at = taken != 0 ? target : at + 1;
        break;
      }
      case Kind::end:
        issue(at);
        alive_ &= ~lanes;
        return;
      case Kind::sync:
      case Kind::block_sync:
      case Kind::exchange:
      case Kind::ballot:
        if (at == ignored_) {
          ++at;
          break;
        }
        leave();
        if (lanes != all) return;
        meet();
        ++at;
        break;
    }
    if (at >= limit) return leave();
  }
}

/// A sync or an exchange of all lanes. The warp is alone in its block, so a sync of the block waits
/// for no other warp. It orders no memory here: else it would hide that a sync of the lanes is
/// missing.
void PtxWarp::meet() {
  const std::size_t at = at_[0];
  const Instruction& i = program_.instructions()[at];
  for (int lane = 0; lane < warp_width; ++lane) {
    const std::size_t other = at_[static_cast<std::size_t>(lane)];
    if ((alive_ >> lane & 1) == 0)
      throw WarpFault(fmt::format("lane {} has ended, and others are to meet", lane));
    if (other != at)
      throw WarpFault(fmt::format("lane 0 is to meet the others at {}, lane {} at {}",
                                  program_.place(i), lane,
                                  program_.place(program_.instructions()[other])));
    if (i.kind == Kind::block_sync) continue;
    if (i.guard >= 0 ||
        static_cast<std::uint32_t>(
            registers_[static_cast<std::size_t>(i.operand[3])][static_cast<std::size_t>(lane)]) !=
            all)
      fault(i, "a meeting of some lanes alone");
  }
  issue(at);
  if (i.kind == Kind::exchange)
    exchange(i);
  else if (i.kind == Kind::ballot)
    ballot(i);
  else if (i.kind == Kind::sync)
    memory_.sync();
  else if (i.kind == Kind::block_sync)
    stretches_.push_back(std::exchange(in_stretch_, 0));
  for (std::size_t& of_lane : at_) ++of_lane;
  if (program_.clock() >= 0)
    for (std::uint64_t& of_lane : registers_[static_cast<std::size_t>(program_.clock())]) ++of_lane;
}

void PtxWarp::exchange(const Instruction& i) {
  const LaneBits from = registers_[static_cast<std::size_t>(i.operand[0])];
  const LaneBits& by = registers_[static_cast<std::size_t>(i.operand[1])];
  const LaneBits& bound = registers_[static_cast<std::size_t>(i.operand[2])];
  LaneBits& to = registers_[static_cast<std::size_t>(i.result[0])];
  if (i.exchange == Instruction::Exchange::butterfly && static_cast<std::uint32_t>(by[0]) == 1)
    ++neighbour_exchanges_;
  LaneBits given;
  for (std::uint32_t lane = 0; lane < warp_width; ++lane) {
    if (static_cast<std::uint32_t>(bound[lane]) != warp_width - 1)
      fault(i, "an exchange within a part of the warp");
    const auto distance = static_cast<std::uint32_t>(by[lane]);
    std::uint32_t source = 0;
    switch (i.exchange) {
      case Instruction::Exchange::butterfly:
        source = lane ^ distance;
        break;
      case Instruction::Exchange::down:
        source = lane + distance;
        break;
      default:
        source = distance % warp_width;
        break;
    }
    given[lane] = from[source < warp_width ? source : lane];
  }
  to = given;
}

void PtxWarp::ballot(const Instruction& i) {
  std::uint64_t word = 0;
  for (std::size_t lane = 0; lane < warp_width; ++lane)
    word |= (registers_[static_cast<std::size_t>(i.operand[0])][lane] & 1) << lane;
  registers_[static_cast<std::size_t>(i.result[0])].fill(word);
}

std::uint32_t PtxWarp::guarded(const Instruction& i, std::uint32_t mask) const {
  if (i.guard < 0) return mask;
  const LaneBits& guard = registers_[static_cast<std::size_t>(i.guard)];
  std::uint32_t kept = 0;
  for (std::uint32_t rest = mask; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    if (((guard[static_cast<std::size_t>(lane)] & 1) != 0) != i.guard_negated) kept |= 1u << lane;
  }
  return kept;
}

bool PtxWarp::is_local(std::uint64_t address) const {
  return address - local_begin_ < warp_width * program_.local_bytes();
}

char* PtxWarp::memory(const Instruction& i, std::size_t index, std::uint64_t address, int lane,
                      bool writes) {
  const auto bytes = static_cast<std::uint64_t>(i.bytes);
  if (address % bytes != 0) fault(i, fmt::format("lane {} is not aligned", lane));
  const std::uint64_t of_lane =
      local_begin_ + static_cast<std::uint64_t>(lane) * program_.local_bytes();
  if (address >= of_lane && address + bytes <= of_lane + program_.local_bytes())
    return reinterpret_cast<char*>(address);
  const auto check = [&] {
    // an atomic access races with none
    if (!checks_races_ || i.kind == Kind::compare_and_swap)
      return memory_.holds(address, i.bytes, writes, hints_[index]);
    const bool held = memory_.touch(address, i.bytes, writes, lane, static_cast<int>(index),
                                    hints_[index], conflicts_);
    // in the order of the program: some orders of the lanes show a pair both ways
    for (const auto& conflict : conflicts_)
      races_.insert(std::minmax(conflict.earlier, conflict.later));
    conflicts_.clear();
    return held;
  };
  if (i.local || !check())
    fault(i, fmt::format("lane {} {} outside its arrays", lane, writes ? "writes" : "reads"));
  return reinterpret_cast<char*>(address);
}

void PtxWarp::access(const Instruction& i, std::size_t index, std::uint32_t mask) {
  const auto bytes = static_cast<std::size_t>(i.bytes);
  const auto reg = [&](int number, int lane) -> std::uint64_t& {
    return registers_[static_cast<std::size_t>(number)][static_cast<std::size_t>(lane)];
  };
  std::uint64_t sector_before = 0;
  for (; mask != 0; mask &= mask - 1) {
    const int lane = std::countr_zero(mask);
    const std::uint64_t address = reg(i.operand[0], lane) + static_cast<std::uint64_t>(i.offset);
    if (!caches_.empty() && !is_local(address) && address / ModelCache::sector != sector_before) {
      sector_before = address / ModelCache::sector;
      for (ModelCache* cache : caches_) cache->access(sector_before);
    }
    for (int k = 0; k < i.values; ++k) {
      const std::uint64_t place = address + static_cast<std::uint64_t>(k) * bytes;
      char* const at = memory(i, index, place, lane, i.kind != Kind::load);
      const auto which = static_cast<std::size_t>(k);
      if (i.kind == Kind::store) {
        std::memcpy(at, &reg(i.operand[which + 1], lane), bytes);
        continue;
      }
      std::uint64_t value = 0;
      std::memcpy(&value, at, bytes);
      if (i.kind == Kind::compare_and_swap &&
          static_cast<std::uint32_t>(reg(i.operand[1], lane)) == value)
        std::memcpy(at, &reg(i.operand[2], lane), bytes);
      if (i.is_signed) {
        const int empty = 64 - 8 * i.bytes;
        value = static_cast<std::uint64_t>(static_cast<std::int64_t>(value << empty) >> empty);
      }
      reg(i.result[which], lane) = value;
    }
  }
}

std::vector<std::string> PtxWarp::races() const {
  std::vector<std::string> text;
  for (const auto& [earlier, later] : races_) {
    const auto place = [&](int index) {
      return program_.place(program_.instructions()[static_cast<std::size_t>(index)]);
    };
    text.push_back(place(earlier) + " and " + place(later));
  }
  return text;
}

}  // namespace ra2d::test
