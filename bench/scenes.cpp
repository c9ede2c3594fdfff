// SPDX-License-Identifier: BSD-3-Clause
#include "bench/scenes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "bench/places.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d::bench {
namespace {

constexpr std::int64_t settling_steps = 2'000'000;  // 20 ms at 10 ns

Scene read(Paper paper, const Method& method) {
  return with(read_scene(scene_file(paper == Paper::free_slider ? "dang2012" : "dang2012-pinned")),
              method);
}

double modal_energy(const Body& body, const std::vector<double>& u, const std::vector<double>& v) {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    sum += 0.5 * body.modes[k].mass * (v[k] * v[k] + std::pow(body.modes[k].omega * u[k], 2));
  return sum;
}

Prepared start_of(const Scene& scene) {
  Prepared out{make_model(scene), {}};
  out.start = make_start(out.model);
  return out;
}

}  // namespace

Scene scene_of(Paper paper, int variant, const Method& method) {
  Scene scene = read(paper, method);
  scene.resonator.surface.seed += 2 * variant;  // stays clear of the slider's seeds
  scene.slider.surface.seed += 2 * variant;
  return scene;
}

Prepared at_start(Paper paper, int variant, const Method& method) {
  return start_of(scene_of(paper, variant, method));
}

std::vector<Prepared> settled(Paper paper, int count, const Method& method) {
  static std::map<std::pair<Paper, std::string>, std::vector<Prepared>> cache;
  std::vector<Prepared>& scenes = cache[{paper, text(method)}];
  std::vector<Prepared> missing;
  for (int i = static_cast<int>(scenes.size()); i < count; ++i)
    missing.push_back(at_start(paper, i, method));
  if (!missing.empty()) {
    Batch batch = make_batch(missing);
    march_on(batch, static_cast<int>(missing.size()), settling_steps);
    for (std::size_t i = 0; i < missing.size(); ++i)
      scenes.push_back(taken_over(missing[i], batch.snapshot(static_cast<int>(i))));
  }
  return {scenes.begin(), scenes.begin() + count};
}

Prepared taken_over(const Prepared& from, const Snapshot& now) {
  Prepared out = from;
  out.model.position =
      std::fma(static_cast<double>(now.step), from.model.advance, from.model.position);
  out.model.steps -= now.step;
  out.start.resonator_u = now.resonator_u;
  out.start.resonator_v = now.resonator_v;
  out.start.slider_u = now.slider_u;
  out.start.loaded_nodes.clear();  // multipliers are found anew
  out.start.slider_v = now.slider_v;
  // for the check of the energy; the contact's share is small against its allowance
  out.start.energy = modal_energy(from.model.resonator, now.resonator_u, now.resonator_v) +
                     modal_energy(from.model.slider, now.slider_u, now.slider_v);
  return out;
}

Prepared before_contact(const Prepared& from, std::int64_t stretch) {
  Batch batch = make_batch({from});
  Snapshot before = batch.snapshot(0);
  for (std::int64_t target = stretch; target <= from.model.steps; target += stretch) {
    march_on(batch, 1, target);
    const Snapshot now = batch.snapshot(0);
    if (now.contact_steps > before.contact_steps) return taken_over(from, before);
    before = now;
  }
  throw std::runtime_error("benchmark scene: nothing ever touches");
}

Prepared in_flight(const Method& method) {
  Scene scene = read(Paper::pinned_slider, method);
  scene.initial = Initial::rest;
  scene.gap = 1.0;
  scene.output.rate = 1000.0;  // so that hardly anything but flying is timed
  Prepared out = start_of(scene);
  for (double& v : out.start.resonator_v) v = 1e-4;
  out.start.energy =
      modal_energy(out.model.resonator, out.start.resonator_u, out.start.resonator_v);
  return out;
}

Prepared in_contact(const Method& method) {
  Scene scene = read(Paper::free_slider, method);
  scene.speed = 0.0;
  scene.output.rate = 1000.0;
  Prepared out = start_of(scene);
  // up and down at 1 um/s: the springs move by some 1e-11 m, their static overlap is about 1e-9 m
  out.start.slider_v.at(0) = -1e-6 * std::sqrt(scene.slider.length);
  return out;
}

Prepared evaluating(Prepared scene, Nodes nodes) {
  scene.model.scene.time.nodes = nodes;
  return scene;
}

Batch make_batch(const std::vector<Prepared>& scenes) {
  std::vector<Model> models;
  std::vector<ModalStart> starts;
  for (const Prepared& scene : scenes) {
    models.push_back(scene.model);
    starts.push_back(scene.start);
  }
  return Batch(models, starts);
}

void march_on(Batch& batch, int scenes, std::int64_t target) {
  for (bool there = false; !there;) {
    batch.march(target);
    there = true;
    for (int i = 0; i < scenes; ++i) {
      batch.drain(i);
      const Snapshot now = batch.snapshot(i);
      if (now.step < target && now.status != Status::running)
        throw std::runtime_error("benchmark scene: it ended before its time");
      there = there && now.step >= target;
    }
  }
}

}  // namespace ra2d::bench
