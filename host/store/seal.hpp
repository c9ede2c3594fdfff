// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/hash.hpp"

/// The seal of a finished HDF5 file stands behind HDF5's own end of the file (docs/results.md): a
/// table with the XXH3-128 of every 4096 bytes, and a line of text with the hash of this table.
/// Programs that read HDF5 ignore the seal; those that write cut it off. HDF5 can crash on a single
/// flipped bit, so it gets no byte that was not compared with the seal.
namespace ra2d {

inline constexpr std::size_t sealed_block = 4096;  // bytes
inline constexpr std::size_t seal_line_size = 64;  // bytes

/// The table and the line: "ra2d seal 2 ", the number of sealed bytes in 18 digits, a space, the
/// table's XXH3-128 in 32 digits, a line end.
std::string seal_of(std::string_view bytes);

/// Appends its seal to a file that is open for reading and writing. Returns 0, or an errno.
int append_seal(int descriptor);

/// Reads every byte of an open file. False where it has no seal, where a byte differs, or where it
/// cannot be read.
bool has_fitting_seal(int descriptor);

/// Why a file cannot be read, without its name: "No such file or directory", "it is no regular
/// file".
struct Unreadable : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A file that ra2d did not seal, or that has changed since: "it is damaged: ...".
struct Unsealed : Unreadable {
  using Unreadable::Unreadable;
};

/// The bytes of an open file before its seal. Each is compared with the seal when it is read.
class SealedBytes {
 public:
  /// Reads and checks the table. In files of older programs one hash covers all bytes: those are
  /// read at once. Throws Unreadable, and Unsealed where there is no seal or it does not fit.
  explicit SealedBytes(int descriptor);

  std::uint64_t size() const { return size_; }
  /// Reads bytes before size(). Throws Unreadable, and Unsealed where one is damaged.
  void read(std::uint64_t at, char* to, std::size_t count);
  /// Reads all that read() has not yet, and throws as it does.
  void check_rest();

 private:
  void read_blocks(std::uint64_t at, char* to, std::size_t count);

  static constexpr std::uint64_t no_block = ~std::uint64_t{0};

  int descriptor_;
  std::uint64_t size_ = 0;
  std::string table_;                       // a Digest each block
  std::vector<bool> checked_;               // whether it has been compared
  std::uint64_t held_ = no_block;           // number of the block that is kept for the next read
  std::array<char, sealed_block> block_{};  // its bytes
};

/// Whether a file begins as HDF5, or ends as a sealed file. Throws FileError, Unreadable.
bool looks_like_hdf5(const std::filesystem::path& file);

/// Reads every byte of a file and compares it with the seal. Throws FileError, Unreadable, and
/// Unsealed where the file may not be given to HDF5.
void require_seal(const std::filesystem::path& file);

/// The text of Unsealed where a byte differs.
inline constexpr const char* damaged_text =
    "it is damaged: its bytes are not those that ra2d sealed";

}  // namespace ra2d
