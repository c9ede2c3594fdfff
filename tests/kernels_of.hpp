// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include "kernels/adaptive/contacts.hpp"
#include "kernels/adaptive/flight.hpp"
#include "kernels/adaptive/overlaps.hpp"
#include "kernels/adaptive/series.hpp"
#include "kernels/candidate_groups.hpp"
#include "kernels/candidates.hpp"
#include "kernels/contact/complementarity.hpp"
#include "kernels/contact/node_contact.hpp"
#include "tests/eight_modes.hpp"

/// Single kernels on the parts of a scene that they use, as a march hands them over.
namespace ra2d::test {

template <int packs>
NodeContact<HostLanes, packs> node_contact_of(const SceneTables& t, SceneState& s,
                                              const HostLanes& on = lanes) {
  return {on,        t.motion, t.faces,  t.slider,           t.patches,
          t.contact, s.marks,  s.caches, s.work.contact_list};
}

template <int packs>
CandidateGroups<HostLanes, packs> candidate_groups_of(const SceneTables& t, SceneState& s) {
  return {lanes,
          t.motion,
          t.faces,
          t.slider,
          t.patches,
          t.bounds,
          s.work.candidates,
          s.work.amplitudes,
          s.carried.sums.evaluated};
}

template <int packs>
Candidates<HostLanes, packs> candidates_of(const SceneTables& t, SceneState& s) {
  return {lanes,
          t.modes,
          t.motion,
          t.faces,
          t.slider,
          t.patches,
          t.contact,
          t.scheme,
          t.bounds,
          s.work.candidates,
          s.work.amplitudes,
          s.work.listed_nodes,
          s.carried.sums.evaluated};
}

template <int packs>
Complementarity<HostLanes, packs> complementarity_of(const SceneTables& t, SceneState& s) {
  return {lanes,
          t.faces,
          t.contact,
          t.bounds,
          node_contact_of<packs>(t, s),
          s.carried.latest_contact,
          s.marks.active_index,
          s.work.active,
          s.work.contact_list,
          s.work.listed_nodes,
          t.interrupted};
}

template <int packs>
Flight<HostLanes, packs> flight_of(const SceneTables& t) {
  return {lanes, t.modes, t.motion, t.bounds, t.adaptive, t.flight};
}

/// Few packs, of wide registers, are compiled without clusters.
template <int packs>
typename ModalSeries<HostLanes, packs>::Clusters clusters_of(const SceneTables& t, SceneState& s,
                                                             const HostLanes& on = lanes) {
  if constexpr (ModalSeries<HostLanes, packs>::has_clusters)
    return {on,         t.motion,           t.faces, t.slider, t.patches,      t.contact,
            t.clusters, s.carried.contacts, s.marks, s.caches, s.work.clusters};
  else
    return {};
}

template <int packs>
ModalSeries<HostLanes, packs> series_of(const SceneTables& t, SceneState& s,
                                        const HostLanes& on = lanes) {
  return {on,
          t.modes,
          t.motion,
          t.contact,
          t.bounds,
          t.adaptive,
          t.forces,
          node_contact_of<packs>(t, s, on),
          clusters_of<packs>(t, s, on),
          s.carried.contacts,
          s.carried.control,
          s.work.series,
          s.work.spans.hulls};
}

template <int packs>
Overlaps<HostLanes, packs> overlaps_of(const SceneTables& t, SceneState& s) {
  return {lanes,
          t.motion,
          t.faces,
          t.slider,
          t.patches,
          t.bounds,
          t.adaptive,
          node_contact_of<packs>(t, s),
          s.carried.contacts,
          s.work.candidates,
          s.work.amplitudes,
          s.work.listed_nodes,
          s.work.search,
          s.work.groups,
          s.carried.sums.evaluated};
}

template <int packs>
Contacts<HostLanes, packs> contacts_of(SceneState& s) {
  return {lanes,
          s.carried.contacts,
          s.work.spans,
          s.work.listed_nodes,
          s.work.search.onsets,
          s.work.search.bernstein};
}

}  // namespace ra2d::test
