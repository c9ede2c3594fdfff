// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/map_npy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/numbers_in_bytes.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/system/input_file.hpp"

namespace ra2d {
namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";
constexpr std::size_t before_header = 12;      // bytes, at the most: magic, version, length
constexpr std::size_t longest_header = 10000;  // bytes, as NumPy itself has it
constexpr std::size_t at_once = 1 << 16;       // numbers

[[noreturn]] void refuse_npy(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: .npy: {}", file.string(), why));
}

/// Entries of the header.
struct NpyHeader {
  std::string type;
  std::optional<bool> fortran;
  std::optional<std::vector<std::uint64_t>> shape;
};

/// Reads the header's dictionary, in which NumPy writes texts, True or False, and a tuple of whole
/// numbers.
class NpyDictionary {
 public:
  NpyDictionary(const std::filesystem::path& file, std::string_view text)
      : file_{file}, left_{text} {}

  NpyHeader read() {
    NpyHeader header;
    need('{');
    while (!take('}')) {
      const std::string key = quoted_text();
      need(':');
      if (key == "descr" && header.type.empty())
        header.type = type();
      else if (key == "fortran_order" && !header.fortran)
        header.fortran = truth();
      else if (key == "shape" && !header.shape)
        header.shape = tuple();
      else
        refuse_npy(file_, fmt::format("{} in the header, expected descr, fortran_order and shape, "
                                      "each once",
                                      ra2d::quoted(key)));
      if (!take(',')) {
        need('}');
        break;
      }
    }
    skip_blanks();
    if (!left_.empty()) unexpected();
    if (header.type.empty() || !header.fortran || !header.shape)
      refuse_npy(file_, "the header lacks descr, fortran_order or shape");
    return header;
  }

 private:
  void skip_blanks() {
    left_.remove_prefix(std::min(left_.find_first_not_of(" \t\r\n"), left_.size()));
  }
  bool take(char c) {
    skip_blanks();
    if (!left_.starts_with(c)) return false;
    left_.remove_prefix(1);
    return true;
  }
  void need(char c) {
    if (!take(c)) unexpected();
  }
  [[noreturn]] void unexpected() const {
    refuse_npy(file_, fmt::format("the header is not one that NumPy writes, from {} on",
                                  ra2d::quoted(left_.substr(0, 30))));
  }
  std::string quoted_text() {
    skip_blanks();
    if (left_.empty() || (left_[0] != '\'' && left_[0] != '"')) unexpected();
    const std::size_t end = left_.find(left_[0], 1);
    if (end == left_.npos) unexpected();
    std::string text(left_.substr(1, end - 1));
    left_.remove_prefix(end + 1);
    return text;
  }
  std::string type() {
    skip_blanks();
    if (left_.starts_with('['))
      refuse_npy(file_, "the elements are records, expected float64: save one field of them");
    std::string text = quoted_text();
    if (text.empty()) unexpected();
    return text;
  }
  bool truth() {
    skip_blanks();
    for (const bool value : {true, false}) {
      const std::string_view word = value ? "True" : "False";
      if (!left_.starts_with(word)) continue;
      left_.remove_prefix(word.size());
      return value;
    }
    unexpected();
  }
  std::vector<std::uint64_t> tuple() {
    std::vector<std::uint64_t> values;
    need('(');
    while (!take(')')) {
      skip_blanks();
      std::uint64_t value = 0;
      const auto [end, error] = std::from_chars(left_.data(), left_.data() + left_.size(), value);
      if (error != std::errc{}) unexpected();
      left_.remove_prefix(static_cast<std::size_t>(end - left_.data()));
      values.push_back(value);
      if (!take(',')) {
        need(')');
        break;
      }
    }
    return values;
  }

  const std::filesystem::path& file_;
  std::string_view left_;
};

struct NpyType {
  const char* name;
  std::size_t bytes;
  double (*value)(const char* bytes);
};
constexpr NpyType npy_types[] = {{"<f8", 8, &little_endian_value<double>},
                                 {">f8", 8, &big_endian_value<double>},
                                 {"<f4", 4, &little_endian_value<float>},
                                 {">f4", 4, &big_endian_value<float>}};

const NpyType& npy_type(const std::filesystem::path& file, const std::string& name) {
  for (const NpyType& type : npy_types)
    if (name == type.name) return type;
  refuse_npy(file, fmt::format("elements of type {}, expected float32 or float64: "
                               "numpy.save(file, z.astype(float)) writes them",
                               ra2d::quoted(name)));
}

/// The header's text, and where the elements begin.
std::pair<std::string, std::uint64_t> header_of(const std::filesystem::path& file,
                                                const InputFile& input) {
  const std::string begin = input.beginning(before_header);
  const auto byte = [&](std::size_t i) {
    return static_cast<std::uint64_t>(static_cast<unsigned char>(begin[i]));
  };
  if (begin.size() < before_header) refuse_npy(file, "cut off in its header");
  const std::uint64_t version = byte(6);
  if (version < 1 || version > 3 || byte(7) != 0)
    refuse_npy(file, fmt::format("version {}.{}, expected 1.0 to 3.0", version, byte(7)));
  const std::size_t start = version == 1 ? 10 : 12;
  std::uint64_t length = byte(8) | byte(9) << 8;
  if (version > 1) length |= byte(10) << 16 | byte(11) << 24;
  if (length > longest_header)
    refuse_npy(file,
               fmt::format("a header of {} bytes, expected at most {}", length, longest_header));
  std::string text(length, '\0');
  if (input.read(start, text.data(), text.size()) != text.size())
    refuse_npy(file, "cut off in its header");
  return {std::move(text), start + length};
}

}  // namespace

bool begins_as_npy(std::string_view bytes) { return bytes.starts_with(npy_magic); }

BareMap read_map_npy(const std::filesystem::path& file) {
  const InputFile input(file, "the map");
  const auto [text, begin] = header_of(file, input);
  const NpyHeader header = NpyDictionary(file, text).read();
  const NpyType& type = npy_type(file, header.type);
  const auto& shape = *header.shape;
  if (shape.size() != 2)
    refuse_npy(file, fmt::format("an array of {} dimension{}, expected two: (rows, x){}",
                                 shape.size(), shape.size() == 1 ? "" : "s",
                                 shape.size() == 1 ? "; one row is a profile" : ""));
  BareMap map;
  map.ny = shape[0];
  map.nx = shape[1];
  require_map_size(file.string(), static_cast<double>(shape[1]), static_cast<double>(shape[0]));
  const std::uint64_t all = shape[0] * shape[1], needed = begin + all * type.bytes;
  if (input.size() != needed)
    refuse_npy(file, fmt::format("{} by {} elements need {} bytes, and the file has {}: {}",
                                 shape[0], shape[1], needed, input.size(),
                                 input.size() < needed ? "it was cut off, or the header is wrong"
                                                       : "the header is wrong"));
  map.numbers.resize(all);
  std::vector<char> bytes(at_once * type.bytes);
  for (std::uint64_t first = 0; first < all; first += at_once) {
    const std::uint64_t count = std::min<std::uint64_t>(at_once, all - first);
    if (input.read(begin + first * type.bytes, bytes.data(), count * type.bytes) !=
        count * type.bytes)
      throw input.unreadable("the reading stopped halfway");
    for (std::uint64_t k = 0; k < count; ++k) {
      const double value = type.value(&bytes[k * type.bytes]);
      const std::uint64_t at = first + k;  // in the file's order
      const std::uint64_t row = *header.fortran ? at % map.ny : at / map.nx;
      const std::uint64_t point = *header.fortran ? at / map.ny : at % map.nx;
      if (std::isinf(value))
        refuse_npy(file, fmt::format("row {}, point {}: a height that is not a finite number",
                                     row + 1, point + 1));
      map.numbers[row * map.nx + point] = value;
    }
  }
  return map;
}

std::string npy_header(std::size_t rows, std::size_t columns) {
  constexpr std::size_t aligned = 64;
  std::string text =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", rows, columns);
  std::string begin = std::string(npy_magic) + '\x01' + '\0';
  while ((begin.size() + 2 + text.size() + 1) % aligned != 0) text += ' ';
  text += '\n';
  begin += static_cast<char>(text.size() & 0xff);
  begin += static_cast<char>(text.size() >> 8);
  return begin + text;
}

}  // namespace ra2d
