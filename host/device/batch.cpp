// SPDX-License-Identifier: BSD-3-Clause
#include "host/device/batch.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "host/base/errors.hpp"
#include "host/device/backend.hpp"
#include "host/device/device.hpp"
#include "host/device/fill.hpp"
#include "host/device/layout.hpp"
#include "host/device/marches.hpp"
#include "host/device/memory.hpp"
#include "host/device/scene_memory.hpp"
#include "host/scene/schemes.hpp"
#include "host/system/interruption.hpp"
#include "kernels/limits.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;

/// Processor time of this thread [s].
double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

TeamShape shape_of(const Model& model, int least_packs) {
  const int modes = static_cast<int>(model.resonator.modes.size() + model.slider.modes.size());
  if (modes > most_modes)
    throw RequestError(
        fmt::format("{} modes in both bodies together, at the most {} can be marched: lower "
                    "max_frequency or modes",
                    modes, most_modes));
  // of many nodes the bounds of a footprint leave far fewer to be looked at, with few modes, too
  constexpr int many_nodes = 4096;
  if (model.is_areal && model.nodes() >= many_nodes)
    least_packs = std::max(least_packs, least_footprint_packs);
  return compiled_shape(form_of(model.scene), std::max(modes, least_packs * backend_lanes()));
}

}  // namespace

/// A scene in its slot. On a CPU its tables and state are marched where they stand here, on a
/// device in the batch's arrays of them.
struct BatchSlot {
  Model model;
  Capacity capacity;
  TeamShape shape;
  Extents extents;
  SceneMemory memory;
  SceneTables tables;
  SceneState state;
  double seconds = 0, processor = 0;  // of the latest launch

  BatchSlot(const Model& model_, const ModalStart& start, const TeamShape& shape_,
            const Capacity& capacity_, BatchMemory& batch)
      : model{model_}, capacity{capacity_}, shape{shape_}, memory{batch} {
    // to grow later takes all tables a second time: a share of a map's nodes at once
    if (model.is_areal)
      capacity.nodes = std::max({capacity.nodes, std::min(model.nodes() / 128, 256),
                                 std::min(model.nodes() / 2048, 2048)});
    find_extents();
    memory.provide(state.out, extents);
    provide(start, false);
  }

  /// Takes memory for more nodes, beyond the limit of the batch: a scene that has begun comes
  /// first. The scene stays where it is, and its record, too. Where it throws std::bad_alloc, all
  /// is as it was.
  void grow(int nodes) {
    const SavedState kept = save();
    const Capacity capacity_before = capacity;
    const Extents extents_before = extents;
    const SceneTables tables_before = tables;
    const SceneState state_before = state;
    try {
      capacity.nodes = nodes;
      find_extents();
      tables = SceneTables();
      state = SceneState();
      state.out = state_before.out;
      provide(ModalStart(), true);
    } catch (const std::bad_alloc&) {
      capacity = capacity_before;
      extents = extents_before;
      tables = tables_before;
      state = state_before;
      throw;
    }
    take(kept);
  }

  SavedState save() const {
    SavedState saved{state.carried, {}, capacity.nodes};
    visit_arrays(saved.values, extents, [&](const char*, auto* array, std::size_t count) {
      auto& to = saved.arrays.emplace_back(count * sizeof(*array));
      memory.read(to.data(), array, to.size());
    });
    memory.wait();
    return saved;
  }
  void restore(const SavedState& saved) {
    Capacity saved_capacity = capacity;
    saved_capacity.nodes = std::max(1, saved.node_capacity);
    const Extents n = extents_for(saved_capacity);
    if (const std::string fault = fault_of(saved, n, model.steps, model.samples); !fault.empty())
      throw std::invalid_argument(fault);
    take(saved);
  }
  /// Everything of a saved state but its addresses, which stay ours.
  void take(const SavedState& saved) {
    if (saved.node_capacity > capacity.nodes) grow(saved.node_capacity);
    CarriedState ours = state.carried;
    auto bytes = saved.arrays.begin();
    std::vector<void*> addresses;
    visit_arrays(ours, extents, [&](const char* name, auto* array, std::size_t count) {
      if (bytes == saved.arrays.end() || bytes->size() > count * sizeof(*array))
        throw std::logic_error(std::string("a saved state of another scene: ") + name);
      memory.write(array, bytes->data(), bytes->size());
      ++bytes;
      addresses.push_back(array);
    });
    ours = saved.values;
    auto address = addresses.begin();
    visit_arrays(ours, extents, [&](const char*, auto*& array, std::size_t) {
      array = static_cast<std::remove_reference_t<decltype(array)>>(*address++);
    });
    memory.wait();
    state.carried = ours;
    show(saved);
  }

  /// After a launch: a scene that stopped because its nodes were too many for its memory goes on
  /// with twice as much. Where there is no memory for that, the scene has come to its end.
  void grow_if_crowded() {
    if (state.carried.status != Status::crowded) return;
    const int listed = extents.rows > 0 ? extents.listed : 0;
    if (listed == most_areal_nodes) return;
    try {
      grow(2 * std::max({extents.active, extents.contacts, listed}));
      state.carried.status = Status::running;
    } catch (const std::bad_alloc&) {
    }
  }

 private:
  Extents extents_for(const Capacity& wanted) const {
    return extents_of(model, choose_series(model, shape.width), shape.modes(), shape.width, wanted);
  }
  void find_extents() { extents = extents_for(capacity); }

  void provide(const ModalStart& start, bool beyond_limit) {
    memory.provide(tables, state, extents, beyond_limit, [&](const HostCopy& copy) {
      fill(tables, model, choose_series(model, shape.width), extents, copy);
      fill(state, model, start, extents, copy);
    });
    if (memory.on_host()) tables.interrupted = interruption_flag();
  }

  /// Sets what a march publishes at its end, for a saved state.
  void show(const SavedState& saved) {
    auto bytes = saved.arrays.begin();
    CarriedState carried;
    visit_arrays(carried, extents, [&](const char* array, auto*, std::size_t) {
      const std::string_view name = array;
      const auto put = [&](auto* to) { std::memcpy(to, bytes->data(), bytes->size()); };
      if (name == "u") put(state.out.now.u);
      if (name == "v") put(state.out.now.v);
      if (name == "square") put(state.out.now.square);
      if (name == "square_part") put(state.out.now.square_part);
      if (name == "deflection_work_part") put(state.out.now.deflection_work_part);
      if (name == "open") put(state.out.now.open);
      ++bytes;
    });
  }
};

struct Batch::Impl {
  BatchOptions options;
  BatchMemory memory;  // outlives the slots
  std::vector<std::optional<BatchSlot>> slots;

  // on a device: of each slot, there and here
  struct Launched {
    Block tables, states, targets, scenes, seconds;
    std::vector<SceneTables> tables_here;
    std::vector<SceneState> states_here;
    std::vector<int> scenes_here;
    std::vector<double> seconds_here;
    std::vector<std::unique_ptr<DeviceQueue>> queues;  // one a group of scenes
  };
  std::optional<Launched> launched;

  Impl(int count, const BatchOptions& options_)
      : options{options_}, memory{march_device(), options_.memory} {
    const auto n = static_cast<std::size_t>(count);
    slots.resize(n);
    if (memory.device == nullptr) return;
    const auto lend = [&](std::size_t bytes) { return memory.marched->lend(bytes * n); };
    launched.emplace(Launched{lend(sizeof(SceneTables)),
                              lend(sizeof(SceneState)),
                              lend(sizeof(std::int64_t)),
                              lend(sizeof(int)),
                              lend(sizeof(double)),
                              std::vector<SceneTables>(n),
                              std::vector<SceneState>(n),
                              {},
                              std::vector<double>(n),
                              {}});
    memory.queue->zero(launched->seconds.data(), n * sizeof(double));
  }

  BatchSlot& at(int slot) { return *slots.at(static_cast<std::size_t>(slot)); }
  std::vector<int> running() const {
    std::vector<int> list;
    for (std::size_t i = 0; i < slots.size(); ++i)
      if (slots[i] && slots[i]->state.carried.status == Status::running)
        list.push_back(static_cast<int>(i));
    return list;
  }

  void launch(const std::vector<int>& list, const std::vector<std::int64_t>& goals, double seconds,
              const std::function<void(int)>& marched);
  void launch_on_device(const std::vector<int>& list, const std::vector<std::int64_t>& goals,
                        double seconds);
};

void Batch::Impl::launch(const std::vector<int>& list, const std::vector<std::int64_t>& goals,
                         double seconds, const std::function<void(int)>& marched) {
  if (memory.device != nullptr) launch_on_device(list, goals, seconds);
  side_by_side(static_cast<int>(list.size()), [&](int i) {
    const int slot = list[static_cast<std::size_t>(i)];
    BatchSlot& scene = at(slot);
    if (memory.device == nullptr) {
      const auto begin = Clock::now();
      const double processor = thread_seconds();
      march_of(scene.tables.scheme.form, scene.shape)(scene.tables, scene.state,
                                                      goals[static_cast<std::size_t>(slot)]);
      scene.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
      scene.processor = thread_seconds() - processor;
    }
    scene.grow_if_crowded();
    if (marched) marched(slot);
  });
}

/// The scenes of each form and shape together, side by side with the others.
void Batch::Impl::launch_on_device(const std::vector<int>& list,
                                   const std::vector<std::int64_t>& goals, double seconds) {
  Launched& l = *launched;
  DeviceQueue& queue = *memory.queue;
  std::map<std::pair<Form, TeamShape>, std::vector<int>> groups;
  for (const int slot : list) {
    const auto i = static_cast<std::size_t>(slot);
    l.tables_here[i] = at(slot).tables;
    l.states_here[i] = at(slot).state;
    groups[{at(slot).tables.scheme.form, at(slot).shape}].push_back(slot);
  }
  l.scenes_here.clear();
  for (const auto& [kind, members] : groups)
    l.scenes_here.insert(l.scenes_here.end(), members.begin(), members.end());
  while (l.queues.size() < groups.size()) l.queues.push_back(memory.device->make_queue());
  const auto up = [&](const Block& there, const auto& here) {
    queue.upload(there.data(), here.data(), here.size() * sizeof(here[0]));
  };
  up(l.tables, l.tables_here);
  up(l.states, l.states_here);
  up(l.targets, goals);
  up(l.scenes, l.scenes_here);
  queue.wait();
  const int* scenes = reinterpret_cast<const int*>(l.scenes.data());
  std::exception_ptr fault;
  const auto attempt = [&](const auto& work) {
    try {
      work();
    } catch (...) {
      if (!fault) fault = std::current_exception();
    }
  };
  auto group_queue = l.queues.begin();
  for (const auto& [kind, members] : groups) {
    const auto count = static_cast<int>(members.size());
    attempt([&] {
      (*group_queue)
          ->march({kind.first, kind.second, count, scenes,
                   reinterpret_cast<const SceneTables*>(l.tables.data()),
                   reinterpret_cast<SceneState*>(l.states.data()),
                   reinterpret_cast<const std::int64_t*>(l.targets.data()), seconds,
                   reinterpret_cast<double*>(l.seconds.data())});
    });
    ++group_queue;
    scenes += count;
  }
  // whatever fails, nobody is to march in memory that is given back
  while (group_queue != l.queues.begin()) {
    --group_queue;
    attempt([&] { (*group_queue)->wait(); });
  }
  if (fault) std::rethrow_exception(fault);
  queue.fetch(l.states_here.data(), l.states.data(), l.states_here.size() * sizeof(SceneState));
  queue.fetch(l.seconds_here.data(), l.seconds.data(), l.seconds_here.size() * sizeof(double));
  queue.wait();
  for (const int slot : list) {
    at(slot).state = l.states_here[static_cast<std::size_t>(slot)];
    at(slot).seconds = at(slot).processor = l.seconds_here[static_cast<std::size_t>(slot)];
  }
}

Batch::Batch(int slots, const BatchOptions& options)
    : impl_{std::make_unique<Impl>(slots, options)} {}

Batch::Batch(const std::vector<Model>& models, const std::vector<ModalStart>& starts,
             const BatchOptions& options)
    : Batch(static_cast<int>(models.size()), options) {
  for (std::size_t i = 0; i < models.size(); ++i) put(static_cast<int>(i), models[i], starts[i]);
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;
Batch& Batch::operator=(Batch&&) noexcept = default;

int Batch::slots() const { return static_cast<int>(impl_->slots.size()); }

void Batch::put(int slot, const Model& model, const ModalStart& start) {
  std::optional<BatchSlot>& place = impl_->slots.at(static_cast<std::size_t>(slot));
  place.reset();
  place.emplace(model, start, shape_of(model, impl_->options.least_packs), impl_->options.capacity,
                impl_->memory);
}

void Batch::empty(int slot) { impl_->slots.at(static_cast<std::size_t>(slot)).reset(); }

void Batch::march(const std::vector<std::int64_t>& targets, double seconds,
                  const std::function<void(int)>& marched) {
  if (const std::vector<int> list = impl_->running(); !list.empty())
    impl_->launch(list, targets, seconds, marched);
}

void Batch::march(std::int64_t target) {
  march(std::vector<std::int64_t>(impl_->slots.size(), target));
}

double Batch::seconds(int slot) const { return impl_->at(slot).seconds; }
double Batch::processor_seconds(int slot) const { return impl_->at(slot).processor; }

std::size_t Batch::bytes() const {
  std::size_t sum = impl_->memory.shared.bytes();
  for (const std::optional<BatchSlot>& slot : impl_->slots) sum += slot ? slot->memory.bytes() : 0;
  return sum;
}

Drained Batch::drain(int slot) {
  BatchSlot& scene = impl_->at(slot);
  SceneState& s = scene.state;
  Drained out;
  out.lanes = scene.extents.lanes;
  out.samples = s.out.samples.count;
  const std::size_t row = sample::row(out.lanes), pitch = sample::pitch(out.lanes);
  out.sample_rows.reserve(out.samples * row);
  for (int i = 0; i < out.samples; ++i) {
    const double* const from = s.out.samples.rows + i * pitch;
    out.sample_rows.insert(out.sample_rows.end(), from, from + row);
  }
  out.shocks.assign(s.out.ended_shocks.rows, s.out.ended_shocks.rows + s.out.ended_shocks.count);
  s.out.samples.count = s.out.ended_shocks.count = 0;
  return out;
}

Snapshot Batch::snapshot(int slot) const {
  const BatchSlot& scene = impl_->at(slot);
  const SceneState& s = scene.state;
  const std::size_t modes2 = scene.model.resonator.modes.size(),
                    modes1 = scene.model.slider.modes.size();
  const auto take = [](const double* from, std::size_t count) {
    return std::vector<double>(from, from + count);
  };
  Snapshot out;
  out.status = s.carried.status;
  out.step = s.carried.step;
  out.steps_made = scene.extents.adaptive() ? s.carried.adaptive_steps : s.carried.step;
  out.resonator_u = take(s.out.now.u, modes2);
  out.resonator_v = take(s.out.now.v, modes2);
  out.slider_u = take(s.out.now.u + modes2, modes1);
  out.slider_v = take(s.out.now.v + modes2, modes1);
  out.resonator_square = take(s.out.now.square, modes2);
  for (std::size_t k = 0; k < modes2; ++k) {
    out.resonator_square[k] += s.out.now.square_part[k];
    out.resonator_square[k] *=
        mean_square(scene.model.scene.time, scene.model.resonator.modes[k], scene.model.tick);
  }
  out.contact_steps = s.carried.sums.contact_steps;
  out.most_nodes = s.carried.sums.most_nodes;
  out.evaluated = s.carried.sums.evaluated;
  out.shocks_begun = s.carried.shocks.begun;
  out.energy = s.carried.energy.latest;
  out.energy_limit = s.carried.energy.limit;
  double deflection_work = 0;
  for (int lane = 0; lane < scene.shape.width; ++lane)
    deflection_work += s.out.now.deflection_work_part[lane];
  out.sliding_work = s.carried.sums.sliding_work +
                     scene.model.advance * (s.carried.sums.face_work_part + deflection_work);
  out.force_work = s.carried.sums.force_work + s.carried.sums.force_part;
  out.open_shocks.assign(s.out.now.open, s.out.now.open + s.carried.shocks.open_count);
  return out;
}

SavedState Batch::save(int slot) const { return impl_->at(slot).save(); }

void Batch::restore(int slot, const SavedState& saved) { impl_->at(slot).restore(saved); }

}  // namespace ra2d
