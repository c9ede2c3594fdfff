// SPDX-License-Identifier: BSD-3-Clause
#include "host/sound/audio_file.hpp"

#include <sndfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

int code_of(AudioFormat format) {
  switch (format) {
    case AudioFormat::wav_float:
      return SF_FORMAT_WAV | SF_FORMAT_FLOAT;
    case AudioFormat::wav_16:
      return SF_FORMAT_WAV | SF_FORMAT_PCM_16;
    case AudioFormat::flac_24:
      return SF_FORMAT_FLAC | SF_FORMAT_PCM_24;
  }
  return 0;
}

/// The nearest whole number of so many bits, of which 1 is just too much, at the top of 32.
std::int32_t quantised(double value, int bits) {
  const double steps = std::ldexp(1.0, bits - 1);
  const double whole = std::clamp(std::round(value * steps), -steps, steps - 1);
  return static_cast<std::int32_t>(whole * std::ldexp(1.0, 32 - bits));
}

/// Calls `body` until it has moved all bytes, or failed; how many it moved.
template <class Body>
std::int64_t move_all(std::int64_t count, int& first_error, Body body) {
  std::int64_t done = 0;
  while (done < count) {
    const ssize_t now = body(done);
    if (now < 0 && errno == EINTR) continue;
    if (now < 0 && first_error == 0) first_error = errno;
    if (now <= 0) break;
    done += now;
  }
  return done;
}

}  // namespace

// ---- where bytes go ----------------------------------------------------------------------------

std::int64_t DescriptorStore::size() {
  struct stat status;
  return fstat(descriptor_, &status) == 0 ? status.st_size : -1;
}

std::int64_t DescriptorStore::read(char* bytes, std::int64_t count, std::int64_t at) {
  return move_all(count, error_, [&](std::int64_t done) {
    return pread(descriptor_, bytes + done, static_cast<std::size_t>(count - done), at + done);
  });
}

std::int64_t DescriptorStore::write(const char* bytes, std::int64_t count, std::int64_t at) {
  return move_all(count, error_, [&](std::int64_t done) {
    return pwrite(descriptor_, bytes + done, static_cast<std::size_t>(count - done), at + done);
  });
}

std::int64_t MemoryStore::read(char* bytes, std::int64_t count, std::int64_t at) {
  const std::int64_t now = std::clamp<std::int64_t>(size() - at, 0, count);
  if (now > 0) std::memcpy(bytes, bytes_.data() + at, static_cast<std::size_t>(now));
  return now;
}

std::int64_t MemoryStore::write(const char* bytes, std::int64_t count, std::int64_t at) {
  const auto end = static_cast<std::size_t>(at + count);
  if (bytes_.size() < end) bytes_.resize(end);
  std::memcpy(bytes_.data() + at, bytes, static_cast<std::size_t>(count));
  return count;
}

// ---- the writer --------------------------------------------------------------------------------

double most_frames(AudioFormat format) {
  switch (format) {
    case AudioFormat::wav_float:
      return 0x1p30 - 0x1p12;  // 4 GiB in all
    case AudioFormat::wav_16:
      return 0x1p31 - 0x1p12;
    case AudioFormat::flac_24:
      return 0x1p36 - 1;
  }
  return 0;
}

struct AudioWriter::Handle {
  ByteStore& store;
  std::int64_t at = 0;
  SNDFILE* file = nullptr;

  ~Handle() { close(); }
  int close() { return file == nullptr ? 0 : sf_close(std::exchange(file, nullptr)); }

  static Handle& of(void* user) { return *static_cast<Handle*>(user); }
  static sf_count_t length(void* user) { return of(user).store.size(); }
  static sf_count_t tell(void* user) { return of(user).at; }
  static sf_count_t seek(sf_count_t offset, int whence, void* user) {
    Handle& h = of(user);
    const sf_count_t base = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? h.at : h.store.size();
    return h.at = base + offset;
  }
  static sf_count_t read(void* bytes, sf_count_t count, void* user) {
    Handle& h = of(user);
    const sf_count_t done = h.store.read(static_cast<char*>(bytes), count, h.at);
    h.at += done;
    return done;
  }
  static sf_count_t write(const void* bytes, sf_count_t count, void* user) {
    Handle& h = of(user);
    const sf_count_t done = h.store.write(static_cast<const char*>(bytes), count, h.at);
    h.at += done;
    return done;
  }
};

AudioWriter::AudioWriter(ByteStore& store, AudioFormat format, int rate, const AudioNotes& notes,
                         const std::filesystem::path& path)
    : store_{store}, format_{format}, path_{path}, handle_{new Handle{store}} {
  static SF_VIRTUAL_IO calls{Handle::length, Handle::seek, Handle::read, Handle::write,
                             Handle::tell};
  SF_INFO info{};
  info.samplerate = rate;
  info.channels = 1;
  info.format = code_of(format);
  handle_->file = sf_open_virtual(&calls, SFM_WRITE, &info, handle_.get());
  if (handle_->file == nullptr) throw write_failure("write", path_, sf_strerror(nullptr), 0);
  // The chunk of peaks has the time of day in it: the same sound would not be the same bytes.
  sf_command(handle_->file, SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  for (const auto& [type, text] : {std::pair{SF_STR_TITLE, &notes.title},
                                   {SF_STR_COMMENT, &notes.comment},
                                   {SF_STR_SOFTWARE, &notes.software}})
    if (!text->empty()) sf_set_string(handle_->file, type, text->c_str());
}

AudioWriter::~AudioWriter() = default;

void AudioWriter::require(bool written) const {
  if (store_.error() != 0)
    throw write_failure("write", path_, std::strerror(store_.error()), store_.error());
  if (!written) throw write_failure("write", path_, sf_strerror(handle_->file), 0);
}

void AudioWriter::write(std::span<const double> samples) {
  const auto count = static_cast<sf_count_t>(samples.size());
  if (format_ == AudioFormat::wav_float)
    return require(sf_write_double(handle_->file, samples.data(), count) == count);
  const int bits = format_ == AudioFormat::wav_16 ? 16 : 24;
  whole_.resize(samples.size());
  std::transform(samples.begin(), samples.end(), whole_.begin(),
                 [&](double value) { return quantised(value, bits); });
  require(sf_write_int(handle_->file, whole_.data(), count) == count);
}

void AudioWriter::close() { require(handle_->close() == 0); }

}  // namespace ra2d
