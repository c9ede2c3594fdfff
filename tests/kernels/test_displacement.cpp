// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "host/body/beam.hpp"
#include "kernels/displacement.hpp"
#include "kernels/lanes.hpp"

namespace {

using namespace ra2d;

constexpr int width = HostLanes::width;
constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // one rounding
using Real = HostLanes::Real;

const HostLanes lanes;

// ---- the cubic by itself ----------------------------------------------------------------------

TEST(Cubic, InverseFactorials) {
  EXPECT_EQ(inverse_factorial(0), 1);
  EXPECT_EQ(inverse_factorial(1), 1);
  EXPECT_EQ(inverse_factorial(2), 0.5);
  EXPECT_EQ(inverse_factorial(3), 1.0 / 6);
  EXPECT_EQ(inverse_factorial(7), 1.0 / 5040);
}

TEST(Cubic, EachTermIsAPower) {
  for (int j = 0; j < 4; ++j) {
    std::array<double, 4> q{};
    q[j] = 3;
    for (const double eta : {0.5, -0.5, 1.0, -1.0, 0.0}) {  // whose powers are exact
      EXPECT_EQ(cubic(q.data(), eta), 3 * std::pow(eta, j)) << "term " << j;
      EXPECT_EQ(cubic_slope(q.data(), eta), j == 0 ? 0.0 : 3 * j * std::pow(eta, j - 1));
    }
  }
}

TEST(Cubic, AgreesWithHornerInLongDouble) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<double, 4> q;
    for (double& each : q) each = uniform(random);
    const double eta = trial == 0 ? 1.0 : trial == 1 ? -1.0 : uniform(random);
    long double value = 0, slope = 0, size = 0, steepness = 0;
    for (int j = 3; j >= 0; --j) {
      slope = slope * eta + value;  // before value takes its next term
      value = value * eta + q[j];
      if (j > 0) steepness = steepness * std::abs(eta) + j * std::abs(q[j]);
      size = size * std::abs(eta) + std::abs(q[j]);
    }
    // A term passes three fma at the most; in the slope two, and 3 q_3 is rounded before.
    ASSERT_NEAR(cubic(q.data(), eta), static_cast<double>(value), 3 * u * size);
    ASSERT_NEAR(cubic_slope(q.data(), eta), static_cast<double>(slope), 3 * u * steepness);

    std::array<double, width> values, slopes;
    lanes.store(values.data(), cubic(q.data(), Real(eta)));
    lanes.store(slopes.data(), cubic_slope(q.data(), Real(eta)));
    for (const double one : values) ASSERT_EQ(one, cubic(q.data(), eta));
    for (const double one : slopes) ASSERT_EQ(one, cubic_slope(q.data(), eta));
  }
}

// ---- over the modes of a beam -----------------------------------------------------------------

/// The j-th derivative of a mode in long double, from the form that BeamShape documents.
long double derivative(const BeamShape& mode, long double length, long double x, int j) {
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
double size_of(const BeamShape& mode, double length) {
  return std::hypot(mode.sine, mode.cosine) + std::abs(mode.left) + std::abs(mode.right) +
         std::max(std::abs(mode.constant), std::abs(mode.constant + mode.slope * length));
}

/// A beam's tables as the kernels read them, each entry rounded once.
template <int K>
struct Tables {
  std::vector<BeamShape> shapes;
  double length = 0;
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
    length = body.length;
    for (const BodyMode& mode : make_beam(body).modes) shapes.push_back(beam_shape(mode));

    const double beta_chi = shapes.back().beta * chi;
    t.slider.first_lane = modes;
    t.patches.nodes = std::max(1, static_cast<int>(0.5 / beta_chi - width - 2));
    const double in_chi = 0.5 * (t.patches.nodes + width) + 1;
    t.patches.count = static_cast<int>(length / chi) / t.patches.nodes + 1;
    t.patches.inverse_radius = 1 / in_chi;
    t.motion.spacing = chi;
    radius = in_chi * chi;
    // the first term left out, (beta radius)^terms/terms!, is below half an ulp
    t.patches.terms = 4;
    while (std::pow(beta_chi * in_chi, t.patches.terms) > u * std::tgamma(t.patches.terms + 1.0))
      t.patches.terms += 4;
    EXPECT_LE(t.patches.terms, most_terms) << "the test's spacing is too wide";

    quartic.assign(K * width, 0.0);
    patch.assign(static_cast<std::size_t>(t.patches.count) * 4 * K * width, 0.0);
    for (int k = 0; k < modes; ++k) {
      const BeamShape& mode = shapes[k];
      beta_radius.push_back(mode.beta * radius);
      size.push_back(size_of(mode, length));
      quartic[k] = static_cast<double>(std::pow(static_cast<long double>(mode.beta) * radius, 4));
      for (int p = 0; p < t.patches.count; ++p)
        for (int j = 0; j < 4; ++j)
          patch[(static_cast<std::size_t>(p) * 4 + j) * K * width + k] =
              static_cast<double>(std::pow(static_cast<long double>(radius), j) *
                                  derivative(mode, length, centre(p), j));
    }
    t.patches.quartic = quartic.data();
    t.patches.derivatives = patch.data();
  }
  long double centre(int p) const { return (p + 0.5L) * t.patches.nodes * chi; }
  const double* rows(int p) const {
    return patch.data() + static_cast<std::size_t>(p) * 4 * K * width;
  }
  /// Derivatives of mode k at a place on the resonator [chi], per chi^m.
  long double exact(int k, long double position, int m) const {
    return derivative(shapes[k], length, position * chi, m) *
           std::pow(static_cast<long double>(chi), m);
  }
};

/// Packs that hold so many modes.
constexpr int packs(int modes) { return (modes + width - 1) / width; }

/// u_2 on every patch against the sum over the modes, for random amplitudes: the cubic, with what
/// it leaves out bounded as host/device/batch.cpp bounds it.
template <int Modes>
void cubic_keeps_its_bound(Support support, double chi) {
  constexpr int K = packs(Modes);
  const Tables<K> table(support, Modes, chi);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double tightest = 0;
  for (int p = 0; p < table.t.patches.count; ++p) {
    std::array<double, K * width> amplitude{};
    if (p % 2 == 0)
      for (int k = 0; k < Modes; ++k) amplitude[k] = uniform(random);
    else
      amplitude[p / 2 % Modes] = 1;  // one mode alone
    Real modal[K];
    for (int i = 0; i < K; ++i) modal[i] = lanes.load(amplitude.data() + i * width);
    double q[4];
    series_coefficients<HostLanes, K>(lanes, table.rows(p), modal, q);
    // Roundings that a term meets: its table entry; the K fma and the tree over the lanes; the
    // factor, two; the cubic, 4. They count on sum_j |psi^(j)| radius^j/j! <= max|psi| exp(beta
    // radius), where the exponentials of a free mode grow by as much again towards a patch's edge.
    constexpr int roundings = 1 + K + (width - 1) + 2 + 4;
    double tail = 0, tail_slope = 0, scale = 0, steepness = 0;
    for (int k = 0; k < Modes; ++k) {
      const double a = std::abs(amplitude[k]), wave = table.beta_radius[k];
      const double grown = table.size[k] * std::exp(2 * wave);
      if (wave > 0) tail += a * table.size[k] * std::pow(wave, 4) / 24;
      if (wave > 0) tail_slope += a * table.size[k] * std::pow(wave, 4) / 6;
      scale += a * grown;
      steepness += a * (wave * grown + std::abs(table.shapes[k].slope) * table.radius);
    }
    for (int i = -8; i <= 8; ++i) {
      const double eta = i / 8.0;
      const long double position =
          (p + 0.5L) * table.t.patches.nodes + eta * static_cast<long double>(table.radius) / chi;
      if (position < 0 || position * chi > table.length) continue;  // on the beam alone
      long double value = 0, slope = 0;
      for (int k = 0; k < Modes; ++k) {
        value += amplitude[k] * table.exact(k, position, 0);
        slope += amplitude[k] * table.exact(k, position, 1) / table.t.patches.inverse_radius;
      }
      const double error = std::abs(cubic(q, eta) - static_cast<double>(value));
      ASSERT_LE(error, tail + roundings * u * scale) << "patch " << p << ", eta " << eta;
      ASSERT_NEAR(cubic_slope(q, eta), static_cast<double>(slope),
                  tail_slope + roundings * u * steepness)
          << "patch " << p << ", eta " << eta;
      if (p % 2 == 1 && tail > 1e3 * u * scale) tightest = std::max(tightest, error / tail);
    }
  }
  // What the bound gives away, the march pays for in nodes: a sine alone reaches it, but for
  // (beta radius)^2/30; a free mode's is taken with both its ends at once.
  const double range = table.beta_radius.back();
  EXPECT_GE(tightest, (support == Support::pinned ? 0.98 : 0.4) * (1 - range * range / 30));
}

TEST(SeriesCoefficients, CubicOfAPinnedResonator) {
  cubic_keeps_its_bound<19>(Support::pinned, 2e-5);
  cubic_keeps_its_bound<60>(Support::pinned, 3e-4);
}

TEST(SeriesCoefficients, CubicOfAFreeResonator) {
  cubic_keeps_its_bound<23>(Support::free, 2e-5);
  cubic_keeps_its_bound<60>(Support::free, 3e-4);
}

TEST(SeriesCoefficients, RigidModesAreExact) {
  // A slope and a height are cubics: nothing is left out, five roundings and those of the sums
  // remain.
  const Tables<packs(2)> table(Support::free, 2, 1e-3);
  std::array<double, packs(2) * width> amplitude{0.75, -0.5};
  Real modal[packs(2)];
  for (int i = 0; i < packs(2); ++i) modal[i] = lanes.load(amplitude.data() + i * width);
  double q[4];
  series_coefficients<HostLanes, packs(2)>(lanes, table.rows(0), modal, q);
  const auto &translation = table.shapes[0], &rotation = table.shapes[1];
  for (const double eta : {-0.5, 0.0, 0.25, 1.0}) {
    const long double x = table.centre(0) + eta * static_cast<long double>(table.radius);
    const long double exact =
        0.75L * translation.constant - 0.5L * (rotation.constant + rotation.slope * x);
    EXPECT_NEAR(cubic(q, eta), static_cast<double>(exact), 8 * u * (table.size[0] + table.size[1]));
  }
}

/// psi and its derivatives at any place by the full series, and over a window the cubic that they
/// make.
template <int Modes>
void full_series_is_exact(Support support, double chi) {
  constexpr int K = packs(Modes);
  const Tables<K> table(support, Modes, chi);
  const SceneTables& t = table.t;
  // As wide as the march takes it: beta^4 (width/2)^4/4! is two ulp, four roundings.
  const double half_window =
      std::min(0.5, std::pow(24 * 4 * u, 0.25) / (table.shapes.back().beta * chi));
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 300; ++trial) {
    const int p = std::uniform_int_distribution<int>(0, t.patches.count - 1)(random);
    double eta = std::uniform_real_distribution<double>(-1, 1)(random);
    if (trial < 2) eta = 2 * trial - 1;
    const double position = std::clamp((p + 0.5) * t.patches.nodes + eta / t.patches.inverse_radius,
                                       0.0, table.length / chi);
    Real shape[4][K], value[K];
    expand_modes<HostLanes, K>(lanes, t.patches, p, position, shape);
    mode_values<HostLanes, K>(lanes, t.patches, position, value);
    std::array<double, K * width> c[4], direct;
    for (int i = 0; i < K; ++i) {
      for (int m = 0; m < 4; ++m) lanes.store(c[m].data() + i * width, shape[m][i]);
      lanes.store(direct.data() + i * width, value[i]);
    }
    for (int k = 0; k < Modes; ++k) {
      const BeamShape& mode = table.shapes[k];
      const double wave = table.beta_radius[k], grown = table.size[k] * std::exp(2 * wave);
      // Roundings: the table's, the factor's two, and four for every four terms; eta's three, which
      // turn psi by beta radius each; repeated synthetic division, `terms` for each derivative.
      // They count on sum_j C(j, m) |c_j| = (beta radius)^m exp(beta radius)/m! max|psi|. What is
      // left out counts on C(terms, m) max|psi|: half an ulp, and beta radius/(terms + 1) of it
      // each for what follows.
      double error[4], unit = 1, factorial = 1, binomial = 1;
      for (int m = 0; m < 4; ++m) {
        const int roundings = 1 + 2 + (t.patches.terms - 4) + 3 + t.patches.terms * (m + 1);
        const double rigid = m == 1 ? std::abs(mode.slope) * table.radius : 0;
        const double terms = wave > 0 ? std::pow(wave, m) * grown / factorial
                             : m == 0 ? grown
                                      : rigid;
        error[m] = u * unit * (roundings * terms + (wave > 0 ? 2 * binomial * table.size[k] : 0));
        const long double exact = table.exact(k, position, m) / factorial;
        ASSERT_NEAR(c[m][k], static_cast<double>(exact), error[m])
            << "mode " << k << ", derivative " << m << ", position " << position;
        unit *= t.patches.inverse_radius;
        factorial *= m + 1;
        binomial *= static_cast<double>(t.patches.terms - m) / (m + 1);
      }
      ASSERT_NEAR(direct[k], static_cast<double>(table.exact(k, position, 0)), error[0])
          << "mode " << k << ", position " << position;
      for (const double share : {-1.0, -0.3, 0.4, 1.0}) {
        const double offset = share * half_window;
        const double at_offset = std::fma(
            std::fma(std::fma(c[3][k], offset, c[2][k]), offset, c[1][k]), offset, c[0][k]);
        const long double exact = table.exact(k, position + static_cast<long double>(offset), 0);
        // beside the coefficients' errors: three fma, and the two ulp (four roundings, with what
        // follows them a tenth more) that a window is made for
        double bound = (3 + 4.4) * u * table.size[k];
        for (int m = 0; m < 4; ++m) bound += error[m] * std::pow(half_window, m);
        ASSERT_NEAR(at_offset, static_cast<double>(exact), bound) << "mode " << k;
      }
    }
    for (int k = Modes; k < K * width; ++k) {
      for (int m = 0; m < 4; ++m) ASSERT_EQ(c[m][k], 0) << "padding";
      ASSERT_EQ(direct[k], 0) << "padding";
    }
  }
}

TEST(FullSeries, PinnedResonator) {
  full_series_is_exact<1>(Support::pinned, 2e-5);
  full_series_is_exact<19>(Support::pinned, 2e-5);
  full_series_is_exact<60>(Support::pinned, 3e-4);
}

TEST(FullSeries, FreeResonator) {
  full_series_is_exact<2>(Support::free, 1e-3);
  full_series_is_exact<23>(Support::free, 2e-5);
  full_series_is_exact<60>(Support::free, 3e-4);
}

TEST(FullSeries, LongestThatAResonatorMayNeed) {
  // One node a patch and beta radius near 2: the coarsest nodes that are taken at all.
  const double radius_in_chi = 0.5 * (1 + width) + 1;
  const double chi = 2.0 / radius_in_chi * 0.3 / (40 * std::numbers::pi);
  const Tables<packs(40)> table(Support::pinned, 40, chi);
  EXPECT_EQ(table.t.patches.nodes, 1);
  EXPECT_EQ(table.t.patches.terms, most_terms);
  full_series_is_exact<40>(Support::pinned, chi);
}

TEST(FullSeries, TermsAreScaledDerivatives) {
  // psi^(j+4) = beta^4 psi^(j): c_j j! repeats every four but for the quartic, here 2.
  SceneTables t;
  t.patches.terms = 12;
  const std::vector<double> quartic(width, 2.0);
  t.patches.quartic = quartic.data();
  std::vector<double> rows(4 * width);
  for (int j = 0; j < 4; ++j)
    for (int lane = 0; lane < width; ++lane) rows[j * width + lane] = (j + 1) * (lane + 1);
  Real c[most_terms];
  full_series<HostLanes, 1>(lanes, t.patches, t.patches.terms, rows.data(), 0, c);
  for (int j = 0; j < 12; ++j) {
    std::array<double, width> out;
    lanes.store(out.data(), c[j]);
    for (int lane = 0; lane < width; ++lane) {
      const double exact = (j % 4 + 1) * (lane + 1) * std::exp2(j / 4) / std::tgamma(j + 1.0);
      // the factor's two, each pass two and the rounded reciprocal; tgamma's own and its quotient
      EXPECT_NEAR(out[lane], exact, (3 + 3 * (j / 4) + 4) * u * exact) << "term " << j;
    }
  }
}

TEST(FullSeries, APlaceOnTwoPatchesHasOneShape) {
  // A node near an edge may be evaluated on either side: both hold it, to their roundings.
  constexpr int modes = 19, K = packs(modes);
  const Tables<K> table(Support::pinned, modes, 2e-5);
  const double position = 3.0 * table.t.patches.nodes;  // between patches 2 and 3
  Real left[4][K], right[4][K];
  expand_modes<HostLanes, K>(lanes, table.t.patches, 2, position, left);
  expand_modes<HostLanes, K>(lanes, table.t.patches, 3, position, right);
  const int roundings = 1 + 2 + (table.t.patches.terms - 4) + 3 + table.t.patches.terms + 2;
  for (int i = 0; i < K; ++i) {
    std::array<double, width> a, b;
    lanes.store(a.data(), left[0][i]);
    lanes.store(b.data(), right[0][i]);
    for (int lane = 0; lane < width && i * width + lane < modes; ++lane) {
      const int k = i * width + lane;
      EXPECT_NEAR(a[lane], b[lane],
                  2 * roundings * u * table.size[k] * std::exp(table.beta_radius[k]));
    }
  }
}

}  // namespace
