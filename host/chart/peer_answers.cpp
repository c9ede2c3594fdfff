// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/peer_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "host/base/format.hpp"
#include "host/scene/names.hpp"

namespace ra2d {
namespace {

constexpr double peer_tolerances[] = {1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
constexpr double peer_probe = 1e-5;  // s simulated, of the first run of each peer

/// All that the peers know, where they cannot solve a scene; else empty.
std::string limit_of_peers(const Scene& scene) {
  if (scene.contact.law != ContactLaw::penalty) return "penalty";
  return scene.faces != Faces::linear ? "linear faces" : "";
}

/// Those that solve a scene. The first of them confirms the reference.
std::vector<std::string> integrators_of(const Scene& scene) {
  if (scene.kind == SceneKind::areal) return {"dopri5"};
  return {"cvode-adams", "cvode-bdf", "dopri5"};
}

}  // namespace

PeerAnswers::PeerAnswers(Survey& survey, const std::vector<ChartPoint>& points,
                         const StateReference& reference)
    : survey_{survey},
      reference_{reference},
      starting_{std::min(1.0, 0.01 * survey.options.budget)} {
  Scene scene = survey_.scene;
  scene.contact.law = reference_.setting.law;
  const std::string limit = limit_of_peers(scene);
  std::string why;
  if (survey_.options.peers.empty())
    why = "no peers";
  else if (!limit.empty())
    why = fmt::format("the peers know {} alone", limit);
  else if (points.empty())
    why = "nothing was measured";
  if (!why.empty()) {
    survey_.chart.confirmed = "not confirmed: " + why;
    return;
  }
  model_ = points.front().model;
  peers_.emplace(survey_.options.peers, with(survey_.scene, Method{}));
  survey_.say("the peers confirm the reference");
  confirm();
  // s of wall time for each; a peer is asked for the states and, half as long, for a timing
  const std::vector<std::string> integrators = integrators_of(scene);
  std::size_t waiting = integrators.size() * 2 * std::size(peer_tolerances);
  for (const std::string& integrator : integrators)
    for (const char* nodes : {"candidates", "all"})
      for (const double tolerance : peer_tolerances)
        first_answers({integrator, nodes, tolerance},
                      survey_.left(peer_end) / static_cast<double>(waiting--));
}

PeerRun PeerAnswers::run(const Peer& peer, double until, double limit) {
  const double begun = survey_.elapsed();
  PeerRun answer = peers_->run(peer, until, limit);
  if (answer.failure.empty()) starting_ = survey_.elapsed() - begun - answer.seconds;
  if (answer.failure.empty() && !fits(*model_, answer.state))
    answer.failure = "its state is not one of this scene";
  return answer;
}

/// Compares the reference with the tightest peer that answers in time.
void PeerAnswers::confirm() {
  std::string failure = "the time was up (--budget)";
  const double end = survey_.elapsed() + 0.3 * survey_.left(peer_end);
  for (std::size_t t = std::size(peer_tolerances); t-- > 0;) {
    const Peer peer{integrators_of(survey_.scene).front(), "candidates", peer_tolerances[t]};
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < survey_.chart.instants.size(); ++i) {
      const double limit = 0.5 * (end - survey_.elapsed());
      if (!reference_.states[i] || !(limit > starting_)) continue;
      const PeerRun answer = run(peer, survey_.chart.instants[i].time, limit);
      if (answer.failure.empty())
        parts.push_back(fmt::format("{:.1e} ({})",
                                    state_error(*model_, answer.state, *reference_.states[i]),
                                    survey_.chart.instants[i].kind));
      else
        failure = answer.failure;
    }
    if (parts.empty()) continue;
    survey_.chart.confirmed = fmt::format("{} at tolerance {:g} is apart from it by {}",
                                          peer.integrator, peer.tolerance, fmt::join(parts, ", "));
    return;
  }
  survey_.chart.confirmed = fmt::format("not confirmed: {}", failure);
}

/// The states that the peer reaches in half of `limit` seconds of wall time, and its first timing
/// in the rest.
void PeerAnswers::first_answers(const Peer& peer, double limit) {
  survey_.say(fmt::format("{} {:g}, nodes {}", peer.integrator, peer.tolerance, peer.nodes));
  Measured row = row_of(peer);
  const double end = survey_.elapsed() + limit;
  const auto left = [&] { return end - survey_.elapsed(); };
  Answered latest{{}, std::min(peer_probe, survey_.chart.instants.front().time)};
  if (left() > with_start(0))
    latest.run = run(peer, latest.until, left());
  else
    latest.run.failure = "not run: the time was up (--budget)";
  row.left_out = latest.run.failure;
  for (std::size_t i = 0; i < survey_.chart.instants.size() && row.left_out.empty(); ++i)
    row.states.push_back(state_at(peer, i, end, latest));
  if (row.left_out.empty()) {
    const double march = 0.5 * (left() - starting_);  // s
    const double duration = survey_.scene.duration;
    row.stretch = std::clamp(march / latest.rate(), std::min(latest.until, duration), duration);
    // where a longer run does not fit, the latest answer is the timing
    if (left() > with_start(latest.rate() * row.stretch))
      latest = {run(peer, row.stretch, left()), row.stretch};
    row.stretch = latest.until;
    row.left_out = latest.run.failure;
  }
  if (row.left_out.empty()) {
    row.wall.push_back(latest.run.seconds / row.stretch);
    points_.push_back({survey_.chart.points.size(), peer});
  }
  survey_.chart.points.push_back(std::move(row));
}

Measured PeerAnswers::row_of(const Peer& peer) const {
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
  return row;
}

StateError PeerAnswers::state_at(const Peer& peer, std::size_t instant, double end,
                                 Answered& latest) {
  const double time = survey_.chart.instants[instant].time;
  const double expected = with_start(latest.rate() * time), left = end - survey_.elapsed();
  StateError state;
  if (!reference_.states[instant])
    state.note = "no reference";
  else if (expected > left)
    state.note = fmt::format("not run: would take {} (--budget)", seconds_text(expected));
  else if (std::isnan(survey_.chart.reference_error[instant]))
    state.note = "nothing has moved by then";
  if (!state.note.empty()) return state;
  const PeerRun answer = run(peer, time, left);
  state.note = answer.failure;
  if (!state.note.empty()) return state;
  state.error = state_error(*model_, answer.state, *reference_.states[instant]);
  latest = {answer, time};
  return state;
}

void PeerAnswers::repeat(double end) {
  for (const PeerPoint& point : points_) {
    Measured& row = survey_.chart.points[point.row];
    const double expected = with_start(row.wall.front() * row.stretch);
    if (!survey_.fits(expected, end)) continue;  // the row says how many there are
    const PeerRun answer = run(point.peer, row.stretch, std::min(2 * expected, survey_.left(end)));
    if (answer.failure.empty()) row.wall.push_back(answer.seconds / row.stretch);
  }
}

}  // namespace ra2d
