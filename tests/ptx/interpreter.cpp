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

PtxWarp::PtxWarp(const Program& program, Order order, int width)
    : program_{program},
      order_{order},
      width_{width},
      registers_(program.registers()),
      joins_(ways_join_at(program.instructions())),
      hints_(program.instructions().size()),
      counts_(program.instructions().size()),
      lanes_(program.instructions().size()) {
  constexpr std::size_t alignment = 16;
  local_.resize(warp_width * program.local_bytes() + alignment);
  const auto address = reinterpret_cast<std::uint64_t>(local_.data());
  local_begin_ = (address + alignment - 1) / alignment * alignment;
  if (program.local_begin() >= 0)
    for (std::uint64_t lane = 0; lane < warp_width; ++lane)
      registers_[static_cast<std::size_t>(program.local_begin())][lane] =
          local_begin_ + lane * program.local_bytes();
  const std::uint32_t first = 0xFFFFFFFFu >> (warp_width - width);
  for (int lane = 0; lane < warp_width; lane += width) teams_.push_back({first << lane, {}});
  for (std::size_t lane = 0; lane < warp_width; ++lane) {
    const std::size_t of_team = lane % static_cast<std::size_t>(width);
    if (program.lane() >= 0) registers_[static_cast<std::size_t>(program.lane())][lane] = of_team;
    if (program.team() >= 0)
      registers_[static_cast<std::size_t>(program.team())][lane] =
          lane / static_cast<std::size_t>(width);
  }
}

void PtxWarp::allow(std::string name, const void* begin, std::size_t bytes, bool writable,
                    int team) {
  teams_[static_cast<std::size_t>(team)].memory.allow(std::move(name), begin, bytes, writable);
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

void PtxWarp::run(const std::vector<std::vector<std::uint64_t>>& parameters) {
  alive_ = 0;
  for (std::size_t team = 0; team < parameters.size(); ++team) {
    if (parameters[team].size() != program_.parameters().size())
      throw WarpFault(fmt::format("The kernel has {} parameters and was given {}",
                                  program_.parameters().size(), parameters[team].size()));
    for (std::size_t k = 0; k < parameters[team].size(); ++k) {
      LaneBits& of_lane = registers_[static_cast<std::size_t>(program_.parameters()[k])];
      for (std::uint32_t rest = teams_[team].lanes; rest != 0; rest &= rest - 1)
        of_lane[static_cast<std::size_t>(std::countr_zero(rest))] = parameters[team][k];
    }
    alive_ |= teams_[team].lanes;
    teams_[team].memory.sync();
  }
  if (program_.clock() >= 0) registers_[static_cast<std::size_t>(program_.clock())].fill(0);
  at_.fill(0);
  if (order_ == Order::in_step)
    run_in_step();
  else
    run_by_turns(order_ == Order::shuffled);
}

bool PtxWarp::are_teams(std::uint32_t lanes) const {
  for (const Team& team : teams_)
    if ((lanes & team.lanes) != 0 && (team.lanes & ~lanes) != 0) return false;
  return true;
}

/// Where lanes part, some go on to where all ways come together, then the others.
void PtxWarp::run_in_step() {
  std::vector<Going> going = {{alive_, 0, nowhere}};
  std::uint32_t waiting = 0;  // for the block
  while (true) {
    if (going.empty()) {
      waiting &= alive_;
      if (waiting == 0) return;
      const std::size_t at = at_[static_cast<std::size_t>(std::countr_zero(waiting))];
      for (const Team& team : teams_)
        if ((alive_ & team.lanes) != 0 && check_meeting(team) != at)
          throw WarpFault("teams of a block meet elsewhere than at " + place(at));
      going.push_back({std::exchange(waiting, 0), at, nowhere});
    }
    Going& latest = going.back();
    latest.lanes &= alive_;
    if (latest.lanes == 0 || latest.at == latest.until) {
      going.pop_back();
      continue;
    }
    const Going before = latest;
    std::uint32_t taken = 0;
    latest.at = run_group(before.lanes, before.at, before.until, taken);
    if (taken != 0) {
      const std::size_t branch = latest.at, join = joins_[branch];
      if (join == before.until)
        going.pop_back();
      else
        latest.at = join;
      const auto target = static_cast<std::size_t>(program_.instructions()[branch].target);
      going.push_back({before.lanes & ~taken, branch + 1, join});
      going.push_back({taken, target, join});
    } else if (latest.at == before.until || (alive_ & before.lanes) == 0) {
      continue;
    } else if (program_.instructions()[latest.at].kind == Kind::block_sync &&
               are_teams(before.lanes)) {
      waiting |= before.lanes;
      leave(before.lanes, latest.at);
      for (Going& lanes : going) lanes.lanes &= ~before.lanes;
    } else {
      // others are to come to this meeting by other ways
      for (const Going& lanes : going) leave(lanes.lanes & alive_, lanes.at);
      run_to_meetings({});
      going.clear();
      for (const Team& team : teams_)
        if ((alive_ & team.lanes) != 0) going.push_back({team.lanes, check_meeting(team), nowhere});
    }
  }
}

/// Each lane by itself to where they meet.
void PtxWarp::run_by_turns(bool shuffle) {
  std::vector<int> turn(warp_width);
  std::iota(turn.begin(), turn.end(), 0);
  if (order_ == Order::descending) std::reverse(turn.begin(), turn.end());
  std::mt19937 random{1};
  while (alive_ != 0) {
    if (shuffle) std::shuffle(turn.begin(), turn.end(), random);
    run_to_meetings(turn);
    // teams that wait for the block wait for all others
    std::uint32_t waiting = 0;
    for (const Team& team : teams_)
      if ((alive_ & team.lanes) != 0) {
        const std::size_t at = check_meeting(team);
        if (program_.instructions()[at].kind == Kind::block_sync) {
          waiting |= team.lanes;
          continue;
        }
        meet(team.lanes, at);
        leave(team.lanes, at + 1);
      }
    if (waiting != 0 && waiting == alive_) {
      const std::size_t at = at_[static_cast<std::size_t>(std::countr_zero(waiting))];
      meet(waiting, at);
      leave(waiting, at + 1);
    }
  }
}
/// Each lane by itself to its next meeting or its end. In the order of `turn`, or their own.
void PtxWarp::run_to_meetings(const std::vector<int>& turn) {
  for (int k = 0; k < warp_width; ++k) {
    const int lane = turn.empty() ? k : turn[static_cast<std::size_t>(k)];
    std::size_t& at = at_[static_cast<std::size_t>(lane)];
    while ((alive_ >> lane & 1) != 0 && !is_meeting(at)) {
      std::uint32_t taken = 0;
      at = run_group(1u << lane, at, nowhere, taken);
    }
  }
}

/// Instructions of lanes that are at one place, from `at` until they part, end, come to `until`, or
/// to a meeting that others are to come to. Returns where that is. Where they part, it is at a
/// branch, and `taken` are those that take it.
std::size_t PtxWarp::run_group(std::uint32_t lanes, std::size_t at, std::size_t until,
                               std::uint32_t& taken) {
  const std::vector<Instruction>& instructions = program_.instructions();
  do {
    const Instruction& i = instructions[at];
    switch (i.kind) {
      case Kind::value:
        issue(at, lanes);
        i.compute(registers_.data(), i, guarded(i, lanes));
        ++at;
        break;
      case Kind::load:
      case Kind::store:
      case Kind::compare_and_swap:
        issue(at, lanes);
        access(i, at, guarded(i, lanes));
        ++at;
        break;
      case Kind::branch: {
        issue(at, lanes);
        const std::uint32_t of_lanes = guarded(i, lanes);
        if (of_lanes != 0 && of_lanes != lanes) {
          taken = of_lanes;
          return at;
        }
        at = of_lanes != 0 ? static_cast<std::size_t>(i.target) : at + 1;
        break;
      }
      case Kind::end:
        issue(at, lanes);
        alive_ &= ~lanes;
        return at;
      case Kind::sync:
      case Kind::block_sync:
      case Kind::exchange:
      case Kind::ballot:
        if (at != ignored_) {
          if (!are_teams(lanes) || (i.kind == Kind::block_sync && lanes != alive_)) return at;
          meet(lanes, at);
        }
        ++at;
        break;
    }
  } while (at != until);
  return at;
}

std::string PtxWarp::place(std::size_t index) const {
  return program_.place(program_.instructions()[index]);
}

void PtxWarp::leave(std::uint32_t lanes, std::size_t at) {
  for (; lanes != 0; lanes &= lanes - 1)
    at_[static_cast<std::size_t>(std::countr_zero(lanes))] = at;
}

/// The meeting that all lanes of a team have come to.
std::size_t PtxWarp::check_meeting(const Team& team) const {
  const int first = std::countr_zero(team.lanes);
  const std::size_t at = at_[static_cast<std::size_t>(first)];
  for (std::uint32_t rest = team.lanes; rest != 0; rest &= rest - 1) {
    const int lane = std::countr_zero(rest);
    const std::size_t other = at_[static_cast<std::size_t>(lane)];
    if ((alive_ >> lane & 1) == 0)
      throw WarpFault(fmt::format("lane {} has ended, and others are to meet", lane));
    if (other != at)
      throw WarpFault(fmt::format("lane {} is to meet the others at {}, lane {} at {}", first,
                                  place(at), lane, place(other)));
  }
  return at;
}

/// A sync or an exchange of all lanes of some teams. The warp is alone in its block, so a sync of
/// the block waits for no other warp. It orders no memory here: else it would hide that a sync of
/// the lanes is missing.
void PtxWarp::meet(std::uint32_t lanes, std::size_t at) {
  const Instruction& i = program_.instructions()[at];
  for (Team& team : teams_) {
    if ((lanes & team.lanes) == 0) continue;
    if (i.kind == Kind::sync) team.memory.sync();
    if (i.kind == Kind::block_sync) continue;
    const LaneBits& members = registers_[static_cast<std::size_t>(i.operand[3])];
    for (std::uint32_t rest = team.lanes; rest != 0; rest &= rest - 1)
      if (i.guard >= 0 ||
          static_cast<std::uint32_t>(members[static_cast<std::size_t>(std::countr_zero(rest))]) !=
              team.lanes)
        fault(i, "a meeting of other lanes than a team's");
  }
  issue(at, lanes);
  if (i.kind == Kind::exchange)
    exchange(i, lanes);
  else if (i.kind == Kind::ballot)
    ballot(i, lanes);
  else if (i.kind == Kind::block_sync)
    stretches_.push_back(std::exchange(in_stretch_, 0));
  if (program_.clock() >= 0)
    for (std::uint64_t& clock : registers_[static_cast<std::size_t>(program_.clock())]) ++clock;
}

void PtxWarp::exchange(const Instruction& i, std::uint32_t lanes) {
  const LaneBits from = registers_[static_cast<std::size_t>(i.operand[0])];
  const LaneBits& by = registers_[static_cast<std::size_t>(i.operand[1])];
  const LaneBits& bound = registers_[static_cast<std::size_t>(i.operand[2])];
  LaneBits& to = registers_[static_cast<std::size_t>(i.result[0])];
  if (i.exchange == Instruction::Exchange::butterfly &&
      static_cast<std::uint32_t>(by[static_cast<std::size_t>(std::countr_zero(lanes))]) == 1)
    ++neighbour_exchanges_;
  const auto width = static_cast<std::uint32_t>(width_);
  LaneBits given = to;
  for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(rest));
    // the last lane, and above it the bits that a lane and its source share
    if (static_cast<std::uint32_t>(bound[lane]) != ((warp_width - 1) | (warp_width - width) << 8))
      fault(i, "an exchange within other parts of the warp than teams");
    const auto distance = static_cast<std::uint32_t>(by[lane]);
    const std::uint32_t first = lane / width * width;
    std::uint32_t source = 0;
    switch (i.exchange) {
      case Instruction::Exchange::butterfly:
        source = lane ^ distance;
        break;
      case Instruction::Exchange::down:
        source = lane + distance;
        break;
      default:
        source = first + distance % width;
        break;
    }
    given[lane] = from[source < first + width ? source : lane];
  }
  to = given;
}

void PtxWarp::ballot(const Instruction& i, std::uint32_t lanes) {
  const LaneBits says = registers_[static_cast<std::size_t>(i.operand[0])];
  for (const Team& team : teams_) {
    if ((lanes & team.lanes) == 0) continue;
    std::uint64_t word = 0;
    for (std::uint32_t rest = team.lanes; rest != 0; rest &= rest - 1)
      word |= (says[static_cast<std::size_t>(std::countr_zero(rest))] & 1)
              << std::countr_zero(rest);
    for (std::uint32_t rest = team.lanes; rest != 0; rest &= rest - 1)
      registers_[static_cast<std::size_t>(i.result[0])]
                [static_cast<std::size_t>(std::countr_zero(rest))] = word;
  }
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
  WatchedMemory& of_team = teams_[static_cast<std::size_t>(lane / width_)].memory;
  const auto check = [&] {
    // an atomic access races with none
    if (!checks_races_ || i.kind == Kind::compare_and_swap)
      return of_team.holds(address, i.bytes, writes, hints_[index]);
    const bool held = of_team.touch(address, i.bytes, writes, lane, static_cast<int>(index),
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
