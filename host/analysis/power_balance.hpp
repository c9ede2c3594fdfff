// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <span>

#include "host/scene/scene.hpp"

namespace ra2d {

/// Energies at the samples of a stretch [J], as a result file has them.
struct EnergyColumns {
  std::span<const double> kinetic, elastic, contact, damping_loss, sliding_work, load_work;
};

/// Mean powers over a stretch [W], and mean energies [J]; NaN without two samples. What is missing
/// from the balance is storing + damping - sliding - load. `given` is what contact forces give to
/// both bodies' motion. Springs lose nothing: what sliding puts in, less what they store. Under
/// multipliers, where impacts lose energy: what damping takes and what kinetic and elastic energy
/// rise by, less what loads put in.
struct PowerBalance {
  double sliding = 0, load = 0, damping = 0, storing = 0, missing = 0, given = 0;
  double kinetic = 0, elastic = 0, contact = 0;
};

/// The balance from the first sample to the last, `seconds` later.
PowerBalance power_balance(const EnergyColumns& energy, double seconds, ContactLaw law);

}  // namespace ra2d
