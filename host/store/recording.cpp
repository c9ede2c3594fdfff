// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/recording.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "host/errors.hpp"
#include "host/hash.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/table.hpp"

namespace ra2d {
namespace {

/// Bytes and hash of a file as it stands; no numbers of samples and shocks.
Segment hashed(const std::filesystem::path& file) {
  const auto fail = [&](int error) {
    throw FileError(fmt::format("cannot read '{}': {}", file.string(), std::strerror(error)));
  };
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail(errno);
  Segment segment;
  Hash hash;
  std::array<char, 1 << 18> block;
  ssize_t count = 0;
  while ((count = read(descriptor, block.data(), block.size())) != 0) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) break;
    hash.add(std::string_view(block.data(), static_cast<std::size_t>(count)));
    segment.bytes += static_cast<std::uint64_t>(count);
  }
  const int error = errno;
  ::close(descriptor);
  if (count < 0) fail(error);
  segment.xxh3_128 = hash.text();
  return segment;
}

}  // namespace

void require_segment(const std::filesystem::path& file, const Segment& segment) {
  const Segment found = hashed(file);
  if (found.bytes != segment.bytes || found.xxh3_128 != segment.xxh3_128)
    throw FileError(
        fmt::format("'{}' is damaged: it has {} bytes of the hash {}, and was closed with {} "
                    "of {}",
                    file.string(), found.bytes, found.xxh3_128, segment.bytes, segment.xxh3_128));
}

Recording::Recording(OutputNames names, const ResultHeader& header, std::vector<Segment> before)
    : names_{std::move(names)}, header_{header}, segments_{std::move(before)} {
  begin();
}

void Recording::begin() {
  samples_ = shocks_ = 0;
  file_.emplace(names_.result, header_);
}

void Recording::append(const SampleBlock& block) {
  file_->append(block);
  samples_ += static_cast<std::int64_t>(block.time.size());
}

void Recording::append(const std::vector<Shock>& shocks) {
  file_->append(shocks);
  shocks_ += static_cast<std::int64_t>(shocks.size());
}

bool Recording::seal(const ResultSummary& so_far) {
  if (samples_ == 0 && shocks_ == 0) return false;
  const std::filesystem::path name = names_.segment(segments_.size() + 1);
  file_->close(so_far, name);
  Segment segment = hashed(name);
  segment.samples = samples_;
  segment.shocks = shocks_;
  segments_.push_back(std::move(segment));
  return true;
}

const std::vector<Segment>& Recording::close_segment(const ResultSummary& so_far,
                                                     const SegmentStart& next) {
  if (seal(so_far)) {
    header_.segment = next;
    begin();
  }
  return segments_;
}

double Recording::close(const ResultSummary& summary) {
  if (segments_.empty()) return file_->close(summary);
  seal(summary);
  file_.reset();
  header_.segment = {};
  ResultFile whole(names_.result, header_);
  join(whole);
  return whole.close(summary);
}

void Recording::join(ResultFile& whole) {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const ResultReader reader(names_.segment(i + 1));
    const ResultContents& contents = reader.contents();
    for (std::size_t first = 0; first < contents.samples; first += rows_at_once)
      whole.append(reader.samples(first, std::min(rows_at_once, contents.samples - first)));
    whole.append(contents.shocks);
  }
}

}  // namespace ra2d
