// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/body/beam.hpp"
#include "host/device/fill.hpp"
#include "kernels/tables.hpp"
#include "tests/eight_modes.hpp"

namespace ra2d::test {

/// Packs that hold the modes of any scene here.
inline constexpr int packs = (24 + width - 1) / width;

/// A scene's tables, filled in memory of the test's own.
struct Filled {
  Model model;
  PatchSeries series;
  Extents n;
  SceneTables t;
  std::vector<std::vector<double>> arrays;

  explicit Filled(const Scene& scene) : Filled(make_model(scene)) {}
  explicit Filled(Model made, int lanes = packs * width)
      : model{std::move(made)},
        series{choose_series(model, width)},
        n{extents_of(model, series, lanes, width, Capacity())} {
    visit_arrays(t, n, [&](const char*, auto*& array, std::size_t count) {
      using Value = std::remove_reference_t<decltype(*array)>;
      static_assert(sizeof(Value) % sizeof(double) == 0);
      arrays.emplace_back(count * sizeof(Value) / sizeof(double) + 1, 0.0);
      array = reinterpret_cast<Value*>(arrays.back().data());
    });
    fill(t, model, series, n, HostCopy());
  }
  Filled(const Filled&) = delete;

  int modes() const { return static_cast<int>(model.resonator.modes.size()); }
  const BodyMode& mode(int k) const { return model.resonator.modes[k]; }
  /// Bound on |psi| that its derivatives keep, up to powers of beta, and as far as a patch reaches.
  double size(int k) const {
    const BeamShape& m = beam_shape(mode(k));
    const double parts = std::abs(m.constant) + std::abs(m.slope) * model.resonator.length +
                         std::hypot(m.sine, m.cosine) + std::abs(m.left) + std::abs(m.right);
    return parts * std::exp(2 * m.beta / t.patches.inverse_radius * t.motion.spacing);
  }
};

}  // namespace ra2d::test
