// SPDX-License-Identifier: BSD-3-Clause
#include "host/surface/profile_x3p.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/quiet_nan.hpp"
#include "host/base/text.hpp"
#include "host/surface/areal.hpp"
#include "host/surface/md5.hpp"
#include "host/surface/numbers_in_bytes.hpp"
#include "host/surface/profile_lines.hpp"
#include "host/surface/zip_archive.hpp"

namespace ra2d {
namespace {

constexpr std::uint64_t largest_main = 8u << 20, largest_checksum = 4096;  // bytes
// The parser takes 64 bytes for each tag and each text, whatever they say.
constexpr std::ptrdiff_t most_marks = 250'000;

[[noreturn]] void refuse_x3p(const std::filesystem::path& file, const std::string& why) {
  throw RequestError(fmt::format("{}: X3P: {}", file.string(), why));
}

bool same_digits(std::string_view a, std::string_view b) {
  const auto small = [](char c) { return c >= 'A' && c <= 'F' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return small(x) == small(y); });
}

/// An element of the document; its name space may be anybody's.
class Element {
 public:
  Element(const std::filesystem::path& file, pugi::xml_node node, std::string name)
      : file_(&file), node_(node), name_(std::move(name)) {}

  bool stands() const { return !node_.empty(); }
  pugi::xml_node node() const { return node_; }
  Element child(const char* name) const {
    for (const pugi::xml_node child : node_.children())
      if (is(child, name)) return {*file_, child, name_ + '/' + name};
    return {*file_, {}, name_ + '/' + name};
  }
  Element need(const char* name) const {
    Element found = child(name);
    if (!found.stands()) refuse_x3p(*file_, fmt::format("main.xml has no {}", found.name_));
    return found;
  }
  std::string_view text() const { return trimmed(node_.child_value()); }
  double number() const {
    const auto value = to_number(text());
    if (!value || !std::isfinite(*value)) refuse_value("expected a number");
    return *value;
  }
  std::uint64_t count() const {
    const double value = number();
    if (value < 1 || value > 1e15 || value != std::floor(value))
      refuse_value("expected a whole number from 1");
    return static_cast<std::uint64_t>(value);
  }
  [[noreturn]] void refuse_value(const char* expected) const {
    refuse_x3p(*file_, fmt::format("{} = {}: {}", name_, ra2d::quoted(text()), expected));
  }
  static bool is(pugi::xml_node node, std::string_view name) {
    const std::string_view whole = node.name();
    return whole.substr(whole.find(':') + 1) == name;  // without a colon all of it
  }

 private:
  const std::filesystem::path* file_;
  pugi::xml_node node_;
  std::string name_;
};

struct Axis {
  bool absolute = false;  // its coordinate stands at every point
  double increment = 1, offset = 0;
  std::size_t bytes = 0;
  double (*value)(const char*) = nullptr;
  double precision = 0;  // of a coordinate: relative, or m
  bool whole = false;    // a whole number of increments

  double at(double stored) const { return increment * stored + offset; }
};

void read_type(Axis& axis, const Element& type) {
  const std::string_view word = type.text();
  if (word == "I")
    axis.bytes = 2, axis.value = &little_endian_value<std::int16_t>, axis.whole = true;
  else if (word == "L")
    axis.bytes = 4, axis.value = &little_endian_value<std::int32_t>, axis.whole = true;
  else if (word == "F")
    axis.bytes = 4, axis.value = &little_endian_value<float>, axis.precision = 0x1p-24;
  else if (word == "D")
    axis.bytes = 8, axis.value = &little_endian_value<double>, axis.precision = 0x1p-53;
  else
    type.refuse_value("expected I, L, F or D");
}

Axis read_axis(const Element& in) {
  Axis axis;
  const Element kind = in.need("AxisType");
  axis.absolute = kind.text() == "A";
  if (!axis.absolute && kind.text() != "I") kind.refuse_value("expected A or I");
  const Element increment = axis.absolute ? in.child("Increment") : in.need("Increment");
  const bool is_given = increment.stands() && !increment.text().empty();
  if (!axis.absolute || is_given) axis.increment = increment.number();
  if (!(axis.increment > 0)) increment.refuse_value("expected a length in metres, > 0");
  const Element offset = in.child("Offset");
  if (offset.stands() && !offset.text().empty()) axis.offset = offset.number();
  if (axis.absolute) read_type(axis, in.need("DataType"));
  return axis;
}

/// Axes and grid, from main.xml.
struct Layout {
  std::array<Axis, 3> axes;  // x, y, z
  Grid grid;

  std::size_t record() const {  // bytes of a point
    std::size_t bytes = 0;
    for (const Axis& axis : axes) bytes += axis.bytes;
    return bytes;
  }
};

void check_rotation(const std::filesystem::path& file, const Element& axes) {
  const Element rotation = axes.child("Rotation");
  if (!rotation.stands()) return;
  for (int row = 1; row <= 3; ++row)
    for (int column = 1; column <= 3; ++column) {
      const Element entry = rotation.child(fmt::format("r{}{}", row, column).c_str());
      if (entry.stands() && std::abs(entry.number() - (row == column)) > 1e-9)
        refuse_x3p(file, "the axes are rotated, which is not read: save the file without");
    }
}

Layout read_layout(const std::filesystem::path& file, const Element& root) {
  const Element record1 = root.need("Record1"), record3 = root.need("Record3");
  if (record1.child("FeatureType").stands() && record1.child("FeatureType").text() == "PCL")
    refuse_x3p(file, "a cloud of points has no profiles");
  const Element axes = record1.need("Axes");
  check_rotation(file, axes);
  Layout layout{{read_axis(axes.need("CX")), {}, read_axis(axes.need("CZ"))}, {}};
  const Element y = axes.child("CY");
  if (y.stands()) layout.axes[1] = read_axis(y);
  if (!layout.axes[2].absolute) axes.need("CZ").need("AxisType").refuse_value("expected A");
  const Element matrix = record3.child("MatrixDimension");
  if (matrix.stands()) {
    layout.grid.points = matrix.need("SizeX").count();
    layout.grid.profiles = matrix.need("SizeY").count();
    if (matrix.need("SizeZ").count() != 1)
      matrix.need("SizeZ").refuse_value("several layers are not read: expected 1");
  } else {
    layout.grid.points = record3.need("ListDimension").count();
    layout.grid.profiles = 1;
  }
  layout.grid.dx = layout.axes[0].increment;
  layout.grid.dy = layout.axes[1].increment;
  return layout;
}

/// Takes the points of the line from all points in their order.
class Collector {
 public:
  Collector(const std::filesystem::path& file, const Layout& layout, const GridLine& line)
      : file_(file), layout_(layout), line_(line), next_(line.first) {}

  bool wants(std::uint64_t place) const { return place == next_ && heights.size() < line_.count; }
  /// A point that is wanted: what is stored of it along its axes.
  void add(const std::array<double, 3>& stored) {
    const Axis& z = layout_.axes[2];
    const double height = z.at(stored[2]);
    if (std::isinf(height))
      refuse_x3p(file_, fmt::format("point {}: a height that is not a finite number", next_ + 1));
    heights.push_back(height);
    if (along().absolute) {
      places.push_back(along().at(stored[line_.along_y ? 1 : 0]));
      if (!std::isfinite(places.back()))
        refuse_x3p(file_, fmt::format("point {}: {} is not a finite number", next_ + 1,
                                      line_.along_y ? "y" : "x"));
    }
    next_ += line_.stride;
  }
  const Axis& along() const { return layout_.axes[line_.along_y ? 1 : 0]; }

  std::vector<double> heights, places;  // places of an absolute axis alone

 private:
  const std::filesystem::path& file_;
  const Layout& layout_;
  const GridLine& line_;
  std::uint64_t next_;
};

void require_checksum(const std::filesystem::path& file, const std::string& found,
                      std::string_view stored, const std::string& name) {
  if (!same_digits(found, stored))
    refuse_x3p(file,
               fmt::format("the checksum of {} is {}, but the file says {}: it is damaged, or "
                           "was changed after it was measured",
                           name, found, ra2d::quoted(stored)));
}

/// The mask has a bit for each point, the lowest first: 1 where it is valid.
void apply_mask(const std::filesystem::path& file, const ZipArchive& archive, const Element& link,
                const Layout& layout, const GridLine& line, std::vector<double>& heights) {
  const Element valid = link.child("ValidPointsLink");
  if (!valid.stands() || valid.text().empty()) return;
  const std::string name(valid.text());
  const std::uint64_t all = layout.grid.points * layout.grid.profiles;
  std::uint64_t begun = 0;
  std::size_t i = 0;
  const std::string md5 =
      archive.stream(name, (all + 7) / 8, 1, [&](const char* bytes, std::size_t count) {
        for (; i < heights.size(); ++i) {
          const std::uint64_t place = line.first + i * line.stride;
          if (place / 8 >= begun + count) break;
          if ((static_cast<unsigned char>(bytes[place / 8 - begun]) >> (place % 8) & 1) == 0)
            heights[i] = quiet_nan;
        }
        begun += count;
      });
  const Element sum = link.child("MD5ChecksumValidPoints");
  if (sum.stands() && !sum.text().empty()) require_checksum(file, md5, sum.text(), name);
}

void read_heights_file(const std::filesystem::path& file, const ZipArchive& archive,
                       const Element& link, const Layout& layout, const GridLine& line,
                       Collector& points) {
  const std::string name(link.need("PointDataLink").text());
  const std::uint64_t all = layout.grid.points * layout.grid.profiles;
  const std::size_t record = layout.record();
  std::uint64_t place = 0;
  archive.require_usual_ratio(name);
  const std::string md5 =
      archive.stream(name, all * record, record, [&](const char* bytes, std::size_t count) {
        for (std::size_t at = 0; at < count; at += record, ++place) {
          if (!points.wants(place)) continue;
          std::array<double, 3> stored{};
          const char* from = bytes + at;
          for (std::size_t a = 0; a < 3; ++a)
            if (const Axis& axis = layout.axes[a]; axis.absolute)
              stored[a] = axis.value(from), from += axis.bytes;
          points.add(stored);
        }
      });
  require_checksum(file, md5, link.need("MD5ChecksumPointData").text(), name);
  apply_mask(file, archive, link, layout, line, points.heights);
}

/// "x;y;z" of the axes that stand at every point; nothing in it where the point is missing.
std::array<double, 3> read_datum(const std::filesystem::path& file, const Layout& layout,
                                 std::string_view text, std::uint64_t place) {
  std::array<double, 3> stored{0, 0, quiet_nan};
  text = trimmed(text);
  if (text.empty()) return stored;
  bool more = true;
  const auto wrong = [&] {
    refuse_x3p(file, fmt::format("point {}: {} is not a point of such axes", place + 1,
                                 ra2d::quoted(text)));
  };
  std::string_view rest = text;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!layout.axes[a].absolute) continue;
    if (!more) wrong();
    const std::size_t end = std::min(rest.find(';'), rest.size());
    const auto value = to_number(trimmed(rest.substr(0, end)));
    if (!value || std::isinf(*value)) wrong();
    stored[a] = *value;
    more = end < rest.size();
    rest.remove_prefix(more ? end + 1 : end);
  }
  if (more) wrong();
  return stored;
}

void read_list(const std::filesystem::path& file, const Element& list, const Layout& layout,
               Collector& points) {
  const std::uint64_t all = layout.grid.points * layout.grid.profiles;
  std::uint64_t place = 0;
  for (const pugi::xml_node datum : list.node().children()) {
    if (!Element::is(datum, "Datum")) continue;
    if (place < all && points.wants(place))
      points.add(read_datum(file, layout, datum.child_value(), place));
    ++place;
  }
  if (place != all)
    refuse_x3p(file, fmt::format("{} by {} points by main.xml, and {} in its list",
                                 layout.grid.points, layout.grid.profiles, place));
}

/// The spacing of an axis that lists its places. They must be even, as those of a text.
double even_spacing(const std::filesystem::path& file, const Axis& axis,
                    const std::vector<double>& places) {
  if (places.size() < 2) return 0;
  const double step = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
  if (!(step > 0) || !std::isfinite(step))
    refuse_x3p(file, "the places along the axis do not increase");
  const double far = std::max(std::abs(places.front()), std::abs(places.back()));
  const double rounding = 4 * axis.precision * far + (axis.whole ? axis.increment : 0);
  for (std::size_t i = 1; i < places.size(); ++i)
    if (std::abs(places[i] - places[i - 1] - step) > evenness * step + std::min(rounding, step / 4))
      refuse_x3p(file,
                 fmt::format("point {} of the profile is at {:.10g} m and the next at {:.10g} "
                             "m, expected an even spacing of {:.10g} m",
                             i, places[i - 1], places[i], step));
  return step;
}

/// main.xml, of which the checksum is right.
std::string read_main(const std::filesystem::path& file, const ZipArchive& archive) {
  if (!archive.size_of("main.xml"))
    refuse_x3p(file, "there is no main.xml in it: another kind of zip archive?");
  std::string text = archive.read("main.xml", largest_main);
  Md5 md5;
  md5.add(text.data(), text.size());
  const std::string stored = archive.read("md5checksum.hex", largest_checksum);
  require_checksum(file, md5.hex(), trimmed(stored).substr(0, 32), "main.xml");
  if (std::count_if(text.begin(), text.end(), [](char c) { return c == '<' || c == '='; }) >
      most_marks)
    refuse_x3p(
        file, fmt::format("main.xml has more than {} tags: save the points in binary", most_marks));
  return text;
}

Element parse(const std::filesystem::path& file, std::string& text, pugi::xml_document& document) {
  const auto parsed = document.load_buffer_inplace(text.data(), text.size(),
                                                   pugi::parse_default | pugi::parse_doctype);
  if (!parsed)
    refuse_x3p(file, fmt::format("main.xml, byte {}: {}", parsed.offset, parsed.description()));
  for (const pugi::xml_node node : document.children())
    if (node.type() == pugi::node_doctype)
      refuse_x3p(file, "main.xml has a document type, which X3P knows not: entities are not read");
  const pugi::xml_node root = document.document_element();
  if (!Element::is(root, "ISO5436_2"))
    refuse_x3p(file, fmt::format("main.xml begins with {}, expected ISO5436_2",
                                 ra2d::quoted(root.name())));
  return {file, root, root.name()};
}

/// An X3P of which the checksum of main.xml is right. Its elements point into it.
struct OpenX3p {
  ZipArchive archive;
  std::string text;
  pugi::xml_document document;
  Element root;
  Layout layout;

  explicit OpenX3p(const std::filesystem::path& file)
      : archive(file),
        text(read_main(file, archive)),
        root(parse(file, text, document)),
        layout(read_layout(file, root)) {}
  bool has_y() const { return root.need("Record1").need("Axes").child("CY").stands(); }
  void read(const std::filesystem::path& file, const GridLine& line, Collector& points) const {
    const Element record3 = root.need("Record3"), link = record3.child("DataLink");
    if (link.stands())
      read_heights_file(file, archive, link, layout, line, points);
    else
      read_list(file, record3.need("DataList"), layout, points);
  }
};

}  // namespace

Profile read_profile_x3p(const std::filesystem::path& file, const ProfileQuery& query) {
  const OpenX3p x3p(file);
  const GridLine line = choose_line(file, "X3P", x3p.layout.grid, query);
  Collector points(file, x3p.layout, line);
  if (!points.along().absolute && line.along_y && !x3p.has_y())
    refuse_x3p(file, "main.xml has no CY, along which the column would run");
  x3p.read(file, line, points);

  Profile profile;
  profile.spacing =
      points.along().absolute ? even_spacing(file, points.along(), points.places) : line.spacing;
  profile.heights = std::move(points.heights);
  for (std::size_t i = 0; i < profile.heights.size() && profile.first_missing.empty(); ++i)
    if (std::isnan(profile.heights[i]))
      profile.first_missing =
          fmt::format("{}: point {}", file.string(), line.first + i * line.stride + 1);
  require_heights(file, profile);
  return profile;
}

HeightMap read_map_x3p(const std::filesystem::path& file, const MapQuery& query) {
  const OpenX3p x3p(file);
  HeightMap map;
  const GridLine line = whole_grid(file, "X3P", x3p.layout.grid, query, map);
  if (!x3p.has_y()) refuse_x3p(file, "main.xml has no CY, along which rows would follow");
  for (const std::size_t axis : {0, 1})
    if (x3p.layout.axes[axis].absolute)
      refuse_x3p(file, fmt::format("{} stands at every point, which is not read of a map: save it "
                                   "with even increments",
                                   axis == 0 ? "x" : "y"));
  Collector points(file, x3p.layout, line);
  x3p.read(file, line, points);
  map.heights = std::move(points.heights);
  return map;
}

}  // namespace ra2d
