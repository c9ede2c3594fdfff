// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_sdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/surface/areal.hpp"
#include "host/surface/numbers_in_bytes.hpp"
#include "host/surface/profile_lines.hpp"

namespace ra2d {
namespace {

constexpr std::size_t header_bytes = 81, version_bytes = 8;
constexpr std::size_t longest_word = 400, longest_line = 4096;
constexpr std::size_t most_lines = 1000;  // of a header

/// The types of the norm, by their numbers. What is most negative marks a missing point; unsigned
/// types have no mark.
struct Type {
  std::size_t bytes;
  double (*value)(const char* bytes);
  double missing;
};

template <class T>
constexpr Type type_of() {
  return {
      sizeof(T), &little_endian_value<T>,
      std::is_unsigned_v<T> ? quiet_nan : static_cast<double>(std::numeric_limits<T>::lowest())};
}
constexpr std::array<Type, 8> types{
    type_of<std::uint8_t>(), type_of<std::uint16_t>(), type_of<std::uint32_t>(), type_of<float>(),
    type_of<std::int8_t>(),  type_of<std::int16_t>(),  type_of<std::int32_t>(),  type_of<double>()};

struct SdfHeader {
  std::uint64_t points = 0, profiles = 0;
  double x_scale = 0, y_scale = 0, z_scale = 0;
  std::uint64_t compression = 0, data_type = 0, check_type = 0;

  const Type& type() const { return types[data_type]; }
};

[[noreturn]] void refuse_sdf(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: SDF: {}", file.string(), why));
}

/// Which of the points are read, from a header that was checked.
using Choose = std::function<GridLine(const SdfHeader& header)>;

void check(const std::filesystem::path& file, const SdfHeader& header, bool needs_x, bool needs_y) {
  const auto scale = [&](const char* name, double value, bool needed) {
    if (needed && !(value > 0 && std::isfinite(value)))
      refuse_sdf(file, fmt::format("{} = {}: expected a length in metres, > 0", name, value));
  };
  scale("Xscale", header.x_scale, needs_x);
  scale("Yscale", header.y_scale, needs_y);
  scale("Zscale", header.z_scale, true);
  if (header.compression != 0)
    refuse_sdf(file, "the data are compressed, which is not read: save them uncompressed");
  if (header.check_type != 0)
    refuse_sdf(file, "the data have a checksum, which is not read: save them without");
  if (header.data_type >= types.size())
    refuse_sdf(file, fmt::format("DataType = {}: expected 0 to 7", header.data_type));
}

Grid grid_of(const SdfHeader& header) {
  return {header.points, header.profiles, header.x_scale, header.y_scale};
}

/// A height [m] of a stored number, NaN for the mark of a missing point.
double height(const std::filesystem::path& file, const SdfHeader& header, double stored,
              std::uint64_t place) {
  if (std::isnan(stored) || stored == header.type().missing) return quiet_nan;
  const double z = stored * header.z_scale;
  if (!std::isfinite(z))
    refuse_sdf(file, fmt::format("point {}: a height that is not a finite number", place + 1));
  return z;
}

void add(Profile& profile, const std::filesystem::path& file, double z, std::uint64_t place) {
  profile.heights.push_back(z);
  if (std::isnan(z) && profile.first_missing.empty())
    profile.first_missing = fmt::format("{}: point {}", file.string(), place + 1);
}

SdfHeader binary_header(const char* bytes) {
  const char* at = bytes + version_bytes + 10 + 12 + 12;  // the maker and two dates
  SdfHeader header;
  header.points = little_endian<std::uint16_t>(at);
  header.profiles = little_endian<std::uint16_t>(at + 2);
  header.x_scale = little_endian<double>(at + 4);
  header.y_scale = little_endian<double>(at + 12);
  header.z_scale = little_endian<double>(at + 20);  // the resolution of z follows
  header.compression = static_cast<unsigned char>(at[36]);
  header.data_type = static_cast<unsigned char>(at[37]);
  header.check_type = static_cast<unsigned char>(at[38]);
  return header;
}

/// Doubt of what follows the heights, from byte `begin` on: the norm has a text there. Other bytes
/// may be heights that a count of 16 bits was too small for; empty where there are none.
std::string doubt_of_rest(const std::filesystem::path& file, const ProfileStream& stream,
                          const SdfHeader& header, std::uint64_t begin) {
  std::string rest(4096, '\0');
  rest.resize(stream.file().read(begin, rest.data(), rest.size()));
  rest.erase(rest.find_last_not_of('\0') + 1);
  if (std::none_of(rest.begin(), rest.end(), [](unsigned char c) { return c < '\t'; })) return {};
  return fmt::format(
      "{}: {} bytes that are no text follow the {} by {} heights of the header: does "
      "it count too few?",
      file.string(), stream.size() - begin, header.points, header.profiles);
}

Profile read_binary(const std::filesystem::path& file, ProfileStream& stream,
                    const Choose& choose) {
  const std::uint64_t size = stream.size();
  std::array<char, header_bytes> bytes{};
  if (!stream.read(bytes.data(), bytes.size()))
    refuse_sdf(file, fmt::format("cut off in its header: {} bytes, which alone has {}", size,
                                 header_bytes));
  const SdfHeader header = binary_header(bytes.data());
  const GridLine line = choose(header);
  const Type& type = header.type();
  const std::uint64_t needed = header_bytes + header.points * header.profiles * type.bytes;
  if (size < needed)
    refuse_sdf(file, fmt::format("{} by {} points need {} bytes, and the file has {}: it was cut "
                                 "off, or the header is wrong",
                                 header.points, header.profiles, needed, size));
  Profile profile;
  profile.doubt = doubt_of_rest(file, stream, header, needed);
  profile.spacing = line.spacing;
  std::array<char, 8> number{};
  for (std::uint64_t i = 0; i < line.count; ++i) {
    const std::uint64_t place = line.first + i * line.stride;
    if (i == 0 || line.stride > 1)
      stream.seekg(static_cast<std::streamoff>(header_bytes + place * type.bytes));
    if (!stream.read(number.data(), static_cast<std::streamsize>(type.bytes)))
      throw FileError(
          fmt::format("cannot read the profile {}: the reading stopped halfway", file.string()));
    add(profile, file, height(file, header, type.value(number.data()), place), place);
  }
  return profile;
}

/// A line of a header; false at the end of the file.
bool next_line(const std::filesystem::path& file, std::istream& stream, std::string& line) {
  line.clear();
  for (int c = stream.get(); c != std::istream::traits_type::eof(); c = stream.get()) {
    if (c == '\n') return true;
    line += static_cast<char>(c);
    if (line.size() > longest_line)
      refuse_sdf(file, fmt::format("a line of more than {} bytes in the header", longest_line));
  }
  return !line.empty();
}

std::string_view without_padding(std::string_view text) {
  using namespace std::string_view_literals;
  return trimmed(text, " \t\r\v\f\0"sv);
}

struct Field {
  const char* name;
  double SdfHeader::*length;
  std::uint64_t SdfHeader::*count;
  bool needed;
  bool found = false;
};

void read_field(const std::filesystem::path& file, SdfHeader& header, Field& field,
                std::string_view word) {
  if (std::exchange(field.found, true))
    refuse_sdf(file, fmt::format("{} stands twice in the header", field.name));
  const auto value = to_number(word);
  if (!value || !std::isfinite(*value))
    refuse_sdf(file, fmt::format("{} = {}: expected a number", field.name, ra2d::quoted(word)));
  if (field.length != nullptr) {
    header.*field.length = *value;
    return;
  }
  if (*value < 0 || *value > 1e15 || *value != std::floor(*value))
    refuse_sdf(file,
               fmt::format("{} = {}: expected a whole number", field.name, ra2d::quoted(word)));
  header.*field.count = static_cast<std::uint64_t>(*value);
}

SdfHeader text_header(const std::filesystem::path& file, std::istream& stream) {
  SdfHeader header;
  Field fields[] = {{"NumPoints", nullptr, &SdfHeader::points, true},
                    {"NumProfiles", nullptr, &SdfHeader::profiles, true},
                    {"Xscale", &SdfHeader::x_scale, nullptr, true},
                    {"Yscale", &SdfHeader::y_scale, nullptr, false},
                    {"Zscale", &SdfHeader::z_scale, nullptr, true},
                    {"Compression", nullptr, &SdfHeader::compression, false},
                    {"DataType", nullptr, &SdfHeader::data_type, true},
                    {"CheckType", nullptr, &SdfHeader::check_type, false}};
  std::string line;
  next_line(file, stream, line);  // the version
  for (std::size_t number = 2;; ++number) {
    if (number > most_lines || !next_line(file, stream, line))
      refuse_sdf(file, "no line * ends the header: was the file cut off?");
    std::string_view text = line;
    text = without_padding(text.substr(0, text.find(';')));  // a comment
    if (text == "*") break;
    const std::size_t mark = text.find('=');
    if (mark == text.npos) continue;
    for (Field& field : fields)
      if (without_padding(text.substr(0, mark)) == field.name)
        read_field(file, header, field, without_padding(text.substr(mark + 1)));
  }
  for (const Field& field : fields)
    if (field.needed && !field.found)
      refuse_sdf(file, fmt::format("{} is missing from the header", field.name));
  return header;
}

/// The next word; empty at the end of the file.
void next_word(const std::filesystem::path& file, std::istream& stream, std::string& word) {
  const auto is_blank = [](int c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  word.clear();
  int c = stream.get();
  while (is_blank(c)) c = stream.get();
  for (; c != std::istream::traits_type::eof() && !is_blank(c); c = stream.get()) {
    word += static_cast<char>(c);
    if (word.size() > longest_word)
      refuse_sdf(file, fmt::format("{} is no number", ra2d::quoted(word)));
  }
}

double stored_number(const std::filesystem::path& file, const std::string& word,
                     std::uint64_t place) {
  if (word == "BAD" || word == "Bad" || word == "bad") return quiet_nan;
  const auto value = to_number(word);
  if (!value)
    refuse_sdf(file, fmt::format("point {}: {} is not a number", place + 1, ra2d::quoted(word)));
  if (std::isinf(*value))
    refuse_sdf(file, fmt::format("point {}: {} is not a finite number in double precision",
                                 place + 1, ra2d::quoted(word)));
  return *value;
}

Profile read_text(const std::filesystem::path& file, std::istream& stream, const Choose& choose) {
  const SdfHeader header = text_header(file, stream);
  const GridLine line = choose(header);
  Profile profile;
  profile.spacing = line.spacing;
  const std::uint64_t all = header.points * header.profiles;
  std::uint64_t next = line.first;
  std::string word;
  for (std::uint64_t place = 0;; ++place) {
    next_word(file, stream, word);
    const bool ended = word.empty() || word == "*";
    if (ended && place == all) break;
    if (ended || place == all)
      refuse_sdf(file, fmt::format("{} by {} points by the header, and {} heights: it was cut off, "
                                   "or the header is wrong",
                                   header.points, header.profiles,
                                   ended ? fmt::format("{}", place) : std::string("more")));
    const double stored = stored_number(file, word, place);
    if (place + 1 == all && stream.eof()) profile.doubt = doubt_of_last_line(file);
    if (place != next || profile.heights.size() == line.count) continue;
    add(profile, file, height(file, header, stored, place), place);
    next += line.stride;
  }
  return profile;
}

/// The points that are chosen, as a profile.
Profile read_sdf(const std::filesystem::path& file, const Choose& choose) {
  ProfileStream stream(file);
  std::string version(version_bytes, '\0');
  stream.read(version.data(), static_cast<std::streamsize>(version_bytes));
  const std::string_view norm = std::string_view(version).substr(1);
  if (norm != "BCR-1.0" && norm != "ISO-1.0")
    refuse_sdf(file, fmt::format("version {}, which is not read: expected BCR-1.0 or ISO-1.0",
                                 ra2d::quoted(without_padding(version))));
  stream.clear();
  stream.seekg(0);
  return version[0] == 'b' ? read_binary(file, stream, choose) : read_text(file, stream, choose);
}

}  // namespace

bool begins_as_sdf(std::string_view bytes) {
  if (!bytes.starts_with('a') && !bytes.starts_with('b')) return false;
  bytes.remove_prefix(1);
  return bytes.starts_with("BCR-") || bytes.starts_with("ISO-") || bytes.starts_with("NIST-");
}

Profile read_profile_sdf(const std::filesystem::path& file, const ProfileQuery& query) {
  Profile profile = read_sdf(file, [&](const SdfHeader& header) {
    check(file, header, !query.column, query.column.has_value());
    return choose_line(file, "SDF", grid_of(header), query);
  });
  require_heights(file, profile);
  return profile;
}

HeightMap read_map_sdf(const std::filesystem::path& file, const MapQuery& query) {
  HeightMap map;
  Profile points = read_sdf(file, [&](const SdfHeader& header) {
    check(file, header, true, true);
    return whole_grid(file, "SDF", grid_of(header), query, map);
  });
  map.heights = std::move(points.heights);
  map.doubt = std::move(points.doubt);
  return map;
}

}  // namespace ra2d
