// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "host/base/errors.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {

namespace fs = std::filesystem;

std::string Shard::name() const {
  return is_whole() ? "all" : fmt::format("shard-{}-of-{}", index, count);
}

fs::path StudyFolder::ledger(const Shard& shard, int rank) const {
  return ledgers() / (shard.name() + (rank > 0 ? fmt::format("-rank-{}", rank) : "") + ".log");
}

fs::path StudyFolder::status(const Shard& shard) const {
  return path / (shard.is_whole() ? "status.json" : "status-" + shard.name() + ".json");
}

void StudyFolder::make(bool with_results) const {
  std::error_code error;
  if (fs::exists(path, error) && !fs::is_directory(path, error))
    throw RequestError(fmt::format("cannot write to '{}': this is no folder. Name a folder with -o",
                                   path.string()));
  for (const fs::path& folder : {path, ledgers(), results()}) {
    if (folder == results() && !with_results) continue;
    if (mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) {
      const int fault = errno;
      throw write_failure("create the folder", folder, std::strerror(fault), fault);
    }
  }
}

std::string read_text(const fs::path& file, const char* what, std::size_t most) {
  const InputFile in(file, what);
  if (in.size() > most)
    throw in.unreadable(fmt::format("it has more than {} MiB (is it another file?)", most >> 20));
  return in.beginning(most);
}

bool lock_file(int descriptor) {
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_SETLK, &whole) == 0 || (errno != EAGAIN && errno != EACCES);
}

TableLock::TableLock(const StudyFolder& folder) {
  const fs::path file = folder.ledgers() / "table.lock";
  descriptor_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (descriptor_ < 0) {
    const int fault = errno;
    throw write_failure("write to", file, std::strerror(fault), fault);
  }
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  // where there are no locks, the later of two writers wins
  while (fcntl(descriptor_, F_OFD_SETLKW, &whole) != 0 && errno == EINTR) continue;
}

TableLock::~TableLock() { close(descriptor_); }

}  // namespace ra2d
