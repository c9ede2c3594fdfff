// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <complex>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "host/run/checkpoint.hpp"
#include "host/store/sealed_file.hpp"

namespace ra2d {
namespace {

constexpr const char* kind = "ra2d checkpoint";
constexpr std::uint32_t format = 4;

// One list of members serves both ways: a Packer appends what it is shown, an Unpacker fills it.

template <class T>
concept Plain =
    std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::complex<double>>;

class Packer {
 public:
  template <class... T>
  void operator()(T&... values) {
    (put(values), ...);
  }
  std::string bytes;

 private:
  template <class T>
  requires(Plain<T> || std::is_same_v<T, OpenShock> ||
           std::is_same_v<T, CarriedState>) void put(const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::string& text) {
    put(text.size());
    bytes += text;
  }
  template <class T>
  void put(std::vector<T>& list) {
    put(list.size());
    for (T& element : list) one(element);
  }
  template <class T>
  void put(T& value) requires requires {
    visit_members(value, *this);
  }
  { visit_members(value, *this); }
  void one(std::byte value) { bytes += static_cast<char>(value); }
  template <class T>
  void one(T& value) {
    put(value);
  }
};

class Unpacker {
 public:
  explicit Unpacker(const std::string& bytes) : rest_{bytes} {}
  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  void end() const {
    if (!rest_.empty()) throw CorruptFile("longer than what it holds");
  }

 private:
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw CorruptFile("shorter than what it holds");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  template <class T>
  requires(Plain<T> || std::is_same_v<T, OpenShock> ||
           std::is_same_v<T, CarriedState>) void get(T& value) {
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
  }
  void get(bool& value) { value = take(1)[0] != 0; }
  std::size_t size() {
    std::size_t count = 0;
    get(count);
    if (count > rest_.size())
      throw CorruptFile("shorter than what it holds");  // a byte each at least
    return count;
  }
  void get(std::string& text) {
    const std::size_t count = size();
    text = take(count);
  }
  void get(std::vector<std::byte>& list) {
    const std::string_view bytes = take(size());
    list.resize(bytes.size());
    if (!bytes.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
  }
  template <class T>
  void get(std::vector<T>& list) {
    const std::size_t count = size();
    list.clear();
    for (std::size_t i = 0; i < count; ++i) get(list.emplace_back());
  }
  template <class T>
  void get(T& value) requires requires {
    visit_members(value, *this);
  }
  { visit_members(value, *this); }

  std::string_view rest_;
};

template <class Archive>
void visit_members(Identity& i, Archive& archive) {
  archive(i.program, i.arithmetic, i.backend, i.key, i.scene);
}
template <class Archive>
void visit_members(SavedState& s, Archive& archive) {
  archive(s.values, s.arrays, s.node_capacity);
}
template <class Archive>
void visit_members(Snapshot& s, Archive& archive) {
  archive(s.status, s.step, s.resonator_u, s.resonator_v, s.slider_u, s.slider_v,
          s.resonator_square, s.contact_steps, s.most_nodes, s.evaluated, s.shocks_begun, s.energy,
          s.energy_limit, s.sliding_work, s.force_work, s.open_shocks, s.steps_made);
}
template <class Archive>
void visit_members(EnergyAccount& account, Archive& archive) {
  account.visit(archive);
}
template <class Archive>
void visit_members(LogHistogram& histogram, Archive& archive) {
  histogram.visit(archive);
}
template <class Archive>
void visit_members(Accounts& a, Archive& archive) {
  archive(a.samples, a.begin, a.now, a.energy, a.durations, a.forces, a.march_seconds);
}
template <class Archive>
void visit_members(RunWatch::Seen& s, Archive& archive) {
  archive(s.samples, s.level.filled, s.level.squares, s.level.shocks, s.tone.block, s.tone.rows,
          s.tone.averages);
}
template <class Archive>
void visit_members(Segment& s, Archive& archive) {
  archive(s.bytes, s.xxh3_128, s.samples, s.shocks);
}

/// The sections of a file, each with its members.
template <class Visit>
void visit_sections(Checkpoint& c, Visit&& visit) {
  visit("identity", c.identity);
  visit("state", c.state);
  visit("accounts", c.accounts);
  visit("seen", c.seen);
  visit("time", c.wall_seconds);
  visit("outputs", c.segments);
}

}  // namespace

std::string bytes_of(const Checkpoint& checkpoint) {
  Checkpoint copy = checkpoint;
  // addresses mean nothing, and would make each file another
  Extents none;
  none.flight_levels = 1;
  visit_arrays(copy.state.values, none,
               [](const char*, auto*& array, std::size_t) { array = nullptr; });
  std::vector<Section> sections;
  visit_sections(copy, [&](const char* name, auto& members) {
    Packer pack;
    pack(members);
    sections.push_back({name, std::move(pack.bytes)});
  });
  return seal(kind, format, sections);
}

Checkpoint checkpoint_of(const std::string& bytes) {
  const std::vector<Section> sections = unseal(kind, format, bytes);
  Checkpoint checkpoint;
  auto section = sections.begin();
  visit_sections(checkpoint, [&](const char* name, auto& members) {
    if (section == sections.end() || section->name != name)
      throw CorruptFile(fmt::format("without its section '{}'", name));
    Unpacker unpack(section->bytes);
    unpack(members);
    unpack.end();
    ++section;
  });
  return checkpoint;
}

}  // namespace ra2d
