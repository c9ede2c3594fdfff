// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// Files of one channel of sound, by libsndfile.
namespace ra2d {

enum class AudioFormat { wav_float, wav_16, flac_24 };

/// Where the bytes of a sound go.
class ByteStore {
 public:
  virtual ~ByteStore() = default;
  virtual std::int64_t size() = 0;
  /// How many of the bytes could be read or written; fewer than `count` is a failure of a write.
  virtual std::int64_t read(char* bytes, std::int64_t count, std::int64_t at) = 0;
  virtual std::int64_t write(const char* bytes, std::int64_t count, std::int64_t at) = 0;
  int error() const { return error_; }  // errno of the first failure; 0

 protected:
  int error_ = 0;
};

/// An open file.
class DescriptorStore : public ByteStore {
 public:
  explicit DescriptorStore(int descriptor) : descriptor_{descriptor} {}
  std::int64_t size() override;
  std::int64_t read(char* bytes, std::int64_t count, std::int64_t at) override;
  std::int64_t write(const char* bytes, std::int64_t count, std::int64_t at) override;

 private:
  int descriptor_;
};

class MemoryStore : public ByteStore {
 public:
  std::int64_t size() override { return static_cast<std::int64_t>(bytes_.size()); }
  std::int64_t read(char* bytes, std::int64_t count, std::int64_t at) override;
  std::int64_t write(const char* bytes, std::int64_t count, std::int64_t at) override;
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// The texts inside a sound file. Printable, one line each.
struct AudioNotes {
  std::string title, comment, software;
};

/// Most samples that a file of the format holds.
double most_frames(AudioFormat format);

/// Writes a sound whose full scale is 1. A float beyond that stays as it is; whole numbers are
/// clipped.
class AudioWriter {
 public:
  /// `path` is what a FileError names.
  AudioWriter(ByteStore& store, AudioFormat format, int rate, const AudioNotes& notes,
              const std::filesystem::path& path);
  ~AudioWriter();
  AudioWriter(const AudioWriter&) = delete;
  AudioWriter& operator=(const AudioWriter&) = delete;

  void write(std::span<const double> samples);
  /// To be called last: the file is whole then.
  void close();

 private:
  struct Handle;
  void require(bool written) const;

  ByteStore& store_;
  AudioFormat format_;
  std::filesystem::path path_;
  std::unique_ptr<Handle> handle_;
  std::vector<std::int32_t> whole_;
};

}  // namespace ra2d
