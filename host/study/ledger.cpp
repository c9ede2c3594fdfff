// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/ledger.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/base/text.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view file_magic = "ra2dlog\n", record_magic = "run\n";
constexpr std::uint32_t format = 1;
constexpr std::size_t head_size = 16, hash_size = 16;
constexpr std::size_t most_body = 1 << 20, longest_text = 8000;
constexpr std::size_t most_bytes = std::size_t{1} << 34;

/// Numbers as they stand in memory: little-endian (host/base/hash.hpp).
template <class Number>
void put(std::string& bytes, Number number) {
  const auto raw = std::bit_cast<std::array<char, sizeof number>>(number);
  bytes.append(raw.data(), raw.size());
}

void put(std::string& bytes, const std::string& text) {
  const std::string kept = shortened(text, longest_text);
  put(bytes, static_cast<std::uint32_t>(kept.size()));
  bytes += kept;
}

void put(std::string& bytes, const Key128& key) {
  put(bytes, key.high);
  put(bytes, key.low);
}

Key128 long_hash(std::string_view bytes) {
  const Digest digest = digest_of(bytes);
  Key128 key;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    std::uint64_t& half = i < digest.size() / 2 ? key.high : key.low;
    half = half << 8 | static_cast<unsigned char>(digest[i]);
  }
  return key;
}

/// Takes numbers from bytes; once they are at an end, nothing but zeros, and `fine` is false.
struct Cursor {
  std::string_view rest;
  bool fine = true;

  template <class Number>
  Number take() {
    std::array<char, sizeof(Number)> raw{};
    if (rest.size() < raw.size()) {
      fine = false;
      rest = {};
    } else {
      std::memcpy(raw.data(), rest.data(), raw.size());
      rest.remove_prefix(raw.size());
    }
    return std::bit_cast<Number>(raw);
  }
  Key128 key() {
    const auto high = take<std::uint64_t>();
    return {high, take<std::uint64_t>()};
  }
  std::string text() {
    const auto size = take<std::uint32_t>();
    if (size > rest.size()) {
      fine = false;
      return {};
    }
    std::string text(rest.substr(0, size));
    rest.remove_prefix(size);
    return text;
  }
};

std::string head_of(std::size_t body) {
  std::string head(record_magic);
  put(head, static_cast<std::uint32_t>(body));
  put(head, short_hash(head));
  return head;
}

using FigureBits = std::array<std::uint64_t, RunFigures::count>;
static_assert(sizeof(FigureBits) == sizeof(RunFigures));
using SoundBits = std::array<std::uint64_t, SoundFigures::count>;
static_assert(sizeof(SoundBits) == sizeof(SoundFigures));

std::string body_of(const FinishedRun& run) {
  std::string body;
  put(body, run.scene);
  put(body, run.run);
  put(body, static_cast<std::uint32_t>(run.status));
  for (const std::uint64_t bits : std::bit_cast<FigureBits>(run.figures)) put(body, bits);
  put(body, run.point);
  put(body, run.message);
  if (run.sound)  // records without it end here, as those of older programs
    for (const std::uint64_t bits : std::bit_cast<SoundBits>(*run.sound)) put(body, bits);
  return body;
}

/// Whether the bytes are all of a run; what was hashed may still have been written by nobody of
/// ours.
bool read_body(std::string_view body, FinishedRun& run) {
  Cursor in{body};
  run.scene = in.key();
  run.run = in.key();
  const auto status = in.take<std::uint32_t>();
  FigureBits bits;
  for (std::uint64_t& one : bits) one = in.take<std::uint64_t>();
  run.figures = std::bit_cast<RunFigures>(bits);
  run.point = in.text();
  run.message = in.text();
  if (in.fine && !in.rest.empty()) {
    SoundBits sound;
    for (std::uint64_t& one : sound) one = in.take<std::uint64_t>();
    run.sound = std::bit_cast<SoundFigures>(sound);
  }
  run.status = static_cast<RunStatus>(status);
  return in.fine && in.rest.empty() &&
         (status == static_cast<std::uint32_t>(RunStatus::done) ||
          status == static_cast<std::uint32_t>(RunStatus::refused) ||
          status == static_cast<std::uint32_t>(RunStatus::failed));
}

/// Whether the bytes are zeros alone, which a power cut leaves where data had not reached the disk.
bool is_empty(std::string_view bytes) {
  return bytes.find_first_not_of('\0') == std::string_view::npos;
}

FileError damage(const fs::path& file, std::size_t at, const std::string& what) {
  return FileError(fmt::format(
      "'{}' is damaged at byte {}: {}. To keep the runs before that and run the others again: "
      "truncate -s {} '{}'",
      file.string(), at, what, at, file.string()));
}

std::string read_all(int descriptor, const fs::path& file) {
  struct stat status;
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode))
    throw FileError(fmt::format("'{}' is no regular file: expected a study's ledger. Move it away",
                                file.string()));
  if (static_cast<std::size_t>(status.st_size) > most_bytes)
    throw FileError(fmt::format("'{}' is larger than any ledger", file.string()));
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t count =
        pread(descriptor, bytes.data() + have, bytes.size() - have, static_cast<off_t>(have));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0)
      throw FileError(fmt::format("cannot read '{}': {}", file.string(), std::strerror(errno)));
    if (count == 0) break;
    have += static_cast<std::size_t>(count);
  }
  bytes.resize(have);
  return bytes;
}

}  // namespace

bool agree(const FinishedRun& a, const FinishedRun& b) {
  FigureBits first = std::bit_cast<FigureBits>(a.figures),
             second = std::bit_cast<FigureBits>(b.figures);
  first.back() = second.back() = 0;  // wall_seconds
  return a.scene == b.scene && a.run == b.run && a.status == b.status && first == second;
}

std::string ledger_head() {
  std::string head(file_magic);
  put(head, format);
  put(head, static_cast<std::uint32_t>(short_hash(head)));
  return head;
}

std::string record_of(const FinishedRun& run) { return sealed_record(body_of(run)); }

std::string sealed_record(const std::string& body) {
  std::string record = head_of(body.size()) + body;
  put(record, long_hash(record));
  return record;
}

std::size_t read_ledger(std::string_view bytes, const fs::path& file,
                        const std::function<void(FinishedRun)>& take) {
  std::size_t whole = 0;
  const std::string expected = ledger_head();
  if (bytes.size() < head_size && (expected.starts_with(bytes) || is_empty(bytes))) return whole;
  if (is_empty(bytes)) return whole;
  if (!bytes.starts_with(expected)) {
    const bool of_another = bytes.starts_with(file_magic);
    throw FileError(fmt::format("'{}' {}. Move it away; its runs are then run again", file.string(),
                                of_another ? "is damaged at its beginning, or of another format"
                                           : "is no ledger of a study"));
  }
  whole = head_size;
  while (whole < bytes.size()) {
    const std::string_view rest = bytes.substr(whole);
    if (is_empty(rest)) break;
    const std::string_view head = rest.substr(0, head_size);
    Cursor in{head};
    in.rest.remove_prefix(std::min(record_magic.size(), head.size()));
    const auto body = in.take<std::uint32_t>();
    if (head.size() < head_size) break;
    if (head != head_of(body) || body > most_body)
      throw damage(file, whole, "no record begins there");
    const std::size_t size = head_size + body + hash_size;
    if (rest.size() < size) break;
    Cursor end{rest.substr(head_size + body, hash_size)};
    FinishedRun run;
    if (end.key() != long_hash(rest.substr(0, head_size + body))) {
      if (is_empty(rest.substr(size))) break;  // the last one: written in part
      throw damage(file, whole, "the record there is not as it was written");
    }
    if (!read_body(rest.substr(head_size, body), run))
      throw damage(file, whole, "the record there holds no run");
    take(std::move(run));
    whole += size;
  }
  return whole;
}

ParsedLedger parse_ledger(std::string_view bytes, const fs::path& file) {
  ParsedLedger parsed;
  parsed.whole =
      read_ledger(bytes, file, [&](FinishedRun run) { parsed.runs.push_back(std::move(run)); });
  return parsed;
}

LedgerWriter::LedgerWriter(const fs::path& file) : file_{file} {
  const auto fail = [&](const char* doing, int error) {
    if (descriptor_ >= 0) close(std::exchange(descriptor_, -1));
    throw write_failure(doing, file_, std::strerror(error), error);
  };
  descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
  if (descriptor_ < 0) fail("write to", errno);
  if (!lock_file(descriptor_)) {
    close(std::exchange(descriptor_, -1));
    throw FileError(fmt::format(
        "another process runs this part of the study: it holds '{}'. Wait for it, choose another "
        "folder with -o, or share the work with --shard I/N",
        file_.string()));
  }
  try {
    const std::string bytes = read_all(descriptor_, file_);
    const auto nothing = [](const FinishedRun&) {};
    size_ = read_ledger(bytes, file_, nothing);
    if (bytes.size() > size_ && ftruncate(descriptor_, static_cast<off_t>(size_)) != 0)
      fail("cut the end off", errno);
    if (size_ == 0) {
      const std::string head = ledger_head();
      if (pwrite(descriptor_, head.data(), head.size(), 0) != static_cast<ssize_t>(head.size()))
        fail("write to", errno);
      size_ = head.size();
      synced_ = false;
    }
  } catch (...) {
    if (descriptor_ >= 0) close(std::exchange(descriptor_, -1));
    throw;
  }
}

LedgerWriter::~LedgerWriter() {
  if (descriptor_ >= 0) close(descriptor_);
}

void LedgerWriter::append(const FinishedRun& run) {
  const std::string record = record_of(run);
  const std::lock_guard lock(mutex_);
  std::size_t written = 0;
  while (written < record.size()) {  // of a disk that fills up, a part
    errno = 0;
    const ssize_t count = pwrite(descriptor_, record.data() + written, record.size() - written,
                                 static_cast<off_t>(size_ + written));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const int error = errno;
      // should this fail, too, the next process that opens the file cuts it off
      [[maybe_unused]] const int cut = ftruncate(descriptor_, static_cast<off_t>(size_));
      throw write_failure("write to", file_, std::strerror(error), error);
    }
    written += static_cast<std::size_t>(count);
  }
  size_ += record.size();
  synced_ = false;
}

void LedgerWriter::sync() {
  {
    const std::lock_guard lock(mutex_);
    if (synced_) return;
    synced_ = true;  // runs that end from now on are the next one's
  }
  if (fdatasync(descriptor_) != 0) {
    const int error = errno;
    throw write_failure("finish", file_, std::strerror(error), error);
  }
}

void FinishedRuns::add(FinishedRun run, const fs::path& from) {
  const auto found = runs.find(run.scene);
  if (found == runs.end()) {
    const Key128 scene = run.scene;
    runs.emplace(scene, std::move(run));
    return;
  }
  FinishedRun& before = found->second;
  const bool was_done = before.status == RunStatus::done, is_done = run.status == RunStatus::done;
  if (was_done && is_done && !agree(before, run))
    throw FileError(fmt::format(
        "two runs of one scene have other numbers: {} (v_rms {} and {} m/s), the second in '{}'. "
        "One of them is not of this build, or damaged: move that ledger away",
        run.point, before.figures.v_rms, run.figures.v_rms, from.string()));
  const bool has_more = was_done && is_done && !before.sound && run.sound;
  if (!was_done || has_more) before = std::move(run);
}

void FinishedRuns::add(const StudyFolder& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (fs::directory_iterator entry(folder.ledgers(), none), end; !none && entry != end;
       entry.increment(none))
    if (entry->path().extension() == ".log") files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  auto place = std::find(folders.begin(), folders.end(), folder.path);
  if (place == folders.end()) place = folders.insert(place, folder.path);
  const auto number = static_cast<std::size_t>(place - folders.begin());
  for (const fs::path& file : files) {
    const InputFile input(file, "the ledger");
    read_ledger(read_all(input.descriptor(), file), file, [&](FinishedRun run) {
      run.folder = number;
      add(std::move(run), file);
    });
  }
}

const FinishedRun* FinishedRuns::find(const Key128& scene) const {
  const auto found = runs.find(scene);
  return found != runs.end() ? &found->second : nullptr;
}

}  // namespace ra2d
