// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>

#include "bench/peers/peers.hpp"
#include "bench/peers/plane_equations.hpp"

/// The two integrators. Both march `y` from t = 0 to options.until and fill in the
/// result's counts.
namespace ra2d::peers {

/// The absolute tolerance of each component of the state, over the relative one (PeerOptions).
Eigen::VectorXd natural_scale(const ContactEquations& equations);

/// Of the end's time: closer than this is there.
inline constexpr double end_slack = 1e-15;

/// No step is longer [s], so that none passes over a shock that is not shallow: two radians of the
/// fastest mode with a contact spring closed.
double longest_step(const ContactEquations& equations);

void march_cvode(PlaneEquations& equations, const PeerOptions& options, Eigen::VectorXd& y,
                 PeerResult& result);
void march_dopri5(ContactEquations& equations, const PeerOptions& options, Eigen::VectorXd& y,
                  PeerResult& result);

}  // namespace ra2d::peers
