// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simulate.hpp"

#include <memory>

#include "host/result/energy.hpp"
#include "host/run/simulation.hpp"

namespace ra2d::test {

namespace {

class RecordingSink : public Sink {
 public:
  explicit RecordingSink(Recording& to) : to_{to} {}
  void take_raw(const Drained& drained) override { append(to_.shocks, drained.shocks); }
  void take(const std::vector<Shock>&) override {}
  void take(const SampleBlock& block) override {
    for (const auto column :
         {&SampleBlock::time, &SampleBlock::resonator_displacement,
          &SampleBlock::resonator_velocity, &SampleBlock::slider_displacement,
          &SampleBlock::slider_velocity, &SampleBlock::force, &SampleBlock::nodes,
          &SampleBlock::probe_displacement, &SampleBlock::probe_velocity,
          &SampleBlock::slider_probe_displacement, &SampleBlock::slider_probe_velocity,
          &SampleBlock::kinetic, &SampleBlock::elastic, &SampleBlock::contact,
          &SampleBlock::damping_loss, &SampleBlock::sliding_work, &SampleBlock::load_work})
      append(to_.samples.*column, block.*column);
  }

 private:
  template <class T>
  static void append(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
  }
  Recording& to_;
};

}  // namespace

std::vector<Recording> simulate(const std::vector<Model>& models,
                                const std::vector<ModalStart>& starts, const Launches& launches) {
  std::vector<Recording> out(models.size());
  std::vector<std::unique_ptr<RecordingSink>> sinks;
  std::vector<std::unique_ptr<SceneRun>> runs;
  std::vector<SceneRun*> all;
  for (std::size_t i = 0; i < models.size(); ++i) {
    out[i].model = models[i];
    out[i].start = starts[i];
    sinks.push_back(std::make_unique<RecordingSink>(out[i]));
    runs.push_back(
        std::make_unique<SceneRun>(models[i], starts[i], RunLimits{}, sinks.back().get()));
    all.push_back(runs.back().get());
  }
  Simulation({.ticks = launches.steps, .batch = launches.batch}).run(all);
  for (std::size_t i = 0; i < models.size(); ++i) {
    out[i].end = runs[i]->accounts().now;
    out[i].energy = runs[i]->accounts().energy.balance();
  }
  return out;
}

std::vector<Recording> simulate(const std::vector<Scene>& scenes, const Launches& launches) {
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (const Scene& scene : scenes) {
    models.push_back(make_model(scene));
    starts.push_back(make_start(models.back()));
  }
  return simulate(models, starts, launches);
}

Recording simulate(const Scene& scene, const Launches& launches) {
  return simulate(std::vector<Scene>{scene}, launches)[0];
}

}  // namespace ra2d::test
