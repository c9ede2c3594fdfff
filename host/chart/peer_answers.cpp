// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/peer_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/format.hpp"
#include "host/scene/names.hpp"

namespace ra2d {
namespace {

constexpr const char* peer_integrators[] = {"cvode-adams", "cvode-bdf", "dopri5"};
constexpr double peer_tolerances[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
constexpr double starting = 5;       // s that a peer may take beside the integration
constexpr double peer_probe = 1e-5;  // s: what every peer is first asked for

}  // namespace

PeerAnswers::PeerAnswers(Survey& survey, const std::vector<ChartPoint>& points,
                         const StateReference& reference)
    : survey_{survey}, reference_{reference} {
  if (survey_.options.peers.empty() || points.empty() ||
      reference_.setting.law != ContactLaw::penalty) {
    survey_.chart.confirmed = survey_.options.peers.empty()
                                  ? "not confirmed: no peers"
                                  : "not confirmed: the peers know penalty alone";
    return;
  }
  const double share = peer_share * survey_.options.budget;
  model_ = points.front().model;
  peers_.emplace(survey_.options.peers, with(survey_.scene, Method{}));
  survey_.say("the peers confirm the reference");
  confirm(starting + 0.2 * share);
  const double count = std::size(peer_integrators) * 2 * std::size(peer_tolerances);
  // s of one integration; each is asked for the states and, half as long, for every timing
  const double limit = 0.8 * share / count / (1 + 0.5 * survey_.options.repetitions);
  for (const char* integrator : peer_integrators)
    for (const char* nodes : {"candidates", "all"})
      for (const double tolerance : peer_tolerances)
        first_answers({integrator, nodes, tolerance}, limit);
}

PeerRun PeerAnswers::ask(const Peer& peer, double until, double limit) const {
  PeerRun run = peers_->run(peer, until, limit);
  if (run.failure.empty() && !fits(*model_, run.state))
    run.failure = "its state is not one of this scene";
  return run;
}

/// By the tightest that answers in time.
void PeerAnswers::confirm(double limit) {
  std::string failure;
  for (std::size_t t = std::size(peer_tolerances); t-- > 0;) {
    const Peer peer{peer_integrators[0], "candidates", peer_tolerances[t]};
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < survey_.chart.instants.size(); ++i) {
      const PeerRun run = ask(peer, survey_.chart.instants[i].time, limit);
      if (run.failure.empty())
        parts.push_back(fmt::format("{:.1e} ({})",
                                    state_error(*model_, run.state, *reference_.states[i]),
                                    survey_.chart.instants[i].kind));
      else
        failure = run.failure;
    }
    if (parts.empty()) continue;
    survey_.chart.confirmed = fmt::format("{} at tolerance {:g} is apart from it by {}",
                                          peer.integrator, peer.tolerance, fmt::join(parts, ", "));
    return;
  }
  survey_.chart.confirmed = fmt::format("not confirmed: {}", failure);
}

/// States, as far as they are to be had in `limit` seconds of integration each, and the first
/// timing, over as much.
void PeerAnswers::first_answers(const Peer& peer, double limit) {
  survey_.say(fmt::format("{} {:g}, nodes {}", peer.integrator, peer.tolerance, peer.nodes));
  Measured row;
  const bool every = peer.nodes == node_choices.name(Nodes::all);
  row.name = {.program = "ra2d_peers",
              .scheme = peer.integrator,
              .law = contact_laws.name(ContactLaw::penalty),
              .contact_force = continuous_force,
              .nodes = peer.nodes,
              .text = peer.integrator + (every ? ", every node" : "")};
  row.setting.time.tolerance = peer.tolerance;
  row.against = survey_.chart.reference;
  double asked = std::min(peer_probe, survey_.chart.instants.front().time);
  PeerRun run = ask(peer, asked, starting + limit);
  row.left_out = run.failure;
  double rate = run.seconds / asked;
  for (std::size_t i = 0; i < survey_.chart.instants.size() && row.left_out.empty(); ++i) {
    StateError state;
    const double time = survey_.chart.instants[i].time;
    if (rate * time > limit)
      state.note = fmt::format("would take {}", seconds_text(rate * time));
    else if (std::isnan(survey_.chart.reference_error[i]))
      state.note = "nothing has moved by then";
    else
      state.note = (run = ask(peer, time, starting + 2 * limit)).failure;
    if (state.note.empty()) {
      state.error = state_error(*model_, run.state, *reference_.states[i]);
      asked = time;
      rate = run.seconds / time;
    }
    row.states.push_back(state);
  }
  if (row.left_out.empty()) {
    row.stretch = std::clamp(0.5 * limit / rate, asked, survey_.scene.duration);
    run = ask(peer, row.stretch, starting + 2 * limit);
    row.left_out = run.failure;
  }
  if (row.left_out.empty()) {
    row.wall.push_back(run.seconds / row.stretch);
    points_.push_back({survey_.chart.points.size(), peer});
  }
  survey_.chart.points.push_back(std::move(row));
}

void PeerAnswers::repeat() {
  for (const PeerPoint& point : points_) {
    Measured& row = survey_.chart.points[point.row];
    const PeerRun run = ask(point.peer, row.stretch, peer_share * survey_.options.budget);
    if (run.failure.empty()) row.wall.push_back(run.seconds / row.stretch);
  }
}

}  // namespace ra2d
