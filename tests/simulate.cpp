// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simulate.hpp"
#include "host/result/energy.hpp"

namespace ra2d::test {

std::vector<Recording> simulate(const std::vector<Model>& models,
                                const std::vector<ModalStart>& starts, const Launches& launches) {
  std::vector<Recording> out(models.size());
  Batch batch(models, starts, launches.batch);
  std::vector<EnergyAccount> accounts(models.size());
  std::vector<std::int64_t> samples(models.size(), 0);
  for (std::int64_t target = 0;;) {
    target = launches.steps > std::numeric_limits<std::int64_t>::max() - target
                 ? launches.steps
                 : target + launches.steps;
    batch.march(target);
    bool running = false;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const Drained drained = batch.drain(static_cast<int>(i));
      const SampleBlock block = make_samples(models[i], starts[i], drained, samples[i]);
      samples[i] += drained.samples;
      accounts[i].add(block);
      const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
      };
      SampleBlock& all = out[i].samples;
      append(all.time, block.time);
      append(all.resonator_displacement, block.resonator_displacement);
      append(all.resonator_velocity, block.resonator_velocity);
      append(all.slider_displacement, block.slider_displacement);
      append(all.slider_velocity, block.slider_velocity);
      append(all.force, block.force);
      append(all.nodes, block.nodes);
      append(all.probe_displacement, block.probe_displacement);
      append(all.probe_velocity, block.probe_velocity);
      append(all.slider_probe_displacement, block.slider_probe_displacement);
      append(all.slider_probe_velocity, block.slider_probe_velocity);
      append(all.kinetic, block.kinetic);
      append(all.elastic, block.elastic);
      append(all.contact, block.contact);
      append(all.damping_loss, block.damping_loss);
      append(all.sliding_work, block.sliding_work);
      append(all.load_work, block.load_work);
      append(out[i].shocks, drained.shocks);
      running = running || batch.snapshot(static_cast<int>(i)).status == Status::running;
    }
    if (!running) break;
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    out[i].model = models[i];
    out[i].start = starts[i];
    out[i].end = batch.snapshot(static_cast<int>(i));
    out[i].energy = accounts[i].balance();
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
