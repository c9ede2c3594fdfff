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
  /// Another timing of each that answered.
  void repeat();

 private:
  struct PeerPoint {
    std::size_t row;
    Peer peer;
  };
  PeerRun ask(const Peer& peer, double until, double limit) const;
  void confirm(double limit);
  void first_answers(const Peer& peer, double limit);

  Survey& survey_;
  const StateReference& reference_;
  std::optional<Model> model_;  // of any point: its modes are those of all
  std::optional<Peers> peers_;
  std::vector<PeerPoint> points_;
};

}  // namespace ra2d
