// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <optional>

#include "host/chart/peers.hpp"
#include "host/chart/survey.hpp"

/// What the peers answer: whether the reference is right, and rows of their own.
namespace ra2d {

class PeerAnswers {
 public:
  /// `points` that were measured: without any, and without peers, nothing is asked.
  PeerAnswers(Survey& survey, const std::vector<ChartPoint>& points,
              const StateReference& reference);
  /// Another timing of each that answered, of those that are expected to end by `end`.
  void repeat(double end);

 private:
  struct PeerPoint {
    std::size_t row;
    Peer peer;
  };
  /// s of wall time that so many seconds of integration take, with the start of the program.
  double with_start(double integration) const { return starting_ + integration; }
  PeerRun ask(const Peer& peer, double until, double limit);
  void confirm();
  void first_answers(const Peer& peer, double limit);

  Survey& survey_;
  const StateReference& reference_;
  std::optional<Model> model_;  // of any point: its modes are those of all
  std::optional<Peers> peers_;
  double starting_ = 1;  // s that a peer takes beside the integration, the longest so far
  std::vector<PeerPoint> points_;
};

}  // namespace ra2d
