// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/hash.hpp"
#include "host/store/result_reader.hpp"
#include "host/store/table.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_held = 256;

bool is_there(const std::filesystem::path& name) {
  std::error_code none;
  return std::filesystem::exists(std::filesystem::symlink_status(name, none));
}

/// Writes a segment once more, also where its folder is gone; its lock is taken again later
/// (ClaimedOutput::hold).
void copy(const InputFile& segment, const std::filesystem::path& name) {
  std::error_code none;
  std::filesystem::create_directory(name.parent_path(), none);
  PartialFile file(name);
  std::array<char, 1 << 18> block;
  for (std::uint64_t at = 0; const std::size_t count = segment.read(at, block.data(), block.size());
       at += count)
    file.write(std::string_view(block.data(), count));
  file.sync();
  file.publish();
}

/// Bytes and hash of a file as it stands; no numbers of samples and shocks.
Segment hashed(const InputFile& in) {
  Segment segment;
  Hash hash;
  std::array<char, 1 << 18> block;
  while (const std::size_t count = in.read(segment.bytes, block.data(), block.size())) {
    hash.add(std::string_view(block.data(), count));
    segment.bytes += count;
  }
  segment.xxh3_128 = hash.text();
  return segment;
}

}  // namespace

void require_segment(const std::filesystem::path& file, const Segment& segment) {
  const Segment found = hashed(InputFile(file));
  if (found.bytes != segment.bytes || found.xxh3_128 != segment.xxh3_128)
    throw FileError(
        fmt::format("'{}' is damaged: it has {} bytes of the hash {}, and was closed with {} "
                    "of {}",
                    file.string(), found.bytes, found.xxh3_128, segment.bytes, segment.xxh3_128));
}

Recording::Recording(OutputNames names, const ResultHeader& header, std::vector<Segment> before)
    : names_{std::move(names)}, header_{header} {
  for (Segment& segment : before)
    add(std::move(segment), std::make_unique<InputFile>(names_.segment(segments_.size() + 1)));
  begin();
}

void Recording::add(Segment segment, std::unique_ptr<InputFile> file) {
  segments_.push_back(std::move(segment));
  if (held_.size() < most_held) held_.push_back(std::move(file));
}

void Recording::restore(std::size_t i) {
  const std::filesystem::path name = names_.segment(i + 1);
  if (i < held_.size() && !is_there(name)) copy(*held_[i], name);
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
  std::unique_ptr<InputFile> file;
  try {
    file_->close(so_far, name, file);
  } catch (const FileError&) {
    if (file == nullptr || is_there(names_.segments)) throw;
    copy(*file, name);  // somebody has removed the folder at this moment
  }
  Segment segment = hashed(*file);
  segment.samples = samples_;
  segment.shocks = shocks_;
  add(std::move(segment), std::move(file));
  return true;
}

const std::vector<Segment>& Recording::close_segment(const ResultSummary& so_far,
                                                     const SegmentStart& next) {
  for (std::size_t i = 0; i < held_.size(); ++i) restore(i);
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
  each_block([&](const SampleBlock& samples) { whole.append(samples); },
             [&](const std::vector<Shock>& shocks) { whole.append(shocks); });
  return whole.close(summary);
}

void Recording::each_block(const std::function<void(const SampleBlock&)>& samples,
                           const std::function<void(const std::vector<Shock>&)>& shocks) {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    restore(i);
    const ResultReader reader(names_.segment(i + 1));
    const ResultContents& contents = reader.contents();
    for (std::size_t first = 0; first < contents.samples; first += rows_at_once)
      samples(reader.samples(first, std::min(rows_at_once, contents.samples - first)));
    shocks(contents.shocks);
  }
}

}  // namespace ra2d
