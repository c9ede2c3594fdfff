// SPDX-License-Identifier: BSD-3-Clause
#include "tests/ptx/program.hpp"

#include <fmt/format.h>

#include <cctype>
#include <fstream>
#include <sstream>
#include <unordered_map>

namespace ra2d::test {
namespace {

std::string trimmed(std::string_view text) {
  constexpr const char* blank = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(blank);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(blank) + 1 - begin));
}

/// The parts between separators that stand outside brackets.
std::vector<std::string> parts_of(std::string_view text, char separator) {
  std::vector<std::string> parts;
  std::string part;
  int depth = 0;
  for (const char c : text) {
    if (c == '{' || c == '[' || c == '(') ++depth;
    if (c == '}' || c == ']' || c == ')') --depth;
    if (c == separator && depth == 0) {
      parts.push_back(trimmed(part));
      part.clear();
    } else {
      part += c;
    }
  }
  if (!trimmed(part).empty()) parts.push_back(trimmed(part));
  return parts;
}

std::string inside(const std::string& bracketed) {
  return trimmed(std::string_view(bracketed).substr(1, bracketed.size() - 2));
}

bool begins(const std::string& text, std::string_view with) { return text.rfind(with, 0) == 0; }

LaneBits in_all_lanes(std::uint64_t value) {
  LaneBits bits;
  bits.fill(value);
  return bits;
}

}  // namespace

/// Reads a program line by line.
class Program::Parser {
 public:
  Parser(Program& program, const std::string& text) : program_{program} {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      program_.lines_.push_back(line);
      ++number_;
      line = trimmed(std::string_view(line).substr(0, line.find("//")));
      if (begins(line, ".section")) break;  // of debuggers
      read_line(line);
    }
    if (program_.instructions_.empty()) throw PtxError("PTX: there is no kernel \"march\" in it");
    for (const auto& [index, label] : branches_) {
      const auto found = labels_.find(label);
      if (found == labels_.end()) fault("branches to " + label + ", which is nowhere");
      program_.instructions_[index].target = found->second;
    }
    for (auto& line : program_.lines_) line = trimmed(line);
  }

 private:
  [[noreturn]] void fault(const std::string& problem) const {
    throw PtxError(fmt::format("PTX line {}: {}: {}", begun_, problem,
                               trimmed(program_.lines_[static_cast<std::size_t>(begun_) - 1])));
  }

  void read_line(const std::string& line) {
    if (pending_.empty()) begun_ = number_;
    if (begins(line, ".loc ") || begins(line, ".loc\t")) return read_location(line);
    if (begins(line, ".file")) return read_file(line);
    for (const char* word : {".version", ".target", ".address_size", ".maxntid", ".minnctapersm"})
      if (begins(line, word)) return;
    pending_ += (pending_.empty() ? "" : " ") + line;
    while (!pending_.empty() && take_statement()) pending_ = trimmed(pending_);
  }

  /// Takes a statement from what was read and not yet understood, once it is complete.
  bool take_statement() {
    if (pending_[0] == '{' || pending_[0] == '}') {
      pending_.erase(0, 1);
      return true;
    }
    const bool heading = pending_.find(".entry ") != std::string::npos ||
                         pending_.find(".func ") != std::string::npos;
    const std::size_t end = pending_.find_first_of(heading ? ")" : ";:");
    if (end == std::string::npos) return false;
    const bool label = pending_[end] == ':';
    const std::string statement = pending_.substr(0, heading ? end + 1 : end);
    pending_.erase(0, end + 1);
    if (heading)
      read_heading(statement);
    else if (label && in_kernel_)
      labels_[trimmed(statement)] = static_cast<int>(program_.instructions_.size());
    else if (!label && !trimmed(statement).empty())
      read_statement(trimmed(statement));
    begun_ = number_;
    return true;
  }

  void read_location(const std::string& line) {
    std::istringstream words(line.substr(4));
    words >> source_file_ >> source_line_;
  }
  void read_file(const std::string& line) {
    const std::size_t quote = line.find('"');
    if (quote == std::string::npos) return;
    program_.files_[std::stoi(line.substr(5))] =
        line.substr(quote + 1, line.find('"', quote + 1) - quote - 1);
  }

  /// The kernel is named "march". Kokkos has others, which no march calls.
  void read_heading(const std::string& heading) {
    const std::size_t open = heading.rfind('(');
    const std::string before = trimmed(heading.substr(0, open));
    in_kernel_ = before.substr(before.find_last_of(" \t") + 1) == "march";
    if (!in_kernel_) return;
    const std::string parameters = heading.substr(open + 1, heading.size() - open - 2);
    for (const std::string& parameter : parts_of(parameters, ','))
      program_.parameters_.push_back(named(parameter.substr(parameter.find_last_of(" \t") + 1)));
  }

  void read_statement(std::string text) {
    if (!in_kernel_) return;
    if (begins(text, ".reg") || begins(text, ".pragma")) return;
    if (begins(text, ".local")) return read_local(text);
    if (text[0] == '.') fault("this declaration is not known here");
    Instruction i;
    i.line = begun_;
    i.source_file = source_file_;
    i.source_line = source_line_;
    if (text[0] == '@') {
      const std::size_t end = text.find_first_of(" \t");
      i.guard_negated = text[1] == '!';
      i.guard = named(text.substr(i.guard_negated ? 2 : 1, end - (i.guard_negated ? 2 : 1)));
      text = trimmed(text.substr(end));
    }
    const std::size_t end = text.find_first_of(" \t");
    i.opcode = text.substr(0, end);
    const auto operands =
        end == std::string::npos ? std::vector<std::string>() : parts_of(text.substr(end), ',');
    read_instruction(i, operands);
    program_.instructions_.push_back(i);
  }

  /// ".local .align 16 .b8 NAME[BYTES]"
  void read_local(const std::string& text) {
    const std::size_t open = text.find('[');
    if (program_.local_begin_ >= 0 || open == std::string::npos)
      fault("one array of local memory was expected");
    program_.local_bytes_ = std::stoul(text.substr(open + 1));
    const std::size_t begin = text.find_last_of(" \t", open) + 1;
    program_.local_begin_ = named(text.substr(begin, open - begin));
  }

  void read_instruction(Instruction& i, const std::vector<std::string>& operands) {
    using Kind = Instruction::Kind;
    const std::vector<std::string> words = parts_of(i.opcode, '.');
    const std::string& word = words[0];
    const auto expect = [&](bool right) {
      if (!right) fault("this form of the instruction is not known here");
    };
    if (word == "ld" || word == "st") {
      read_access(i, words, operands);
    } else if (i.opcode == "bra" || i.opcode == "bra.uni") {
      expect(operands.size() == 1);
      i.kind = Kind::branch;
      branches_.emplace_back(program_.instructions_.size(), operands[0]);
    } else if (i.opcode == "ret" || i.opcode == "exit") {
      i.kind = Kind::end;
      expect(i.guard < 0);
    } else if (i.opcode == "bar.warp.sync") {
      i.kind = Kind::sync;
      expect(operands.size() == 1);
      i.operand[3] = operand(operands[0]);
    } else if (i.opcode == "bar.sync") {
      i.kind = Kind::block_sync;
      expect(operands.size() == 1 && operands[0] == "0" && i.guard < 0);
    } else if (begins(i.opcode, "shfl.sync.")) {
      i.kind = Kind::exchange;
      i.exchange = i.opcode == "shfl.sync.bfly.b32"   ? Instruction::Exchange::butterfly
                   : i.opcode == "shfl.sync.down.b32" ? Instruction::Exchange::down
                   : i.opcode == "shfl.sync.idx.b32"  ? Instruction::Exchange::index
                                                      : Instruction::Exchange::none;
      expect(i.exchange != Instruction::Exchange::none && operands.size() == 5);
      // whether there is such a lane is a second result, which is not given here
      i.result[0] = named(parts_of(operands[0], '|')[0]);
      for (std::size_t k = 0; k < 4; ++k) i.operand[k] = operand(operands[k + 1]);
    } else if (i.opcode == "vote.sync.ballot.b32") {
      i.kind = Kind::ballot;
      expect(operands.size() == 3);
      i.result[0] = named(operands[0]);
      i.operand[0] = operand(operands[1]);
      i.operand[3] = operand(operands[2]);
    } else if (i.opcode == "atom.cas.relaxed.gpu.b32") {
      i.kind = Kind::compare_and_swap;
      expect(operands.size() == 4);
      i.bytes = 4;
      i.result[0] = named(operands[0]);
      read_address(i, operands[1]);
      i.operand[1] = operand(operands[2]);
      i.operand[2] = operand(operands[3]);
    } else {
      read_value(i, operands);
    }
  }

  void read_value(Instruction& i, const std::vector<std::string>& operands) {
    if (operands.size() < 2 || operands.size() > 5) fault("this instruction is not known here");
    const bool unpacks = operands[0][0] == '{', packs = operands[1][0] == '{';
    if ((unpacks || packs) && (i.opcode != "mov.b64" || operands.size() != 2))
      fault("this instruction is not known here");
    i.compute = find_compute(unpacks ? "unpack" : packs ? "pack" : i.opcode);
    if (i.compute == nullptr) fault("this instruction is not known here");
    std::vector<std::string> from(operands.begin() + 1, operands.end());
    if (packs) from = parts_of(inside(operands[1]), ',');
    if (unpacks) {
      const auto to = parts_of(inside(operands[0]), ',');
      if (to.size() != 2) fault("two halves were expected");
      i.result[0] = named(to[0]);
      i.result[1] = named(to[1]);
    } else {
      i.result[0] = named(operands[0]);
    }
    if (packs && from.size() != 2) fault("two halves were expected");
    for (std::size_t k = 0; k < from.size(); ++k) i.operand[k] = operand(from[k]);
  }

  void read_access(Instruction& i, const std::vector<std::string>& words,
                   const std::vector<std::string>& operands) {
    const bool loads = words[0] == "ld";
    bool of_parameter = false;
    if (operands.size() != 2) fault("an address and a value were expected");
    for (std::size_t k = 1; k + 1 < words.size(); ++k) {
      if (words[k] == "v2" || words[k] == "v4")
        i.values = words[k] == "v2" ? 2 : 4;
      else if (words[k] == "local")
        i.local = true;
      else if (words[k] == "param" && loads)
        of_parameter = true;
      else if (words[k] != "global" && words[k] != "volatile")
        fault("this kind of access is not known here");
    }
    const std::string& type = words.back();
    i.is_signed = type[0] == 's';
    i.bytes = std::stoi(type.substr(1)) / 8;
    const std::string& address = operands[loads ? 1 : 0];
    if (of_parameter) {  // a parameter has a register of its own
      i.compute = find_compute("mov.u64");
      i.result[0] = named(operands[0]);
      i.operand[0] = named(inside(address));
      return;
    }
    i.kind = loads ? Instruction::Kind::load : Instruction::Kind::store;
    read_address(i, address);
    const std::string& value = operands[loads ? 0 : 1];
    const auto values = i.values > 1 ? parts_of(inside(value), ',') : std::vector{value};
    if (values.size() != static_cast<std::size_t>(i.values)) fault("as many values were expected");
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (loads)
        i.result[k] = named(values[k]);
      else
        i.operand[k + 1] = operand(values[k]);
    }
  }

  /// "[REGISTER]" or "[REGISTER+OFFSET]"
  void read_address(Instruction& i, const std::string& text) {
    if (text[0] != '[') fault("an address was expected");
    const auto parts = parts_of(inside(text), '+');
    i.operand[0] = operand(parts[0]);
    if (parts.size() > 1) i.offset = std::stoll(parts[1]);
  }

  /// A register, or one that holds a constant.
  int operand(const std::string& text) {
    const bool number = std::isdigit(static_cast<unsigned char>(text[0])) || text[0] == '-';
    if (!number) return named(text);
    const auto [found, fresh] = registers_.try_emplace(text, 0);
    if (fresh) {
      const std::string kind = text.substr(0, 2);
      const std::uint64_t value = kind == "0d" || kind == "0f"
                                      ? std::stoull(text.substr(2), nullptr, 16)
                                  : text[0] == '-' ? static_cast<std::uint64_t>(std::stoll(text))
                                                   : std::stoull(text, nullptr, 0);
      found->second = add_register(in_all_lanes(value));
    }
    return found->second;
  }
  int named(const std::string& name) {
    const auto [found, fresh] = registers_.try_emplace(name, 0);
    if (!fresh) return found->second;
    // what is read before it is written shows in the results
    found->second = add_register(in_all_lanes(0xDEADBEEFDEADBEEF));
    if (name == "%tid.x")
      program_.lane_ = found->second;
    else if (name == "%tid.y")
      program_.team_ = found->second;
    else if (name == "%globaltimer")
      program_.clock_ = found->second;
    else if (name.find('.') != std::string::npos)
      fault("this register is not known here");
    return found->second;
  }
  int add_register(const LaneBits& first) {
    program_.registers_.push_back(first);
    return static_cast<int>(program_.registers_.size()) - 1;
  }

  Program& program_;
  std::string pending_;  // read, and not yet a statement
  int number_ = 0;       // of the line
  int begun_ = 1;        // line in which the statement began
  int source_file_ = 0, source_line_ = 0;
  bool in_kernel_ = false;
  std::unordered_map<std::string, int> registers_;
  std::unordered_map<std::string, int> labels_;
  std::vector<std::pair<std::size_t, std::string>> branches_;
};

Program::Program(const std::string& text) { Parser(*this, text); }

Program Program::read(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw PtxError(file + " cannot be read. Make it with tests/ptx/make_ptx.py");
  std::ostringstream text;
  text << in.rdbuf();
  return Program(text.str());
}

const std::string& Program::source_file(const Instruction& instruction) const {
  static const std::string unknown;
  const auto found = files_.find(instruction.source_file);
  return found == files_.end() ? unknown : found->second;
}

std::string Program::place(const Instruction& instruction) const {
  const std::string& path = source_file(instruction);
  const std::string source =
      path.empty()
          ? ""
          : fmt::format(" ({}:{})", path.substr(path.rfind('/') + 1), instruction.source_line);
  return fmt::format("line {}{}: {}", instruction.line, source,
                     lines_[static_cast<std::size_t>(instruction.line) - 1]);
}

std::vector<std::size_t> Program::syncs() const {
  std::vector<std::size_t> found;
  for (std::size_t index = 0; index < instructions_.size(); ++index)
    if (instructions_[index].kind == Instruction::Kind::sync) found.push_back(index);
  return found;
}

}  // namespace ra2d::test
