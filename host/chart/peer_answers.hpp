// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "host/chart/peers.hpp"
#include "host/chart/survey.hpp"

/// The peers' answers: whether the reference is right, and rows of their own.
namespace ra2d {

class PeerAnswers {
 public:
  /// `points`: those that were measured. Without any, and without peers, no peer is run.
  PeerAnswers(Survey& survey, const std::vector<ChartPoint>& points,
              const StateReference& reference);
  /// Another timing of each that answered, of those that are expected to end by `end`.
  void repeat(double end);

 private:
  struct PeerPoint {
    std::size_t row;
    Peer peer;
  };
  /// Wall time [s] of so many seconds of integration, with the start of the program.
  double with_start(double integration) const { return starting_ + integration; }
  PeerRun run(const Peer& peer, double until, double limit);
  void confirm();
  /// The latest run of a peer, and the time [s] that it simulated.
  struct Answered {
    PeerRun run;
    double until = 0;
    double rate() const { return run.seconds / until; }
  };
  Measured row_of(const Peer& peer) const;
  /// The state at one of the instants, as far as it can be had by `end` (Survey::elapsed).
  StateError state_at(const Peer& peer, std::size_t instant, double end, Answered& latest);
  void first_answers(const Peer& peer, double limit);

  Survey& survey_;
  const StateReference& reference_;
  std::optional<Model> model_;  // of any point: its modes are those of all
  std::optional<Peers> peers_;
  double starting_;  // s that a peer takes before and after its integration, of the latest answer
  std::vector<PeerPoint> points_;
};

}  // namespace ra2d
