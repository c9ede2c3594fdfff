// SPDX-License-Identifier: BSD-3-Clause
#include "tests/warp/scene_on_lanes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <new>
#include <type_traits>

#include "host/device/fill.hpp"
#include "host/device/layout.hpp"

namespace ra2d::test {
namespace {

int packs_for(const Model& model, int width) {
  const auto modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
  return (modes + width - 1) / width;
}

}  // namespace

SceneOnLanes::SceneOnLanes(const Model& model, const ModalStart& start, int least_packs, int width)
    : packs_{std::max(packs_for(model, width), least_packs)} {
  const PatchSeries series = choose_series(model, width);
  n_ = extents_of(model, series, packs_ * width, width, Capacity());
  // padding between members is compared, too
  std::memset(static_cast<void*>(&state_), 0, sizeof state_);
  new (&state_) SceneState();
  named_ = {{"the tables", &tables_, sizeof tables_, false},
            {"the state", &state_, sizeof state_, true}};
  const auto provide = [&](auto& part) {
    visit_arrays(part, n_, [&](const char* name, auto*& array, std::size_t count) {
      using Value = std::remove_const_t<std::remove_reference_t<decltype(*array)>>;
      arrays_.emplace_back((count * sizeof(Value) + sizeof(double) - 1) / sizeof(double) + 1, 0.0);
      array = reinterpret_cast<Value*>(arrays_.back().data());
      const bool writable = !std::is_same_v<std::remove_reference_t<decltype(part)>, SceneTables>;
      named_.push_back({name, array, count * sizeof(Value), writable});
    });
  };
  provide(tables_);
  provide(state_.carried);
  provide(state_.marks);
  provide(state_.caches);
  provide(state_.work);
  provide(state_.out);
  const HostCopy here;
  fill(tables_, model, series, n_, here);
  fill(state_, model, start, n_, here);
}

void SceneOnLanes::round_numbers() {
  const auto round = [](const char*, auto* array, std::size_t count) {
    using Value = std::remove_const_t<std::remove_reference_t<decltype(*array)>>;
    if constexpr (std::is_same_v<Value, double>) {
      auto* const values = const_cast<double*>(array);
      // faces and shapes are many numbers: the fewer digits, the less likely is one whose last bit
      // decides how it is rounded
      const int dropped = count > 2000 ? 29 : 17;
      for (std::size_t i = 0; i < count; ++i) {
        const auto bits =
            std::bit_cast<std::uint64_t>(values[i]) + (std::uint64_t{1} << (dropped - 1));
        values[i] = std::bit_cast<double>(bits >> dropped << dropped);
      }
    }
  };
  visit_arrays(tables_, n_, round);
  visit_arrays(state_.carried, n_, round);
}

std::string SceneOnLanes::differs_from(const SceneOnLanes& other) const {
  CarriedState a, b;
  std::memcpy(static_cast<void*>(&a), &state_.carried, sizeof a);
  std::memcpy(static_cast<void*>(&b), &other.state_.carried, sizeof b);
  std::vector<const void*> of_other;
  const auto note = [&](const char*, auto*& array, std::size_t) {
    of_other.push_back(array);
    array = nullptr;
  };
  RecordBuffers given = state_.out, others_given = other.state_.out;
  visit_arrays(b, n_, note);
  visit_arrays(others_given, n_, note);
  std::size_t at = 0;
  std::string differs;
  const auto compare = [&](const char* name, auto*& array, std::size_t count) {
    const bool same = std::memcmp(array, of_other[at++], count * sizeof(*array)) == 0;
    if (!same) differs += fmt::format(" {}", name);
    array = nullptr;
  };
  visit_arrays(a, n_, compare);
  visit_arrays(given, n_, compare);
  if (std::memcmp(&a, &b, sizeof a) != 0) differs += " the carried values";
  if (std::memcmp(&given, &others_given, sizeof given) != 0) differs += " what is handed out";
  return differs;
}

}  // namespace ra2d::test
