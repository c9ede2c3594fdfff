// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/entries.hpp"

#include <string_view>
#include <type_traits>

namespace ra2d {
namespace {

std::vector<double> node_positions(std::size_t nodes, double spacing) {
  std::vector<double> x(nodes);
  for (std::size_t n = 0; n < nodes; ++n) x[n] = double(n) * spacing;
  return x;
}

/// Middles of strips.
std::vector<double> row_positions(const ResultHeader& header, double side) {
  std::vector<double> y(static_cast<std::size_t>(header.rows));
  for (std::size_t j = 0; j < y.size(); ++j) y[j] = side + (double(j) + 0.5) * header.spacing_y;
  return y;
}

std::vector<double> numbers(std::size_t count, double first = 0) {
  std::vector<double> all = node_positions(count, 1.0);
  for (double& number : all) number += first;
  return all;
}

template <auto member>
constexpr PerShock per_shock{
    [](const Shock& shock) { return static_cast<double>(shock.*member); },
    [](Shock& shock, double value) {
      shock.*member = static_cast<std::remove_reference_t<decltype(shock.*member)>>(value);
    }};

constexpr Group all_groups[] = {
    {"resonator", "modes of the resonator, and their motion over the time", true},
    {"slider", "modes of the slider, and their motion over the time", true},
    {"contact", "contact of the faces over the time", true},
    {"probes", "motion of the resonator at its probes over the time", true},
    {"slider_probes", "motion of the slider at its probes over the time", true},
    {"energy", "energies over the time, and works and losses since t = 0", true},
    {"shocks", "shocks, in order of start"},
    {"level", "vibration level of the resonator"},
    {"summary", "figures of the report"},
    {"surface", "heights of the faces, as the run used them"},
    {"surface/slider", "heights of the slider's face, positive towards the resonator"},
    {"surface/resonator", "heights of the resonator's face, positive towards the slider"}};

// clang-format off
const Entry all_entries[] = {
    {"time", "s", "time", "time", "", &SampleBlock::time},
    {"resonator/mode", "1", "numbers of the resonator's modes, rigid ones first", "resonator/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return numbers(h.resonator.frequency.size()); }, Numbers::whole},
    {"resonator/position", "m", "places on the resonator from its left end", "resonator/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.position; }},
    {"resonator/y", "m", "places on the resonator from its side", "resonator/y", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.y; }, Numbers::real, nullptr, Of::areal},
    {"resonator/mode_x", "1", "half waves of the resonator's modes along x", "resonator/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.mode_x; }, Numbers::whole, nullptr, Of::areal},
    {"resonator/mode_y", "1", "half waves of the resonator's modes along y", "resonator/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.mode_y; }, Numbers::whole, nullptr, Of::areal},
    {"resonator/frequency", "Hz", "natural frequencies of the resonator", "resonator/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.frequency; }},
    {"resonator/shape", "m-0.5", "mode shapes of the resonator", "resonator/mode", "resonator/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.shape; }, Numbers::real, nullptr, Of::plane},
    {"resonator/shape_x", "m-1", "mode shapes of the resonator along x, a factor", "resonator/mode", "resonator/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.shape_x; }, Numbers::real, nullptr, Of::areal},
    {"resonator/shape_y", "1", "mode shapes of the resonator along y, a factor", "resonator/mode", "resonator/y",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.shape_y; }, Numbers::real, nullptr, Of::areal},
    {"resonator/mean_square", "m-1", "mean squares of the elastic mode shapes over all nodes", "resonator/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator.mean_square.get(); }, Numbers::real, nullptr, Of::all, "m-2"},
    {"resonator/displacement", "m1.5", "modal displacements of the resonator", "time", "resonator/mode", &SampleBlock::resonator_displacement, Numbers::real, nullptr, Of::all, "m2"},
    {"resonator/velocity", "m1.5 s-1", "modal velocities of the resonator", "time", "resonator/mode", &SampleBlock::resonator_velocity, Numbers::real, nullptr, Of::all, "m2 s-1"},
    {"slider/mode", "1", "numbers of the slider's modes, rigid ones first", "slider/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return numbers(h.slider.frequency.size()); }, Numbers::whole},
    {"slider/position", "m", "places on the slider from its left end", "slider/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.position; }},
    {"slider/y", "m", "places on the slider from its side", "slider/y", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.y; }, Numbers::real, nullptr, Of::areal},
    {"slider/frequency", "Hz", "natural frequencies of the slider", "slider/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.frequency; }},
    {"slider/shape", "m-0.5", "mode shapes of the slider", "slider/mode", "slider/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.shape; }, Numbers::real, nullptr, Of::plane},
    {"slider/shape_x", "m-1", "mode shapes of the slider along x, a factor", "slider/mode", "slider/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.shape_x; }, Numbers::real, nullptr, Of::areal},
    {"slider/shape_y", "1", "mode shapes of the slider along y, a factor", "slider/mode", "slider/y",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.shape_y; }, Numbers::real, nullptr, Of::areal},
    {"slider/mean_square", "m-1", "mean squares of the elastic mode shapes over all nodes", "slider/mode", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider.mean_square.get(); }, Numbers::real, nullptr, Of::all, "m-2"},
    {"slider/displacement", "m1.5", "modal displacements of the slider", "time", "slider/mode", &SampleBlock::slider_displacement, Numbers::real, nullptr, Of::all, "m2"},
    {"slider/velocity", "m1.5 s-1", "modal velocities of the slider", "time", "slider/mode", &SampleBlock::slider_velocity, Numbers::real, nullptr, Of::all, "m2 s-1"},
    {"contact/force", "N", "total normal contact force", "time", "", &SampleBlock::force},
    {"contact/nodes", "1", "number of nodes in contact", "time", "", &SampleBlock::nodes, Numbers::whole},
    {"probes/position", "m", "positions of the probes on the resonator", "probes/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.probe_position; }, Numbers::real, nullptr, Of::plane},
    {"probes/probe", "1", "numbers of the probes on the resonator", "probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return numbers(h.probe_position.size(), 1); }, Numbers::whole, nullptr, Of::areal},
    {"probes/position", "m", "positions of the probes along the resonator", "probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.probe_position; }, Numbers::real, nullptr, Of::areal},
    {"probes/y", "m", "positions of the probes across the resonator", "probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.probe_y; }, Numbers::real, nullptr, Of::areal},
    {"probes/displacement", "m", "displacements of the resonator at the probes", "time", "probes/position", &SampleBlock::probe_displacement, Numbers::real, nullptr, Of::plane},
    {"probes/displacement", "m", "displacements of the resonator at the probes", "time", "probes/probe", &SampleBlock::probe_displacement, Numbers::real, nullptr, Of::areal},
    {"probes/velocity", "m s-1", "velocities of the resonator at the probes", "time", "probes/position", &SampleBlock::probe_velocity, Numbers::real, nullptr, Of::plane},
    {"probes/velocity", "m s-1", "velocities of the resonator at the probes", "time", "probes/probe", &SampleBlock::probe_velocity, Numbers::real, nullptr, Of::areal},
    {"slider_probes/position", "m", "positions of the probes on the slider", "slider_probes/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider_probe_position; }, Numbers::real, nullptr, Of::plane},
    {"slider_probes/probe", "1", "numbers of the probes on the slider", "slider_probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return numbers(h.slider_probe_position.size(), 1); }, Numbers::whole, nullptr, Of::areal},
    {"slider_probes/position", "m", "positions of the probes along the slider", "slider_probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider_probe_position; }, Numbers::real, nullptr, Of::areal},
    {"slider_probes/y", "m", "positions of the probes across the slider", "slider_probes/probe", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider_probe_y; }, Numbers::real, nullptr, Of::areal},
    {"slider_probes/displacement", "m", "displacements of the slider at its probes", "time", "slider_probes/position", &SampleBlock::slider_probe_displacement, Numbers::real, nullptr, Of::plane},
    {"slider_probes/displacement", "m", "displacements of the slider at its probes", "time", "slider_probes/probe", &SampleBlock::slider_probe_displacement, Numbers::real, nullptr, Of::areal},
    {"slider_probes/velocity", "m s-1", "velocities of the slider at its probes", "time", "slider_probes/position", &SampleBlock::slider_probe_velocity, Numbers::real, nullptr, Of::plane},
    {"slider_probes/velocity", "m s-1", "velocities of the slider at its probes", "time", "slider_probes/probe", &SampleBlock::slider_probe_velocity, Numbers::real, nullptr, Of::areal},
    {"energy/kinetic", "J", "kinetic energy", "time", "", &SampleBlock::kinetic},
    {"energy/elastic", "J", "elastic energy", "time", "", &SampleBlock::elastic},
    {"energy/contact", "J", "energy stored in the contact", "time", "", &SampleBlock::contact},
    {"energy/damping_loss", "J", "energy lost to damping since t = 0", "time", "", &SampleBlock::damping_loss},
    {"energy/sliding_work", "J", "work done by the imposed sliding since t = 0", "time", "", &SampleBlock::sliding_work},
    {"energy/load_work", "J", "work done by the loads since t = 0", "time", "", &SampleBlock::load_work},
    {"shocks/shock", "1", "numbers of the shocks in the order of their starts", "shocks/shock", "", per_shock<&Shock::serial>, Numbers::whole, "shocks/serial"},
    {"shocks/start", "s", "starts of the shocks", "shocks/shock", "", per_shock<&Shock::start>},
    {"shocks/duration", "s", "durations of the shocks", "shocks/shock", "", per_shock<&Shock::duration>},
    {"shocks/peak_force", "N", "peak forces of the shocks", "shocks/shock", "", per_shock<&Shock::peak_force>},
    {"shocks/impulse", "N s", "impulses of the shocks", "shocks/shock", "", per_shock<&Shock::impulse>},
    {"shocks/position", "m", "positions of the shocks on the resonator, weighted by force", "shocks/shock", "", per_shock<&Shock::position>},
    {"shocks/y", "m", "positions of the shocks across the resonator, weighted by force", "shocks/shock", "", per_shock<&Shock::y>, Numbers::real, nullptr, Of::areal},
    {"level/v_rms", "m s-1", "root mean square velocity of the resonator's elastic motion, over its nodes and the run from output.from on", "", "", &ResultSummary::v_rms},
    {"level/lv", "dB", "vibration velocity level re 1e-9 m s-1, over the run from output.from on", "", "", &ResultSummary::lv},
    {"summary/lv", "dB", "vibration velocity level re 1e-9 m s-1", "", "", &ResultSummary::lv},
    {"summary/lv_low", "dB", "lower end of the level's 95 % interval", "", "", &ResultSummary::lv_low},
    {"summary/lv_high", "dB", "upper end of the level's 95 % interval", "", "", &ResultSummary::lv_high},
    {"summary/v_rms", "m s-1", "root mean square velocity of the resonator's elastic motion", "", "", &ResultSummary::v_rms},
    {"summary/shock_rate", "s-1", "shocks a second", "", "", &ResultSummary::shock_rate},
    {"summary/shock_rate_low", "s-1", "lower end of the 95 % interval of the shocks a second", "", "", &ResultSummary::shock_rate_low},
    {"summary/shock_rate_high", "s-1", "upper end of the 95 % interval of the shocks a second", "", "", &ResultSummary::shock_rate_high},
    {"summary/shock_duration_median", "s", "median of the shocks' durations, to 0.1 %", "", "", &ResultSummary::shock_duration_median},
    {"summary/shock_duration_90", "s", "what 90 % of the shocks' durations do not exceed, to 0.1 %", "", "", &ResultSummary::shock_duration_90},
    {"summary/peak_force_median", "N", "median of the shocks' peak forces, to 0.1 %", "", "", &ResultSummary::peak_force_median},
    {"summary/peak_force_90", "N", "what 90 % of the shocks' peak forces do not exceed, to 0.1 %", "", "", &ResultSummary::peak_force_90},
    {"summary/contact_share", "1", "share of the time with any node in contact", "", "", &ResultSummary::contact_share},
    {"summary/nodes_evaluated", "1", "nodes whose gap was evaluated, a step", "", "", &ResultSummary::nodes_evaluated},
    {"summary/energy_residual", "J", "stored and lost energy less the work put in, since the first sample counted", "", "", &ResultSummary::energy_residual},
    {"summary/energy_turnover", "J", "largest of stored energy, loss and works meanwhile", "", "", &ResultSummary::energy_turnover},
    {"summary/energy_closure", "1", "residual over turnover, its size", "", "", &ResultSummary::energy_closure},
    {"summary/step_seconds", "s", "wall time a step", "", "", &ResultSummary::step_seconds},
    {"summary/wall_seconds", "s", "wall time of the run, until this file was closed", "", "", &ResultSummary::wall_seconds},
    {"surface/slider/position", "m", "positions of the slider's nodes from its left end", "surface/slider/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return node_positions(h.slider_height.size() / h.rows, h.spacing); }},
    {"surface/slider/height", "m", "heights of the slider's profile", "surface/slider/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider_height; }, Numbers::real, nullptr, Of::plane},
    {"surface/slider/y", "m", "rows of the slider's nodes from its side", "surface/slider/y", "",
     [](const ResultHeader& h) -> SharedNumbers { return row_positions(h, 0); }, Numbers::real, nullptr, Of::areal},
    {"surface/slider/height", "m", "heights of the slider's map", "surface/slider/y", "surface/slider/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.slider_height; }, Numbers::real, nullptr, Of::areal},
    {"surface/resonator/position", "m", "positions of the resonator's nodes from its left end", "surface/resonator/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return node_positions(h.resonator_height.size() / h.rows, h.spacing); }},
    {"surface/resonator/height", "m", "heights of the resonator's profile", "surface/resonator/position", "",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator_height; }, Numbers::real, nullptr, Of::plane},
    {"surface/resonator/y", "m", "rows of the resonator's nodes under the slider, from its side", "surface/resonator/y", "",
     [](const ResultHeader& h) -> SharedNumbers { return row_positions(h, h.side); }, Numbers::real, nullptr, Of::areal},
    {"surface/resonator/height", "m", "heights of the resonator's map under the slider", "surface/resonator/y", "surface/resonator/position",
     [](const ResultHeader& h) -> SharedNumbers { return h.resonator_height; }, Numbers::real, nullptr, Of::areal},
};
// clang-format on

}  // namespace

std::span<const Entry> entries() { return all_entries; }
std::span<const Group> groups() { return all_groups; }

bool Entry::is_modal() const {
  return is_sampled() && std::string_view{columns}.ends_with("/mode");
}

bool is_kept(const Entry& entry, const ResultHeader& header) {
  return entry.is_of(header.is_areal) && !(entry.is_modal() && header.modes == KeptModes::none);
}

Stored stored_in(const Entry& entry, const ResultHeader& header) {
  if (entry.numbers == Numbers::whole) return Stored::integer64;
  const bool is_time = std::string_view{entry.path} == "time";  // a float cannot tell its samples
  return entry.is_sampled() && !is_time && header.precision == Precision::real32 ? Stored::real32
                                                                                 : Stored::real64;
}

std::size_t column_count(const Entry& entry, const ResultHeader& header) {
  for (const Entry& scale : all_entries)
    if (scale.path == std::string_view{entry.columns} && scale.is_of(header.is_areal))
      return (*source_of<Fixed>(scale))(header).size();
  return 1;
}

}  // namespace ra2d
