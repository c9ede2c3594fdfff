// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/saved_state.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

namespace ra2d {
namespace {

bool is_within(std::int64_t value, std::int64_t low, std::int64_t high) {
  return low <= value && value <= high;
}

/// The state with its arrays where they were saved; what does not fit is said.
std::string bind(const SavedState& saved, const Extents& n, CarriedState& bound) {
  std::string fault;
  auto bytes = saved.arrays.begin();
  visit_arrays(bound, n, [&](const char* name, auto*& array, std::size_t count) {
    array = nullptr;
    if (!fault.empty()) return;
    if (bytes == saved.arrays.end() || bytes->size() != count * sizeof(*array)) {
      fault = std::string("'") + name + "' is of another length";
      return;
    }
    // only read; vectors of bytes stand where any number may
    array = reinterpret_cast<std::remove_reference_t<decltype(array)>>(
        const_cast<std::byte*>(bytes->data()));  // NOLINT(cppcoreguidelines-pro-type-const-cast)
    ++bytes;
  });
  if (fault.empty() && bytes != saved.arrays.end()) fault = "there are more arrays than known";
  return fault;
}

/// Whether a bool that may come from a file is true or false, and no other byte.
bool is_truth(const bool& value) {
  unsigned char byte;
  std::memcpy(&byte, &value, 1);
  return byte <= 1;
}

bool has_sound_shocks(const CarriedState& s, const Extents& n) {
  std::vector<std::int64_t> serials;
  for (int i = 0; i < s.shocks.open_count; ++i) {
    const OpenShock& open = s.shocks.open[i];
    if (!is_within(open.serial, 0, s.shocks.begun - 1) || !is_within(open.start, 0, open.last) ||
        open.last > s.step)
      return false;
    serials.push_back(open.serial);
  }
  std::sort(serials.begin(), serials.end());
  if (std::adjacent_find(serials.begin(), serials.end()) != serials.end()) return false;
  // the next step that contact can be recorded at: implicit forms record it at a step's end
  const std::int64_t next = n.active > 0 ? s.step + 1 : s.step;
  for (int r = 0; r < s.shocks.run_count; ++r) {
    const ContactRun& run = s.shocks.runs[r];
    if (!is_within(run.first, r > 0 ? s.shocks.runs[r - 1].last + 1 : 0, run.last) ||
        run.last >= n.nodes)
      return false;
    if (s.shocks.runs_step >= next - 1 && !is_within(run.shock, 0, s.shocks.open_count - 1))
      return false;
  }
  return true;
}

}  // namespace

std::string fault_of(const SavedState& saved, const Extents& n, std::int64_t steps,
                     std::int64_t samples) {
  CarriedState s = saved.values;
  if (std::string fault = bind(saved, n, s); !fault.empty()) return fault;
  if (s.status != Status::running) return "it is of a run that has ended";
  if (!is_truth(saved.values.modal.begun) || !is_truth(saved.values.sampling.pending) ||
      !is_truth(saved.values.control.contact_begins) ||
      !is_truth(saved.values.begin.knows_forces) || !is_truth(saved.values.begin.knows_rates))
    return "it is no state";
  if (!is_within(s.step, 0, steps)) return "its step is beyond the run";
  if (!is_within(s.sampling.next, 0, samples)) return "its next sample is beyond the run";
  if (!is_within(s.shocks.run_count, 0, n.runs()) ||
      !is_within(s.shocks.open_count, 0, 2 * n.runs()) || s.shocks.begun < 0 ||
      s.shocks.runs_step > s.step || !has_sound_shocks(s, n))
    return "its shocks do not fit together";
  if (!is_within(s.latest_contact.nodes, 0, n.nodes)) return "its nodes in contact are too many";
  for (const int node : s.latest_contact.pair)
    if (!is_within(node, 0, n.nodes - 1)) return "its nodes in contact are none of the slider's";
  if (!is_within(s.contacts.count, 0, n.contacts)) return "its closed nodes are too many";
  const int length = static_cast<int>(n.padded_row()), cells = n.row_nodes - (n.smooth ? 1 : 0);
  for (int e = 0; e < s.contacts.count; ++e) {
    const int node = s.contacts.nodes[e];
    if (!is_within(node, e > 0 ? s.contacts.nodes[e - 1] + 1 : 0, n.nodes - 1) ||
        node % length >= cells)
      return "its closed nodes do not ascend";
  }
  if (!is_within(s.begin.count, 0, n.contacts)) return "its cells with force are too many";
  if (!is_within(s.control.shape_terms, 1, 4)) return "its number of terms is none";
  if (!is_within(s.control.raised, 0, n.higher_orders) ||
      !(s.control.used_share >= 0 && s.control.used_share <= 1))
    return "its order is none";
  if (!is_within(s.control.flight_level, 0, 60)) return "its flight is too long";
  if (!(s.control.series_scale >= 0) || !(s.control.expected_onset >= 0) ||
      !(s.control.expected_release >= 0))
    return "its next step is none";
  return {};
}

}  // namespace ra2d
