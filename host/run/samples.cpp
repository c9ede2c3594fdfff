// SPDX-License-Identifier: BSD-3-Clause
#include "host/run/samples.hpp"

#include <cmath>
#include <initializer_list>
#include <utility>

namespace ra2d {
namespace {

/// Kinetic and elastic energy of one body's modes [J].
void add_energy(const Body& body, const double* u, const double* v, double& kinetic,
                double& elastic) {
  for (std::size_t k = 0; k < body.modes.size(); ++k) {
    const Mode& mode = body.modes[k];
    const double stretch = mode.omega * u[k];
    kinetic += 0.5 * mode.mass * v[k] * v[k];
    elastic += 0.5 * mode.mass * stretch * stretch;
  }
}

double load_work(const Body& body, const double* u, const std::vector<double>& start) {
  double work = 0;
  for (std::size_t k = 0; k < body.modes.size(); ++k) work += body.load[k] * (u[k] - start[k]);
  return work;
}

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
  void read(const double* amplitudes, std::vector<double>& out) const {
    for (std::size_t p = 0; p < count_; ++p) {
      double sum = 0;
      for (std::size_t k = 0; k < modes_; ++k) sum += amplitudes[k] * shapes_[p * modes_ + k];
      out.push_back(sum);
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
    probes.read(u, block.probe_displacement);
    probes.read(v, block.probe_velocity);
    slider_probes.read(u + modes2, block.slider_probe_displacement);
    slider_probes.read(v + modes2, block.slider_probe_velocity);
    double kinetic = 0, elastic = 0;
    add_energy(model.resonator, u, v, kinetic, elastic);
    add_energy(model.slider, u + modes2, v + modes2, kinetic, elastic);
    block.kinetic.push_back(kinetic);
    block.elastic.push_back(elastic);
    block.contact.push_back(columns[sample::contact_energy]);
    block.damping_loss.push_back(columns[sample::damping_loss]);
    block.sliding_work.push_back(columns[sample::sliding_work]);
    block.load_work.push_back(columns[sample::force_work] +
                              load_work(model.resonator, u, start.resonator_u) +
                              load_work(model.slider, u + modes2, start.slider_u));
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
