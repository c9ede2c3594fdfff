// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tests/reductions.hpp"

/// PTX, NVIDIA's assembler for GPUs, as nvcc makes it of a march in which all is inlined: one
/// kernel without calls. "PTX ISA", version 9.0, says what each instruction does.
namespace ra2d::test {

/// Text that cannot be read, or an instruction that is not known here.
struct PtxError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A register of all lanes. Values narrower than 64 bits stand in the lowest bits.
using LaneBits = std::array<std::uint64_t, warp_width>;

struct Instruction;
/// Computes an instruction's results from its operands in the lanes of `mask`.
using Compute = void (*)(LaneBits* registers, const Instruction& instruction, std::uint32_t mask);

struct Instruction {
  enum class Kind {
    value,
    load,
    store,
    compare_and_swap,
    branch,
    end,
    sync,
    block_sync,
    exchange,
    ballot
  };
  enum class Exchange { none, butterfly, down, index };

  Kind kind = Kind::value;
  Compute compute = nullptr;     // value
  std::array<int, 5> operand{};  // registers; of a load and a store the first is the address
  std::array<int, 4> result{};   // registers
  int guard = -1;                // register of the predicate; -1: always
  bool guard_negated = false;
  int target = 0;           // branch: index of an instruction
  std::int64_t offset = 0;  // bytes, added to an address
  int bytes = 0;            // of a value in memory
  int values = 1;           // side by side in memory
  bool is_signed = false;   // a load
  bool local = false;       // an access to local memory
  Exchange exchange = Exchange::none;
  std::string opcode;
  int line = 0;         // of the PTX, from 1
  int source_file = 0;  // 0: not known
  int source_line = 0;
};

class Program {
 public:
  /// Throws PtxError, which names the line.
  explicit Program(const std::string& text);
  static Program read(const std::string& file);

  const std::vector<Instruction>& instructions() const { return instructions_; }
  /// Registers with the values that they begin with: constants have theirs.
  const std::vector<LaneBits>& registers() const { return registers_; }
  /// The registers of the kernel's parameters.
  const std::vector<int>& parameters() const { return parameters_; }
  /// The register that holds where a lane's local memory begins; -1: none is used.
  int local_begin() const { return local_begin_; }
  /// The register of the clock; -1: it is not read.
  int clock() const { return clock_; }
  /// The registers of a lane's place in its team, and of the team's in the warp; -1: not read.
  int lane() const { return lane_; }
  int team() const { return team_; }
  std::size_t local_bytes() const { return local_bytes_; }
  /// "line 12 (fixed_march.hpp:34): bar.warp.sync -1;"
  std::string place(const Instruction& instruction) const;
  /// The file of the source that an instruction was made from; empty: not known.
  const std::string& source_file(const Instruction& instruction) const;
  /// Indices of all syncs.
  std::vector<std::size_t> syncs() const;

 private:
  class Parser;

  std::vector<std::string> lines_;
  std::vector<Instruction> instructions_;
  std::vector<LaneBits> registers_;
  std::vector<int> parameters_;
  std::map<int, std::string> files_;
  int local_begin_ = -1, clock_ = -1, lane_ = -1, team_ = -1;
  std::size_t local_bytes_ = 0;
};

/// How an instruction computes its results, by its name in full; null: it is not known.
Compute find_compute(std::string_view opcode);

}  // namespace ra2d::test
