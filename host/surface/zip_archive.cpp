// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/zip_archive.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/surface/areal.hpp"
#include "host/surface/md5.hpp"
#include "host/surface/numbers_in_bytes.hpp"
#include "host/surface/profile_lines.hpp"

namespace ra2d {
namespace {

constexpr std::size_t end_bytes = 22, locator_bytes = 20;  // records at the end of an archive
constexpr std::uint32_t largest_directory = 1u << 16;      // bytes
constexpr zip_int64_t most_entries = 100;
constexpr std::uint64_t plainly_small = 1u << 22, largest_ratio = 100;
constexpr std::size_t part_bytes = 1u << 16;

/// Fault of the directory, which the library reads as a whole; empty where there is none.
/// Every record that may be the end of the archive counts: the library chooses among them.
std::string directory_fault(const InputFile& file) {
  const std::uint64_t most = 0xffff + end_bytes + locator_bytes;
  std::string tail(static_cast<std::size_t>(std::min(file.size(), most)), '\0');
  tail.resize(file.read(file.size() - tail.size(), tail.data(), tail.size()));
  for (std::size_t at = tail.find("PK\5\6"); at != tail.npos; at = tail.find("PK\5\6", at + 1)) {
    if (tail.size() - at < end_bytes) break;
    if (little_endian<std::uint32_t>(tail.data() + at + 12) > largest_directory)
      return "it lists more files than any profile has";
    if (at >= locator_bytes && tail.compare(at - locator_bytes, 4, "PK\6\7") == 0)
      return "it is of the kind Zip64, for files of more than 4 GiB: pack it as a usual one";
  }
  return {};
}

}  // namespace

void ZipArchive::refuse_archive(const std::string& why) const {
  throw RequestError(fmt::format("{}: the zip archive cannot be read: {}", file_.string(), why));
}

ZipArchive::ZipArchive(std::filesystem::path file) : file_(std::move(file)) {
  const ProfileStream stream(file_);
  if (const std::string fault = directory_fault(stream.file()); !fault.empty())
    refuse_archive(fault);
  int code = 0;
  const int own = fcntl(stream.file().descriptor(), F_DUPFD_CLOEXEC, 0);
  archive_ = zip_fdopen(own, 0, &code);  // which closes it in the end
  if (archive_ == nullptr) {
    close(own);
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    refuse_archive(why);
  }
  if (zip_get_num_entries(archive_, 0) <= most_entries) return;
  zip_discard(archive_);
  refuse_archive("it lists more files than any profile has");
}

ZipArchive::~ZipArchive() { zip_discard(archive_); }

std::optional<ZipArchive::Entry> ZipArchive::find(const std::string& name) const {
  std::optional<Entry> found;
  const auto entries = static_cast<zip_uint64_t>(zip_get_num_entries(archive_, 0));
  for (zip_uint64_t i = 0; i < entries; ++i) {
    zip_stat_t stat;
    zip_stat_init(&stat);
    if (zip_stat_index(archive_, i, ZIP_FL_ENC_RAW, &stat) != 0) continue;
    constexpr zip_uint64_t needed = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE |
                                    ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    if ((stat.valid & needed) != needed || stat.name != name) continue;
    if (found) refuse_archive(fmt::format("{} is there twice", ra2d::quoted(name)));
    if (stat.encryption_method != ZIP_EM_NONE)
      refuse_archive(fmt::format("{} is encrypted", ra2d::quoted(name)));
    if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE)
      refuse_archive(
          fmt::format("{} is neither stored nor deflated: pack it as usual", ra2d::quoted(name)));
    found = Entry{i, stat.size, stat.comp_size};
  }
  return found;
}

ZipArchive::Entry ZipArchive::entry(const std::string& name) const {
  const auto found = find(name);
  if (!found) refuse_archive(fmt::format("there is no {} in it", ra2d::quoted(name)));
  return *found;
}

std::optional<std::uint64_t> ZipArchive::size_of(const std::string& name) const {
  const auto found = find(name);
  if (!found) return {};
  return found->size;
}

void ZipArchive::require_usual_ratio(const std::string& name) const {
  const Entry found = entry(name);
  if (found.size > plainly_small && found.size / largest_ratio > found.packed)
    refuse_archive(fmt::format("{} would grow from {} to {} bytes, which no measurement does",
                               ra2d::quoted(name), found.packed, found.size));
}

std::string ZipArchive::read(const std::string& name, std::uint64_t most) const {
  const std::uint64_t size = entry(name).size;
  if (size > most)
    refuse_archive(
        fmt::format("{} has {} bytes, expected at most {}", ra2d::quoted(name), size, most));
  require_usual_ratio(name);
  std::string text;
  stream(name, size, 1, [&](const char* bytes, std::size_t count) { text.append(bytes, count); });
  return text;
}

std::string ZipArchive::stream(const std::string& name, std::uint64_t size, std::size_t unit,
                               const std::function<void(const char*, std::size_t)>& take) const {
  const Entry found = entry(name);
  if (found.size != size)
    refuse_archive(
        fmt::format("{} has {} bytes, expected {}", ra2d::quoted(name), found.size, size));
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> open(
      zip_fopen_index(archive_, found.index, 0), &zip_fclose);
  if (!open) refuse_archive(fmt::format("{}: {}", ra2d::quoted(name), zip_strerror(archive_)));
  Md5 md5;
  std::vector<char> part(part_bytes / unit * unit);
  const auto fill = [&](std::size_t wanted) {  // fewer only at the end
    std::size_t got = 0;
    while (got < wanted) {
      const zip_int64_t now = zip_fread(open.get(), part.data() + got, wanted - got);
      if (now < 0)
        refuse_archive(fmt::format("{}: {}", ra2d::quoted(name), zip_file_strerror(open.get())));
      if (now == 0) break;
      got += static_cast<std::size_t>(now);
    }
    return got;
  };
  for (std::uint64_t left = size; left > 0;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(left, part.size()));
    if (fill(wanted) != wanted)
      refuse_archive(fmt::format("{} ends before its {} bytes", ra2d::quoted(name), size));
    md5.add(part.data(), wanted);
    take(part.data(), wanted);
    left -= wanted;
  }
  if (fill(1) != 0)  // this also checks the sum of the last part
    refuse_archive(fmt::format("{} goes on after its {} bytes", ra2d::quoted(name), size));
  return md5.hex();
}

}  // namespace ra2d
