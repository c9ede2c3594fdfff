// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cmath>

namespace ra2d {

/// The vibration velocity level 20 log10(v_rms / 1e-9 m/s) [dB] (paper, equation 12); -inf at rest.
inline double level(double v_rms) { return 20.0 * std::log10(v_rms / 1e-9); }

}  // namespace ra2d
