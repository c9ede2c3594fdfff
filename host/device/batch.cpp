// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/batch.hpp"

#include <fmt/format.h>

#include <Kokkos_Core.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "host/device/arena.hpp"
#include "host/device/backend.hpp"
#include "host/device/fill.hpp"
#include "host/device/launch.hpp"
#include "host/errors.hpp"
#include "host/interruption.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int width = LanesOf<Space>::width;

int packs_of(const Model& model, int least) {
  const int modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
  if (modes > most_modes)
    throw RequestError(
        fmt::format("{} modes in both bodies together, at the most {} can be marched: lower "
                    "max_frequency or modes",
                    modes, most_modes));
  return compiled_packs(std::max({least, 1, (modes + width - 1) / width}));
}

/// A scene in its slot. On a CPU its tables and state are marched where they stand here, on a GPU in
/// the batch's arrays of them.
struct Slot {
  Model model;
  Room room;
  int packs = 0;
  Extents extents;
  Arena arena;
  SceneTables tables;
  SceneState state;
  double seconds = 0;

  Slot(const Model& model_, const ModalStart& start, int packs_, const Room& room_, Arena memory)
      : model{model_}, room{room_}, packs{packs_}, arena{std::move(memory)} {
    provide();
    fill(state, model, start, extents, arena.on_host_copy());
    upload();
  }

  /// The same scene at the same place, with room for more nodes.
  void grow(int nodes) {
    const SavedState kept = save();
    const HandOut handed = static_cast<const HandOut&>(state);
    const Arrays rows = copy_out(handed);
    room.nodes = nodes;
    arena = Arena();  // from here on beside the room of the batch: what is under way comes first
    tables = SceneTables();
    state = SceneState();
    provide();
    fill(state, model, ModalStart(), extents, arena.on_host_copy());
    take(kept);
    copy_in(static_cast<HandOut&>(state), handed, rows);
    upload();
  }

  SavedState save() const {
    const CarriedState& carried = state;
    return {carried, copy_out(carried), room.nodes};
  }
  void restore(const SavedState& saved) {
    Room saved_room = room;
    saved_room.nodes = std::max(1, saved.room);
    const Extents n =
        extents_of(model, choose_series(model, width), packs * width, width, saved_room);
    if (const std::string fault = fault_of(saved, n, model.steps, model.samples); !fault.empty())
      throw std::invalid_argument(fault);
    take(saved);
  }
  void take(const SavedState& saved) {
    if (saved.room > room.nodes) grow(saved.room);
    copy_in(static_cast<CarriedState&>(state), saved.values, saved.arrays);
  }

  /// After a launch: what stopped for want of room goes on with twice as much.
  void make_room() {
    if (state.status != Status::crowded) return;
    grow(2 * std::max(extents.pressed, extents.closed));
    state.status = Status::running;
  }

  void upload() {
    const auto up = [&](const char*, const auto* array, std::size_t count) {
      arena.upload(array, count);
    };
    visit_arrays(tables, extents, up);
    visit_arrays(static_cast<CarriedState&>(state), extents, up);
    arena.upload(state.node_window, static_cast<std::size_t>(extents.nodes));
    if (extents.pressed > 0)
      arena.upload(state.pressed_place, static_cast<std::size_t>(extents.nodes));
  }

 private:
  using Arrays = std::vector<std::vector<std::byte>>;

  template <class Part>
  Arrays copy_out(Part part) const {
    Arrays out;
    visit_arrays(part, extents, [&](const char*, const auto* array, std::size_t count) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(arena.fetch(array, count));
      out.emplace_back(bytes, bytes + count * sizeof(*array));
    });
    return out;
  }
  /// Everything of a part but its addresses, which stay ours.
  template <class Part>
  void copy_in(Part& part, const Part& values, const Arrays& arrays) const {
    auto bytes = arrays.begin();
    std::vector<void*> addresses;
    visit_arrays(part, extents, [&](const char* name, auto* array, std::size_t count) {
      if (bytes == arrays.end() || bytes->size() > count * sizeof(*array))
        throw std::logic_error(std::string("a saved state of another scene: ") + name);
      std::memcpy(arena.on_host_copy()(array), bytes->data(), bytes->size());
      arena.upload(array, count);
      ++bytes;
      addresses.push_back(array);
    });
    part = values;
    auto address = addresses.begin();
    visit_arrays(part, extents, [&](const char*, auto*& array, std::size_t) {
      array = static_cast<std::remove_reference_t<decltype(array)>>(*address++);
    });
  }

  void provide() {
    const PatchSeries series = choose_series(model, width);
    extents = extents_of(model, series, packs * width, width, room);
    arena.provide(tables, state, extents);
    fill(tables, model, series, extents, arena.on_host_copy());
    if constexpr (on_host) tables.interrupted = interruption_flag();
  }
};

}  // namespace

struct Batch::Impl {
  BatchOptions options;
  std::atomic<std::int64_t> left = 0;  // of options.memory; outlives the slots
  std::vector<std::optional<Slot>> slots;
#if defined(KOKKOS_ENABLE_CUDA)
  TablesView tables;
  StatesView states;
  TargetsView targets;
#endif

  Slot& at(int slot) { return *slots.at(static_cast<std::size_t>(slot)); }
  std::vector<int> running() const {
    std::vector<int> list;
    for (std::size_t i = 0; i < slots.size(); ++i)
      if (slots[i] && slots[i]->state.status == Status::running)
        list.push_back(static_cast<int>(i));
    return list;
  }

  void launch(const std::vector<int>& list, const std::vector<std::int64_t>& goals,
              const std::function<void(int)>& marched);
};

#if defined(KOKKOS_ENABLE_CUDA)

/// The scenes of each form and number of packs together, side by side with the others.
void Batch::Impl::launch(const std::vector<int>& list, const std::vector<std::int64_t>& goals,
                         const std::function<void(int)>& marched) {
  const auto tables_host = Kokkos::create_mirror_view(tables);
  const auto states_host = Kokkos::create_mirror_view(states);
  const auto targets_host = Kokkos::create_mirror_view(targets);
  std::map<std::pair<Form, int>, std::vector<int>> groups;
  for (const int slot : list) {
    tables_host(slot) = at(slot).tables;
    states_host(slot) = at(slot).state;
    targets_host(slot) = goals[slot];
    groups[{at(slot).tables.form, at(slot).packs}].push_back(slot);
  }
  Kokkos::deep_copy(tables, tables_host);
  Kokkos::deep_copy(states, states_host);
  Kokkos::deep_copy(targets, targets_host);
  const auto begin = Clock::now();
  const std::vector<Space> streams =
      Kokkos::Experimental::partition_space(Space(), std::vector<int>(groups.size(), 1));
  std::size_t stream = 0;
  std::vector<ScenesView> lists;  // until the launches are done
  for (const auto& [kind, members] : groups) {
    const ScenesView scenes("ra2d::scenes", members.size());
    const auto scenes_host = Kokkos::create_mirror_view(scenes);
    std::copy(members.begin(), members.end(), scenes_host.data());
    Kokkos::deep_copy(scenes, scenes_host);
    lists.push_back(scenes);
    launch_march(streams[stream++], kind.first, kind.second, tables, states, scenes, targets);
  }
  Kokkos::fence();
  const double took = std::chrono::duration<double>(Clock::now() - begin).count();
  Kokkos::deep_copy(states_host, states);
  for (const int slot : list) {
    at(slot).state = states_host(slot);
    at(slot).seconds = took;
  }
  side_by_side(static_cast<int>(list.size()), [&](int i) {
    const int slot = list[static_cast<std::size_t>(i)];
    at(slot).make_room();
    if (marched) marched(slot);
  });
}

#else

/// Each scene on one thread.
void Batch::Impl::launch(const std::vector<int>& list, const std::vector<std::int64_t>& goals,
                         const std::function<void(int)>& marched) {
  side_by_side(static_cast<int>(list.size()), [&](int i) {
    const int slot = list[static_cast<std::size_t>(i)];
    Slot& scene = at(slot);
    const auto begin = Clock::now();
    march_of(scene.tables.form, scene.packs)(scene.tables, scene.state, goals[slot]);
    scene.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    scene.make_room();
    if (marched) marched(slot);
  });
}

#endif

Batch::Batch(int slots, const BatchOptions& options) : impl_{std::make_unique<Impl>()} {
  impl_->options = options;
  impl_->left = static_cast<std::int64_t>(options.memory);
  impl_->slots.resize(static_cast<std::size_t>(slots));
#if defined(KOKKOS_ENABLE_CUDA)
  impl_->tables = TablesView("ra2d::tables", slots);
  impl_->states = StatesView("ra2d::states", slots);
  impl_->targets = TargetsView("ra2d::targets", slots);
#endif
}

Batch::Batch(const std::vector<Model>& models, const std::vector<ModalStart>& starts,
             const BatchOptions& options)
    : Batch(static_cast<int>(models.size()), options) {
  for (std::size_t i = 0; i < models.size(); ++i) put(static_cast<int>(i), models[i], starts[i]);
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;

int Batch::slots() const { return static_cast<int>(impl_->slots.size()); }

void Batch::put(int slot, const Model& model, const ModalStart& start) {
  std::optional<Slot>& place = impl_->slots.at(static_cast<std::size_t>(slot));
  place.reset();
  place.emplace(model, start, packs_of(model, impl_->options.least_packs), impl_->options.room,
                impl_->options.memory > 0 ? Arena(impl_->left) : Arena());
}

void Batch::empty(int slot) { impl_->slots.at(static_cast<std::size_t>(slot)).reset(); }

void Batch::march(const std::vector<std::int64_t>& targets,
                  const std::function<void(int)>& marched) {
  if (const std::vector<int> list = impl_->running(); !list.empty())
    impl_->launch(list, targets, marched);
}

void Batch::march(std::int64_t target) {
  march(std::vector<std::int64_t>(impl_->slots.size(), target));
}

double Batch::seconds(int slot) const { return impl_->at(slot).seconds; }

std::size_t Batch::bytes() const {
  std::size_t sum = 0;
  for (const std::optional<Slot>& slot : impl_->slots) sum += slot ? slot->arena.bytes() : 0;
  return sum;
}

Drained Batch::drain(int slot) {
  Slot& scene = impl_->at(slot);
  SceneState& s = scene.state;
  Drained out;
  out.lanes = scene.extents.lanes;
  out.samples = s.sample_count;
  const std::size_t values =
      static_cast<std::size_t>(s.sample_count) * sample::row(scene.extents.lanes);
  const double* const rows = scene.arena.fetch(s.sample_rows, values);
  out.sample_rows.assign(rows, rows + values);
  const ShockRow* const shocks =
      scene.arena.fetch(s.shock_rows, static_cast<std::size_t>(s.shock_count));
  out.shocks.assign(shocks, shocks + s.shock_count);
  s.sample_count = s.shock_count = 0;
  return out;
}

Snapshot Batch::snapshot(int slot) const {
  const Slot& scene = impl_->at(slot);
  const SceneState& s = scene.state;
  const std::size_t modes2 = scene.model.resonator.modes.size(),
                    modes1 = scene.model.slider.modes.size();
  const auto take = [&](const double* array, std::size_t lane, std::size_t count) {
    const double* const from =
        scene.arena.fetch(array, static_cast<std::size_t>(scene.extents.lanes)) + lane;
    return std::vector<double>(from, from + count);
  };
  Snapshot out;
  out.status = s.status;
  out.step = s.step;
  out.strides = scene.extents.adaptive() ? s.strides : s.step;
  out.resonator_u = take(s.u, 0, modes2);
  out.resonator_v = take(s.v, 0, modes2);
  out.slider_u = take(s.u, modes2, modes1);
  out.slider_v = take(s.v, modes2, modes1);
  out.resonator_square = take(s.square, 0, modes2);
  const std::vector<double> part = take(s.square_part, 0, modes2);
  for (std::size_t k = 0; k < modes2; ++k) out.resonator_square[k] += part[k];
  out.contact_steps = s.contact_steps;
  out.most_nodes = s.most_nodes;
  out.evaluated = s.evaluated;
  out.shocks_begun = s.shocks_begun;
  out.energy = s.energy;
  out.energy_limit = s.energy_limit;
  const double* const bend_part = scene.arena.fetch(s.bend_part, static_cast<std::size_t>(width));
  double bend = 0;
  for (int lane = 0; lane < width; ++lane) bend += bend_part[lane];
  out.sliding_work = s.sliding_work + scene.model.advance * (s.climb_part + bend);
  out.force_work = s.force_work + s.force_part;
  const OpenShock* const open = scene.arena.fetch(s.open, static_cast<std::size_t>(s.open_count));
  out.open_shocks.assign(open, open + s.open_count);
  return out;
}

SavedState Batch::save(int slot) const { return impl_->at(slot).save(); }

void Batch::restore(int slot, const SavedState& saved) { impl_->at(slot).restore(saved); }

}  // namespace ra2d
