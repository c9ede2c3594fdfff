// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "host/beam/beam.hpp"
#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"

namespace {

using namespace ra2d;

constexpr int width = HostLanes::width;
constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // one rounding
using Real = HostLanes::Real;

struct NoTeam {};
const HostLanes lanes{NoTeam{}};

// ---- the series by itself ---------------------------------------------------------------------

TEST(Series, FactorsAreQuotientsOfFactorials) {
  EXPECT_EQ(series_factor(0, 0), 1);
  EXPECT_EQ(series_factor(0, 3), 1);
  EXPECT_EQ(series_factor(1, 0), 1.0 / 24);   // 0!/4!
  EXPECT_EQ(series_factor(1, 3), 1.0 / 840);  // 3!/7!
  EXPECT_EQ(series_factor(2, 1), 1.0 / 362880);
  // 2 x 3 x ... x 21 = 21! has 16 factors of two too many for a rounding; beyond, a few
  EXPECT_NEAR(series_factor(5, 3) * (std::tgamma(24.0) / 6), 1, 16 * u);
}

template <int Q>
void each_term_is_a_power() {
  for (int j = 0; j < 4 * Q; ++j) {
    std::array<double, 4 * Q> q{};
    q[j] = 3;
    for (const double eta : {0.5, -0.5, 1.0, -1.0, 0.0}) {  // whose powers are exact
      EXPECT_EQ(series_value<Q>(q.data(), eta), 3 * std::pow(eta, j)) << "term " << j;
      EXPECT_EQ(series_slope<Q>(q.data(), eta), j == 0 ? 0.0 : 3 * j * std::pow(eta, j - 1));
    }
  }
}

TEST(Series, EachTermIsAPower) {
  each_term_is_a_power<1>();
  each_term_is_a_power<2>();
  each_term_is_a_power<6>();
}

/// Worst errors of value and slope over their bounds.
template <int Q>
void agrees_with_horner() {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<double, 4 * Q> q;
    for (double& each : q) each = uniform(random);
    const double eta = trial == 0 ? 1.0 : trial == 1 ? -1.0 : uniform(random);
    long double value = 0, slope = 0, size = 0, steepness = 0;
    for (int j = 4 * Q - 1; j >= 0; --j) {
      slope = slope * eta + value;  // before value takes its next term: Horner for the derivative
      value = value * eta + q[j];
      if (j > 0) steepness = steepness * std::abs(eta) + j * std::abs(q[j]);
      size = size * std::abs(eta) + std::abs(q[j]);
    }
    // A term passes two fma and one rounded eta^2 in its quad, and per quad an fma and eta^4
    // (three).
    ASSERT_NEAR(series_value<Q>(q.data(), eta), static_cast<double>(value), 4 * Q * u * size);
    // ... here one product j q_j and at most 4 Q - 2 fma.
    ASSERT_NEAR(series_slope<Q>(q.data(), eta), static_cast<double>(slope), 4 * Q * u * steepness);

    std::array<double, width> each;
    lanes.store(each.data(), series_value<Q>(q.data(), Real(eta)));
    for (const double one : each) ASSERT_EQ(one, series_value<Q>(q.data(), eta));
  }
}

TEST(Series, AgreesWithHornerInLongDouble) {
  agrees_with_horner<1>();
  agrees_with_horner<2>();
  agrees_with_horner<6>();
}

// ---- over the modes of a beam -----------------------------------------------------------------

/// The j-th derivative of a mode in long double, from the form that ModeShape documents.
long double derivative(const ModeShape& mode, long double length, long double x, int j) {
  if (mode.beta == 0) return j == 0 ? mode.constant + mode.slope * x : j == 1 ? mode.slope : 0.0L;
  const long double beta = mode.beta, phase = beta * x;
  const long double sine = std::sin(phase), cosine = std::cos(phase);
  const long double even = mode.sine * sine + mode.cosine * cosine;
  const long double odd = mode.sine * cosine - mode.cosine * sine;
  const long double wave[] = {even, odd, -even, -odd};
  const long double left = mode.left * std::exp(-phase) * (j % 2 == 0 ? 1 : -1);
  const long double right = mode.right * std::exp(-beta * (length - x));
  return std::pow(beta, j) * (wave[j % 4] + left + right);
}

/// Bound on |psi| that its derivatives keep, up to powers of beta.
double size_of(const ModeShape& mode, double length) {
  return std::hypot(mode.sine, mode.cosine) + std::abs(mode.left) + std::abs(mode.right) +
         std::max(std::abs(mode.constant), std::abs(mode.constant + mode.slope * length));
}

/// A beam's tables as the kernels read them, each entry rounded once.
template <int K, int Q>
struct Tables {
  Beam beam;
  double chi, radius;
  std::vector<double> quartic, patch, beta_radius, size;
  SceneTables t;

  Tables(Support support, int modes, double spacing) : chi{spacing} {
    BodySpec body;
    body.support = support;
    body.length = 0.3;
    body.thickness = 0.002;
    body.width = 0.2;
    body.young = 210e9;
    body.density = 7800;
    body.modes = modes - (support == Support::free ? 2 : 0);
    beam = make_beam(body);

    // The longest series with its first term left out below half an ulp: (beta radius)^4Q/(4 Q)! <=
    // u.
    const double range = std::pow(std::tgamma(4 * Q + 1.0) * u, 1.0 / (4 * Q));
    const double highest = beam.modes.back().beta;
    t.resonator_modes = modes;
    t.patch_nodes = static_cast<int>(2 * range / (highest * chi) - width - 2);
    EXPECT_GE(t.patch_nodes, 1) << "the test's spacing is too wide";
    const double in_chi = 0.5 * (t.patch_nodes + width) + 1;
    t.patches = static_cast<int>(beam.length / chi) / t.patch_nodes + 1;
    t.inverse_radius = 1 / in_chi;
    t.spacing = chi;
    radius = in_chi * chi;

    quartic.assign(K * width, 0.0);
    patch.assign(static_cast<std::size_t>(t.patches) * 4 * K * width, 0.0);
    for (int k = 0; k < modes; ++k) {
      const ModeShape& mode = beam.modes[k];
      beta_radius.push_back(mode.beta * radius);
      size.push_back(size_of(mode, beam.length));
      quartic[k] = static_cast<double>(std::pow(static_cast<long double>(mode.beta) * radius, 4));
      for (int p = 0; p < t.patches; ++p)
        for (int j = 0; j < 4; ++j)
          patch[(static_cast<std::size_t>(p) * 4 + j) * K * width + k] = static_cast<double>(
              std::pow(static_cast<long double>(radius), j) / std::tgamma(j + 1.0L) *
              derivative(mode, beam.length, centre(p), j));
    }
    t.quartic = quartic.data();
    t.patch = patch.data();
  }
  long double centre(int p) const { return (p + 0.5L) * t.patch_nodes * chi; }
  const double* rows(int p) const {
    return patch.data() + static_cast<std::size_t>(p) * 4 * K * width;
  }
};

/// Modes by number and the packs that hold them.
constexpr int packs(int modes) { return (modes + width - 1) / width; }

/// u_2 on every patch against the sum over the modes, for random amplitudes.
template <int Modes, int Q>
void displacement_is_the_sum_over_the_modes(Support support, double chi) {
  constexpr int K = packs(Modes);
  const Tables<K, Q> table(support, Modes, chi);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int p = 0; p < table.t.patches; ++p) {
    std::array<double, K * width> amplitude{};
    for (int k = 0; k < Modes; ++k) amplitude[k] = uniform(random);
    Real modal[K], quartic[K];
    for (int i = 0; i < K; ++i) {
      modal[i] = lanes.load(amplitude.data() + i * width);
      quartic[i] = lanes.load(table.quartic.data() + i * width);
    }
    double q[4 * Q];
    series_coefficients<HostLanes, K, Q>(lanes, table.rows(p),
                                         ModalPowers<HostLanes, K, Q>(modal, quartic), q);
    // Roundings that a term meets: its table entry; quartic and its product, Q - 1 times; the K fma
    // and the tree over the lanes (width - 1 at the most); the factor, three; the series, 4 Q. One
    // more for the terms left out: half an ulp and what follows it, beta radius/(4 Q + 1) of that
    // each. All of them count on sum_j |psi^(j)| radius^j/j! <= max|psi| exp(beta radius), the
    // exponentials of a free mode included, which grow by as much again towards a patch's edge.
    constexpr int roundings = 1 + 2 * (Q - 1) + K + (width - 1) + 3 + 4 * Q + 2;
    double scale = 0;
    for (int k = 0; k < Modes; ++k)
      scale += std::abs(amplitude[k]) * table.size[k] * std::exp(2 * table.beta_radius[k]);
    for (int i = -8; i <= 8; ++i) {
      const double eta = i / 8.0;
      long double exact = 0;
      for (int k = 0; k < Modes; ++k)
        exact += amplitude[k] * derivative(table.beam.modes[k], table.beam.length,
                                           table.centre(p) + eta * (long double)table.radius, 0);
      ASSERT_NEAR(series_value<Q>(q, eta), static_cast<double>(exact), roundings * u * scale)
          << "patch " << p << ", eta " << eta;
      long double slope = 0, steepness = 0;
      for (int k = 0; k < Modes; ++k) {
        slope += amplitude[k] * (long double)table.radius *
                 derivative(table.beam.modes[k], table.beam.length,
                            table.centre(p) + eta * (long double)table.radius, 1);
        // terms weigh j: (beta radius) exp(beta radius); those left out weigh 4 Q
        const double wave = table.beta_radius[k];
        const double rigid = std::abs(table.beam.modes[k].slope) * table.radius;
        steepness += std::abs(amplitude[k]) *
                     (table.size[k] * (wave * std::exp(2 * wave) + (wave > 0 ? 4 * Q : 0)) + rigid);
      }
      ASSERT_NEAR(series_slope<Q>(q, eta), static_cast<double>(slope), roundings * u * steepness);
    }
  }
}

TEST(SeriesCoefficients, PinnedResonator) {
  displacement_is_the_sum_over_the_modes<1, 2>(Support::pinned, 2e-5);
  displacement_is_the_sum_over_the_modes<19, 2>(Support::pinned, 2e-5);
  displacement_is_the_sum_over_the_modes<60, 6>(Support::pinned, 3e-4);
}

TEST(SeriesCoefficients, FreeResonator) {
  displacement_is_the_sum_over_the_modes<3, 2>(Support::free, 2e-5);
  displacement_is_the_sum_over_the_modes<23, 2>(Support::free, 2e-5);
  displacement_is_the_sum_over_the_modes<60, 6>(Support::free, 3e-4);
}

/// psi and its derivatives about any place, and over a window the cubic that they make.
template <int Modes, int Q>
void expansion_is_taylors(Support support, double chi) {
  constexpr int K = packs(Modes);
  const Tables<K, Q> table(support, Modes, chi);
  const SceneTables& t = table.t;
  // As wide as the march takes it: beta^4 (width/2)^4/4! is two ulp, four roundings.
  const double half_window =
      std::min(0.5, std::pow(24 * 4 * u, 0.25) / (table.beam.modes.back().beta * chi));
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    const int p = std::uniform_int_distribution<int>(0, t.patches - 1)(random);
    double eta = std::uniform_real_distribution<double>(-1, 1)(random);
    if (trial < 2) eta = 2 * trial - 1;
    double position = (p + 0.5) * t.patch_nodes + eta / t.inverse_radius;
    position = std::clamp(position, 0.0, table.beam.length / chi);
    Real shape[4][K];
    expand_modes<HostLanes, K, Q>(lanes, t, p, position, shape);
    std::array<double, K * width> c[4];
    for (int m = 0; m < 4; ++m)
      for (int i = 0; i < K; ++i) lanes.store(c[m].data() + i * width, shape[m][i]);

    for (int k = 0; k < Modes; ++k) {
      const ModeShape& mode = table.beam.modes[k];
      const double wave = table.beta_radius[k];
      // Roundings: the table's, quartic's, the factor's; eta's three turn psi by beta radius each;
      // and repeated synthetic division, 4 Q for each derivative. They count on sum_j C(j, m) |c_j|
      // = (beta radius)^m exp(beta radius)/m! max|psi|; the terms left out on C(4 Q, m) u max|psi|.
      double error[4], unit = 1, factorial = 1, binomial = 1;
      for (int m = 0; m < 4; ++m) {
        const int roundings = 1 + 2 * (Q - 1) + 3 + 3 + 4 * Q * (m + 1);
        const double terms = std::pow(wave, m) * std::exp(2 * wave) / factorial;
        const double rigid = m == 1 ? std::abs(mode.slope) * table.radius : 0;
        error[m] = u * unit *
                   (roundings * (table.size[k] * (m == 0 || wave > 0 ? terms : 0) + rigid) +
                    (wave > 0 ? 2 * binomial * table.size[k] : 0));
        const long double exact =
            derivative(mode, table.beam.length, position * (long double)chi, m) *
            std::pow((long double)chi, m) / factorial;
        ASSERT_NEAR(c[m][k], static_cast<double>(exact), error[m])
            << "mode " << k << ", derivative " << m << ", position " << position;
        unit *= t.inverse_radius;
        factorial *= m + 1;
        binomial *= (4.0 * Q - m) / (m + 1);
      }
      for (const double share : {-1.0, -0.3, 0.4, 1.0}) {
        const double offset = share * half_window;
        const double cubic = std::fma(std::fma(std::fma(c[3][k], offset, c[2][k]), offset, c[1][k]),
                                      offset, c[0][k]);
        const long double exact =
            derivative(mode, table.beam.length, (position + (long double)offset) * chi, 0);
        // beside the coefficients' errors: three fma, and the two ulp (four roundings, with the
        // terms behind and the way to the window's edge a tenth more) that a window is made for
        const double bound = error[0] + error[1] * half_window +
                             error[2] * std::pow(half_window, 2) +
                             error[3] * std::pow(half_window, 3) + (3 + 4.4) * u * table.size[k];
        ASSERT_NEAR(cubic, static_cast<double>(exact), bound) << "mode " << k;
      }
    }
    for (int k = Modes; k < K * width; ++k)
      for (int m = 0; m < 4; ++m) EXPECT_EQ(c[m][k], 0) << "padding";
  }
}

TEST(ExpandModes, PinnedResonator) {
  expansion_is_taylors<1, 2>(Support::pinned, 2e-5);
  expansion_is_taylors<19, 2>(Support::pinned, 2e-5);
  expansion_is_taylors<60, 6>(Support::pinned, 3e-4);
}

TEST(ExpandModes, FreeResonator) {
  expansion_is_taylors<3, 2>(Support::free, 2e-5);
  expansion_is_taylors<23, 2>(Support::free, 2e-5);
  expansion_is_taylors<60, 6>(Support::free, 3e-4);
}

TEST(ExpandModes, APlaceOnTwoPatchesHasOneShape) {
  // A node near an edge may be evaluated on either side: both hold it, to their roundings.
  constexpr int Q = 2, modes = 19, K = packs(modes);
  const Tables<K, Q> table(Support::pinned, modes, 2e-5);
  const double position = 3.0 * table.t.patch_nodes;  // between patches 2 and 3
  Real left[4][K], right[4][K];
  expand_modes<HostLanes, K, Q>(lanes, table.t, 2, position, left);
  expand_modes<HostLanes, K, Q>(lanes, table.t, 3, position, right);
  for (int i = 0; i < K; ++i) {
    std::array<double, width> a, b;
    lanes.store(a.data(), left[0][i]);
    lanes.store(b.data(), right[0][i]);
    for (int lane = 0; lane < width && i * width + lane < modes; ++lane) {
      const int k = i * width + lane;
      const double error =
          (1 + 2 + 3 + 3 + 8 + 2) * u * table.size[k] * std::exp(table.beta_radius[k]);
      EXPECT_NEAR(a[lane], b[lane], 2 * error);
    }
  }
}

}  // namespace
