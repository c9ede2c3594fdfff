// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/samples.hpp"

#include <cmath>
#include <initializer_list>
#include <utility>

namespace ra2d {
namespace {

/// A body's energies, and the work that its load has done since the start [J]. One loop finds them
/// all: each addition waits for the one before in its own sum.
class Energies {
 public:
  Energies(const Body& body, const std::vector<double>& start) {
    for (std::size_t k = 0; k < body.modes.size(); ++k)
      modes_.push_back({0.5 * body.modes[k].mass, body.modes[k].omega, body.load[k], start[k]});
  }
  /// Adds them to `kinetic` and `elastic`; returns the work.
  double add(const double* u, const double* v, double& kinetic, double& elastic) const {
    double of_motion = kinetic, of_springs = elastic, work = 0;
    for (std::size_t k = 0; k < modes_.size(); ++k) {
      const ModeAtWork& mode = modes_[k];
      const double stretch = mode.omega * u[k];
      of_motion += mode.half_mass * v[k] * v[k];
      of_springs += mode.half_mass * stretch * stretch;
      work += mode.load * (u[k] - mode.start);
    }
    kinetic = of_motion, elastic = of_springs;
    return work;
  }

 private:
  struct ModeAtWork {
    double half_mass, omega, load, start;
  };
  std::vector<ModeAtWork> modes_;
};

/// Room for `samples` more, so that nothing moves while they are added.
void make_room(SampleBlock& block, const Model& model, std::size_t samples) {
  const std::size_t modes2 = model.resonator.modes.size(), modes1 = model.slider.modes.size();
  const std::size_t probes2 = model.scene.output.probes.size(),
                    probes1 = model.scene.output.slider_probes.size();
  for (const auto& [column, width] :
       std::initializer_list<std::pair<std::vector<double>*, std::size_t>>{
           {&block.time, 1},
           {&block.resonator_displacement, modes2},
           {&block.resonator_velocity, modes2},
           {&block.slider_displacement, modes1},
           {&block.slider_velocity, modes1},
           {&block.force, 1},
           {&block.nodes, 1},
           {&block.probe_displacement, probes2},
           {&block.probe_velocity, probes2},
           {&block.slider_probe_displacement, probes1},
           {&block.slider_probe_velocity, probes1},
           {&block.kinetic, 1},
           {&block.elastic, 1},
           {&block.contact, 1},
           {&block.damping_loss, 1},
           {&block.sliding_work, 1},
           {&block.load_work, 1}})
    column->reserve(column->size() + samples * width);
}

/// The displacement or velocity of a body at its probes, from its modes.
class Probes {
 public:
  Probes(const Body& body, const std::vector<ProbePlace>& places)
      : modes_{body.modes.size()}, count_{places.size()} {
    for (const auto& [x, y] : places)
      for (const BodyMode& mode : body.modes)
        shapes_.push_back(y ? shape_at(mode, x, *y) : shape_at(mode, x));
  }
  /// Appends the sums over the modes, a probe each.
  void read(const double* u, const double* v, std::vector<double>& displacement,
            std::vector<double>& velocity) const {
    for (std::size_t p = 0; p < count_; ++p) {
      double sum_u = 0, sum_v = 0;
      for (std::size_t k = 0; k < modes_; ++k) {
        sum_u += u[k] * shapes_[p * modes_ + k];
        sum_v += v[k] * shapes_[p * modes_ + k];
      }
      displacement.push_back(sum_u);
      velocity.push_back(sum_v);
    }
  }

 private:
  std::size_t modes_, count_;
  std::vector<double> shapes_;  // (probe, mode)
};

/// Shocks that have ended, or open ones as if they ended now.
template <class Row>
std::vector<Shock> convert_shocks(const Model& model, const std::vector<Row>& rows) {
  const double tick = model.tick, chi = model.scene.spacing;
  std::vector<Shock> shocks;
  shocks.reserve(rows.size());
  for (const Row& row : rows) {
    Shock shock;
    shock.serial = row.serial;
    shock.start = static_cast<double>(row.start) * tick;
    shock.duration = static_cast<double>(row.last - row.start + 1) * tick;
    shock.peak_force = row.peak;
    shock.impulse = row.impulse * tick;
    // a contact that only touched has no force to weight with
    shock.position = (row.impulse > 0 ? row.moment / row.impulse : row.place) * chi;
    if (model.is_areal)
      shock.y = model.side + (0.5 + (row.impulse > 0 ? row.across_moment / row.impulse : row.row)) *
                                 model.spacing_y;
    shocks.push_back(shock);
  }
  return shocks;
}

}  // namespace

SampleBlock make_samples(const Model& model, const ModalStart& start, const Drained& drained,
                         std::int64_t first) {
  const std::size_t modes2 = model.resonator.modes.size(), modes1 = model.slider.modes.size();
  const std::size_t lanes = drained.lanes, row_size = 2 * lanes + sample::columns;
  const Probes probes(model.resonator, model.scene.output.probes);
  const Probes slider_probes(model.slider, model.scene.output.slider_probes);
  const Energies resonator(model.resonator, start.resonator_u),
      slider(model.slider, start.slider_u);
  SampleBlock block;
  make_room(block, model, static_cast<std::size_t>(drained.samples));
  for (int i = 0; i < drained.samples; ++i) {
    const double* u = drained.sample_rows.data() + i * row_size;
    const double* v = u + lanes;
    const double* columns = v + lanes;
    block.time.push_back(static_cast<double>(first + i) / model.scene.output.rate);
    block.resonator_displacement.insert(block.resonator_displacement.end(), u, u + modes2);
    block.resonator_velocity.insert(block.resonator_velocity.end(), v, v + modes2);
    block.slider_displacement.insert(block.slider_displacement.end(), u + modes2,
                                     u + modes2 + modes1);
    block.slider_velocity.insert(block.slider_velocity.end(), v + modes2, v + modes2 + modes1);
    block.force.push_back(columns[sample::force]);
    block.nodes.push_back(std::round(columns[sample::nodes]));
    probes.read(u, v, block.probe_displacement, block.probe_velocity);
    slider_probes.read(u + modes2, v + modes2, block.slider_probe_displacement,
                       block.slider_probe_velocity);
    double kinetic = 0, elastic = 0;
    const double work2 = resonator.add(u, v, kinetic, elastic),
                 work1 = slider.add(u + modes2, v + modes2, kinetic, elastic);
    block.kinetic.push_back(kinetic);
    block.elastic.push_back(elastic);
    block.contact.push_back(columns[sample::contact_energy]);
    block.damping_loss.push_back(columns[sample::damping_loss]);
    block.sliding_work.push_back(columns[sample::sliding_work]);
    block.load_work.push_back(columns[sample::force_work] + work2 + work1);
  }
  return block;
}

std::vector<Shock> make_shocks(const Model& model, const std::vector<ShockRow>& rows) {
  return convert_shocks(model, rows);
}
std::vector<Shock> make_shocks(const Model& model, const std::vector<OpenShock>& open) {
  return convert_shocks(model, open);
}

}  // namespace ra2d
