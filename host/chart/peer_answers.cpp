// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/peer_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/base/format.hpp"
#include "host/scene/names.hpp"

namespace ra2d {
namespace {

constexpr const char* peer_integrators[] = {"cvode-adams", "cvode-bdf", "dopri5"};
constexpr double peer_tolerances[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
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
  model_ = points.front().model;
  peers_.emplace(survey_.options.peers, with(survey_.scene, Method{}));
  survey_.say("the peers confirm the reference");
  confirm();
  // s of wall time for each; a peer is asked for the states and, half as long, for a timing
  std::size_t waiting = std::size(peer_integrators) * 2 * std::size(peer_tolerances);
  for (const char* integrator : peer_integrators)
    for (const char* nodes : {"candidates", "all"})
      for (const double tolerance : peer_tolerances)
        first_answers({integrator, nodes, tolerance},
                      survey_.left(peer_end) / static_cast<double>(waiting--));
}

PeerRun PeerAnswers::ask(const Peer& peer, double until, double limit) {
  const double begun = survey_.elapsed();
  PeerRun run = peers_->run(peer, until, limit);
  if (run.failure.empty()) starting_ = survey_.elapsed() - begun - run.seconds;
  if (run.failure.empty() && !fits(*model_, run.state))
    run.failure = "its state is not one of this scene";
  return run;
}

/// By the tightest that answers in time.
void PeerAnswers::confirm() {
  std::string failure = "the time was up (--budget)";
  const double end = survey_.elapsed() + 0.3 * survey_.left(peer_end);
  for (std::size_t t = std::size(peer_tolerances); t-- > 0;) {
    const Peer peer{peer_integrators[0], "candidates", peer_tolerances[t]};
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < survey_.chart.instants.size(); ++i) {
      const double limit = 0.5 * (end - survey_.elapsed());
      if (!reference_.states[i] || !(limit > starting_)) continue;
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

/// States, as far as they are to be had in `limit` seconds of wall time, and the first timing, over
/// half as long as is left.
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
  const double end = survey_.elapsed() + limit;
  const auto left = [&] { return end - survey_.elapsed(); };
  PeerRun run, answer;  // the latest one
  if (left() > with_start(0))
    run = ask(peer, asked, left());
  else
    run.failure = "not run: the time was up (--budget)";
  row.left_out = run.failure;
  answer = run;
  double rate = run.seconds / asked;
  for (std::size_t i = 0; i < survey_.chart.instants.size() && row.left_out.empty(); ++i) {
    StateError state;
    const double time = survey_.chart.instants[i].time;
    if (!reference_.states[i])
      state.note = "no reference";
    else if (with_start(rate * time) > left())
      state.note =
          fmt::format("not run: would take {} (--budget)", seconds_text(with_start(rate * time)));
    else if (std::isnan(survey_.chart.reference_error[i]))
      state.note = "nothing has moved by then";
    else
      state.note = (run = ask(peer, time, left())).failure;
    if (state.note.empty()) {
      state.error = state_error(*model_, run.state, *reference_.states[i]);
      asked = time;
      answer = run;
      rate = run.seconds / time;
    }
    row.states.push_back(state);
  }
  if (row.left_out.empty()) {
    const double march = 0.5 * (left() - starting_);  // s
    row.stretch =
        std::clamp(march / rate, std::min(asked, survey_.scene.duration), survey_.scene.duration);
    if (left() > with_start(rate * row.stretch)) {
      run = ask(peer, row.stretch, left());
    } else {  // the latest answer is the timing
      row.stretch = asked;
      run = answer;
    }
    row.left_out = run.failure;
  }
  if (row.left_out.empty()) {
    row.wall.push_back(run.seconds / row.stretch);
    points_.push_back({survey_.chart.points.size(), peer});
  }
  survey_.chart.points.push_back(std::move(row));
}

void PeerAnswers::repeat(double end) {
  for (const PeerPoint& point : points_) {
    Measured& row = survey_.chart.points[point.row];
    const double expected = with_start(row.wall.front() * row.stretch);
    if (!survey_.fits(expected, end)) continue;  // the row says how many there are
    const PeerRun run = ask(point.peer, row.stretch, 2 * expected);
    if (run.failure.empty()) row.wall.push_back(run.seconds / row.stretch);
  }
}

}  // namespace ra2d
