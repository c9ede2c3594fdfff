// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <new>
#include <set>
#include <vector>

#include "host/device/batch.hpp"
#include "host/device/device.hpp"
#include "host/device/memory.hpp"
#include "tests/outcomes.hpp"
#include "tests/scenes.hpp"
#include "tests/separate_device.hpp"
#include "tests/simulate.hpp"

/// Batches on a device with memory of its own, as a GPU has: the bits are those of the host. More
/// tests run there a second time (tests/CMakeLists.txt, "device.").
namespace ra2d::test {
namespace {

/// On a GPU there are no marches for the host, and all other tests check it.
class SeparateDeviceTest : public testing::Test {
 protected:
  void SetUp() override {
    if (march_device() != nullptr) GTEST_SKIP() << "scenes are marched on a device as it is";
  }
};
using SeparateDeviceDeathTest = SeparateDeviceTest;

/// Of every form and contact law, in contact.
std::vector<Scene> forms() {
  std::vector<Scene> scenes;
  for (const SchemeKind scheme :
       {SchemeKind::backward_euler, SchemeKind::midpoint, SchemeKind::rk4, SchemeKind::adaptive}) {
    scenes.push_back(rough_scene(Support::free));
    scenes.back().time.scheme = scheme;
    scenes.back().duration /= 3;
  }
  scenes.push_back(scenes[0]);
  scenes.back().time.contact_force = ForceTime::new_time;
  scenes.push_back(scenes[0]);
  scenes.back().contact.law = ContactLaw::multiplier;
  scenes.push_back(scenes[3]);
  scenes.back().resonator.moving_forces = {{.force = 3, .speed = 40, .start = 0.01}};
  return scenes;
}

TEST_F(SeparateDeviceTest, GivesTheBitsOfTheHost) {
  const std::vector<Scene> scenes = forms();
  const std::vector<Recording> here = simulate(scenes);
  SeparateDevice device;
  const MarchedThere there(device);
  for (const std::int64_t steps : {std::int64_t{1} << 60, std::int64_t{1000}}) {
    const std::vector<Recording> marched = simulate(scenes, {.steps = steps, .batch = {}});
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      EXPECT_GT(here[i].end.contact_steps, 0) << "scene " << i;
      EXPECT_TRUE(same(here[i], marched[i])) << "scene " << i;
    }
  }
  EXPECT_EQ(device.blocks(), 0u);
}

TEST_F(SeparateDeviceTest, AStateSavedThereGoesOnHere) {
  SeparateDevice device;
  for (const Scene& scene : forms()) {
    const Model model = make_model(scene);
    const ModalStart start = make_start(model);
    Batch whole({model}, {start});
    whole.march(model.steps / 2);
    SavedState saved;
    {
      const MarchedThere there(device);
      Batch first({model}, {start});
      first.march(model.steps / 4);
      Batch second({model}, {start});
      second.restore(0, first.save(0));
      EXPECT_EQ(second.snapshot(0).resonator_u, first.snapshot(0).resonator_u);
      EXPECT_EQ(second.snapshot(0).sliding_work, first.snapshot(0).sliding_work);
      second.march(model.steps / 2);
      saved = second.save(0);
    }
    Batch here({model}, {start});
    here.restore(0, saved);
    whole.march(model.steps);
    here.march(model.steps);
    EXPECT_EQ(here.snapshot(0).resonator_u, whole.snapshot(0).resonator_u);
    EXPECT_EQ(here.snapshot(0).sliding_work, whole.snapshot(0).sliding_work);
    EXPECT_EQ(here.snapshot(0).shocks_begun, whole.snapshot(0).shocks_begun);
  }
}

/// Room for all samples of a scene, where their rows are of the most modes (RA2D_ONE_MARCH), too.
const BatchOptions all_samples{.capacity = {.sample_bytes = 1 << 23}};

/// Memory that a batch of one slot takes there for this scene.
std::size_t taken_by(const Model& model, const ModalStart& start) {
  SeparateDevice device;
  const MarchedThere there(device);
  const std::size_t before = device.free_memory();
  Batch batch(1, all_samples);
  batch.put(0, model, start);
  return before - device.free_memory();
}

TEST_F(SeparateDeviceTest, ItsMemoryIsUsedAgain) {
  Scene small = rough_scene(Support::free), large = small;
  large.spacing /= 4;
  const Model model = make_model(small), other = make_model(large);
  const ModalStart start = make_start(model), start_of_other = make_start(other);
  const std::size_t of_small = taken_by(model, start), of_large = taken_by(other, start_of_other);
  ASSERT_LT(2 * of_small, of_large);
  SeparateDevice device(of_large + of_small / 2);
  const MarchedThere there(device);
  Batch batch(1, all_samples);
  batch.put(0, model, start);
  const std::size_t blocks = device.blocks();
  batch.march(model.steps);
  for (int i = 0; i < 3; ++i) {
    batch.put(0, model, start);
    EXPECT_EQ(device.blocks(), blocks);
    EXPECT_EQ(device.free_memory(), of_large - of_small / 2);
    // nothing of the scene before is left
    const Snapshot at_start = batch.snapshot(0);
    EXPECT_EQ(at_start.resonator_square, std::vector<double>(at_start.resonator_u.size(), 0.0));
    EXPECT_EQ(at_start.sliding_work, 0.0);
    batch.march(model.steps);
    EXPECT_EQ(batch.snapshot(0).status, Status::done);
  }
  // what is free goes back where it stands in the way of a larger one, and where that is the last
  // one
  batch.put(0, other, start_of_other);
  batch.put(0, model, start);
  batch = Batch(2, all_samples);
  batch.put(0, other, start_of_other);
  EXPECT_THROW(batch.put(1, other, start_of_other), std::bad_alloc);
  batch.march(other.steps / 100);
  EXPECT_EQ(batch.snapshot(0).status, Status::running);
  EXPECT_GT(batch.snapshot(0).step, 0);
}

TEST_F(SeparateDeviceTest, AContactWithoutMemoryToGrowEndsItsSceneAlone) {
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (const Scene& scene :
       {forms()[3], rough_scene(Support::free)}) {  // the second one never grows
    models.push_back(make_model(scene));
    starts.push_back(make_start(models.back()));
  }
  const BatchOptions one_node{.capacity = {.nodes = 1}};
  const std::vector<std::int64_t> ends{models[0].steps, models[1].steps};
  const auto march_to_end = [&](Batch& batch) {
    for (const int slot : {0, 1})
      while (batch.snapshot(slot).status == Status::running) {
        batch.march(ends);
        batch.drain(0);
        batch.drain(1);
      }
  };
  std::size_t taken = 0;
  Snapshot other;
  SavedState grown;
  {
    SeparateDevice device;
    const MarchedThere there(device);
    const std::size_t before = device.free_memory();
    Batch batch(models, starts, one_node);
    taken = before - device.free_memory();
    while (batch.snapshot(0).status == Status::running && batch.save(0).node_capacity == 1) {
      batch.march({batch.snapshot(0).step + ends[0] / 50, 0});
      batch.drain(0);
    }
    grown = batch.save(0);
    ASSERT_GT(grown.node_capacity, 1);
    march_to_end(batch);
    ASSERT_EQ(batch.snapshot(0).status, Status::done);
    other = batch.snapshot(1);
  }
  SeparateDevice device(taken);
  const MarchedThere there(device);
  Batch batch(models, starts, one_node);
  EXPECT_THROW(batch.restore(0, grown), std::bad_alloc);
  EXPECT_EQ(batch.save(0).node_capacity, 1);  // and it goes on as if it had not been tried
  march_to_end(batch);
  EXPECT_EQ(batch.snapshot(0).status, Status::crowded);
  EXPECT_GT(batch.snapshot(0).step, 0);
  EXPECT_EQ(batch.snapshot(1).status, Status::done);
  EXPECT_EQ(batch.snapshot(1).resonator_u, other.resonator_u);
}

// A scene that grows takes memory outside the room of the batch, and keeps what it had at first.
TEST_F(SeparateDeviceTest, RoomIsNotGivenBackByWhatGrows) {
  SeparateDevice device;
  const MarchedThere there(device);  // where what is handed out does not count
  const Model model = make_model(forms()[3]);
  const ModalStart start = make_start(model);
  BatchOptions options{.capacity = {.nodes = 1}};
  options.memory = Batch({model}, {start}, options).bytes();
  Batch batch(2, options);
  batch.put(0, model, start);
  const std::size_t at_first = batch.bytes();
  while (batch.snapshot(0).status == Status::running && batch.bytes() == at_first) {
    batch.march(batch.snapshot(0).step + model.steps / 50);
    batch.drain(0);
  }
  ASSERT_GT(batch.bytes(), at_first);
  EXPECT_THROW(batch.put(1, model, start), std::bad_alloc);
}

TEST_F(SeparateDeviceDeathTest, WhoTouchesItsMemoryFromOutsideIsCaught) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  SeparateDevice device;
  char* const block = device.allocate(100);
  EXPECT_DEATH(block[0] = 1, "");
  const SeparateDevice::Opened opened(device);
  block[0] = 1;
}

/// The driver is asked for one block, then for as many as there are.
TEST(DevicePool, AsksForMoreBlocksAtATime) {
  constexpr int count = 1000;
  constexpr std::size_t bytes = 4096;
  SeparateDevice device;
  DevicePool pool(device, DevicePool::Kind::on_device, 0);
  std::vector<Block> lent;
  std::set<char*> places;
  for (int i = 1; i <= count; ++i) {
    lent.push_back(pool.lend(bytes));
    EXPECT_EQ(device.blocks(), std::bit_width(i - 1u) + 1u) << i;
    places.insert(lent.back().data());
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lent.back().data()) % device_line, 0u);
  }
  ASSERT_EQ(places.size(), std::size_t{count});
  for (auto one = places.begin(), next = std::next(one); next != places.end(); ++one, ++next)
    EXPECT_GE(*next - *one, std::ptrdiff_t{bytes});
  // they are used again
  const std::size_t left = device.free_memory();
  lent.clear();
  for (int i = 0; i < count; ++i) lent.push_back(pool.lend(bytes - 100));
  EXPECT_EQ(device.free_memory(), left);
  // 32 MB at a time at the most
  for (int i = 0; i < 9; ++i) {
    const std::size_t before = device.free_memory();
    lent.push_back(pool.lend(8 << 20));
    EXPECT_LE(before - device.free_memory(), std::size_t{32 << 20});
  }
  for (int i = 0; i < 3; ++i) {
    const std::size_t before = device.free_memory();
    lent.push_back(pool.lend(20 << 20));
    EXPECT_EQ(before - device.free_memory(), std::size_t{20 << 20});
  }
}

TEST(DevicePool, KeepsWithinItsLimitAndTheMemory) {
  constexpr std::size_t bytes = 4096, most = 10 * bytes;
  for (const bool by_limit : {true, false}) {
    SeparateDevice device(by_limit ? 100 * bytes : most);
    const std::size_t all = device.free_memory();
    DevicePool pool(device, DevicePool::Kind::on_device, by_limit ? most : 0);
    std::vector<Block> lent;
    for (int i = 0; i < 10; ++i) {
      const std::size_t before = device.free_memory();
      lent.push_back(pool.lend(bytes));
      EXPECT_LE(all - device.free_memory(), most) << i;
      if (by_limit && all - before > most / 2) {
        EXPECT_EQ(before - device.free_memory(), bytes) << "beyond half of the limit, " << i;
      }
    }
    if (!by_limit) {
      EXPECT_THROW(pool.lend(bytes), std::bad_alloc);
    }
    // slabs without a lent block go back where a larger one needs their place
    lent.resize(2);
    lent.push_back(pool.lend(3 * bytes));
    EXPECT_LE(all - device.free_memory(), most);
    lent.clear();
    lent.push_back(pool.lend(10 * bytes));
    EXPECT_EQ(all - device.free_memory(), most);
    EXPECT_EQ(device.blocks(), 1u);
  }
}

TEST(SharedTables, ScenesWithEqualBodiesHaveThemOnce) {
  Scene scene = rough_scene(Support::free), other = scene;
  ++other.resonator.surface.seed;
  Scene third = scene;
  third.resonator.damping *= 2;
  const auto bytes_of = [](const std::vector<Scene>& scenes) {
    std::vector<Model> models;
    std::vector<ModalStart> starts;
    for (const Scene& s : scenes) {
      models.push_back(make_model(s));
      starts.push_back(make_start(models.back()));
    }
    return Batch(models, starts).bytes();
  };
  const std::size_t one = bytes_of({scene}), with_equal = bytes_of({scene, other}),
                    with_unequal = bytes_of({scene, third});
  EXPECT_EQ(with_unequal, 2 * one);
  EXPECT_LT(with_equal, 2 * one);
  // they share at least the shapes of the modes
  const Model model = make_model(scene);
  EXPECT_GT(2 * one - with_equal, model.slider.modes.size() * model.slider_height.size() * 8);
}

}  // namespace
}  // namespace ra2d::test
