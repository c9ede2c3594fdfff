// SPDX-License-Identifier: BSD-3-Clause
#include "host/radiation/resistance.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace ra2d {
namespace {

constexpr std::size_t most_lanes = 16;  // frequencies at a time

/// The rest of the wave number k, across; p may pass k by a rounding.
double left_of(double k, double p) { return std::sqrt(std::max(0.0, (k - p) * (k + p))); }

std::vector<LineShape> shapes_along(const Radiator& radiator) {
  std::vector<LineShape> shapes;
  for (const RadiatingMode& mode : radiator.modes) shapes.push_back(mode.along);
  return shapes;
}

}  // namespace

/// Frequencies that are summed side by side.
struct RadiationResistance::Lanes {
  std::vector<double> wave_numbers;  // they rise
  std::vector<double> sums;          // (couple in its place, lane)
};

RadiationResistance::RadiationResistance(const Radiator& radiator, const Air& air, double highest,
                                         const Fineness& fineness)
    : air_{air},
      highest_{2 * M_PI * highest / air.sound_speed},
      fineness_{fineness},
      along_{shapes_along(radiator), radiator.length, radiator.turning_along, highest_, fineness},
      across_{radiator.across, radiator.width, radiator.turning_across, highest_, fineness},
      between_{highest_, radiator.width, fineness},
      panel_{2 * fineness.phase / (radiator.length + radiator.width)} {
  make_groups(radiator);
  make_tables(radiator);
  const auto panels = static_cast<double>(whole_panels(highest_));
  if (panels > 0) points_ = even_points(0, panels * panel_, 2 * fineness.phase / panel_, fineness);
  const auto order = static_cast<std::size_t>(fineness.points);
  const std::size_t numbers = along_.parts() * across_of_.size();
  whole_.resize(numbers * points_.size());
  std::vector<double> here;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    along_.at(points_.at[i], here);
    for (std::size_t n = 0; n < numbers; ++n)
      whole_[(i / order * numbers + n) * order + i % order] = here[n];
  }
}

void RadiationResistance::make_groups(const Radiator& radiator) {
  std::map<std::pair<Parity, Parity>, std::vector<std::size_t>> of_parities;
  for (std::size_t k = 0; k < radiator.modes.size(); ++k) {
    across_of_.push_back(radiator.modes[k].across);
    of_parities[{along_.parities()[k], across_.parities()[across_of_.back()]}].push_back(k);
  }
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Couple>> of_pairs;
  for (auto& [parities, modes] : of_parities) {
    for (std::size_t i = 0; i < modes.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        of_pairs[std::minmax(across_of_[modes[i]], across_of_[modes[j]])].push_back(
            {modes[i], modes[j], couple_count_++});
    groups_.push_back(std::move(modes));
  }
  for (auto& [pair, couples] : of_pairs) {
    pairs_.push_back(pair);
    couples_.push_back(std::move(couples));
  }
}

/// Integrals over the angle of b_a b_b* at q = rest sin(angle), from -pi/2 to pi/2, for every pair
/// of shapes. The integrands have the period pi, so that equal steps converge as fast as Gauss's;
/// -q has the conjugates of q, so that half of the angles are enough.
void RadiationResistance::make_tables(const Radiator& radiator) {
  std::vector<double> transforms;
  for (const double rest : between_.points().at) {
    const int half = 12 + static_cast<int>(std::ceil(rest * radiator.width / 2));
    const std::size_t first = tables_.size(), shapes = radiator.across.size();
    tables_.resize(first + pairs_.size(), 0.0);
    for (int step = 0; step < half; ++step) {
      across_.at(rest * std::sin(M_PI * (step + 0.5) / (2 * half)), transforms);
      for (std::size_t part = 0; part < across_.parts(); ++part)
        for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
          tables_[first + pair] += transforms[part * shapes + pairs_[pair].first] *
                                   transforms[part * shapes + pairs_[pair].second];
    }
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair) tables_[first + pair] *= M_PI / half;
  }
}

void RadiationResistance::across(double rest, double* of_pair) const {
  double weights[most_points_of_rule];
  const double* row = &tables_[between_.weigh(std::min(rest, highest_), weights) * pairs_.size()];
  std::fill_n(of_pair, pairs_.size(), 0.0);
  for (std::size_t n = 0; n < between_.order(); ++n, row += pairs_.size())
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
      of_pair[pair] += weights[n] * row[pair];
}

double RadiationResistance::wave_number(double frequency) const {
  return std::min(highest_, 2 * M_PI * frequency / air_.sound_speed);
}

/// Panels along that end before this wave number. They are the same for all frequencies, and so are
/// the transforms at their points.
std::size_t RadiationResistance::whole_panels(double wave_number) const {
  return static_cast<std::size_t>(std::max(0.0, std::floor(wave_number / panel_)));
}

/// The points from the end of the whole panels to this wave number.
Points RadiationResistance::last_points(double wave_number) const {
  return even_points(static_cast<double>(whole_panels(wave_number)) * panel_, wave_number, 0,
                     fineness_);
}

void RadiationResistance::add_whole_panels(Lanes& lanes) const {
  const std::size_t order = static_cast<std::size_t>(fineness_.points), modes = across_of_.size(),
                    count = lanes.wave_numbers.size();
  // weights times what stands across, (pair, point, lane); zero where the panel is not whole
  std::vector<double> powers(pairs_.size() * order * most_lanes), of_pair(pairs_.size());
  double products[most_points_of_rule];
  for (std::size_t panel = 0; panel < whole_panels(lanes.wave_numbers.back()); ++panel) {
    for (std::size_t i = 0; i < order; ++i) {
      const double p = points_.at[panel * order + i], weight = points_.weight[panel * order + i];
      for (std::size_t lane = 0; lane < count; ++lane) {
        const double k = lanes.wave_numbers[lane];
        if (panel < whole_panels(k))
          across(left_of(k, p), of_pair.data());
        else
          std::fill(of_pair.begin(), of_pair.end(), 0.0);
        for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
          powers[(pair * order + i) * most_lanes + lane] = weight * of_pair[pair];
      }
    }
    const double* const transforms = &whole_[panel * along_.parts() * modes * order];
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
      for (const Couple& couple : couples_[pair]) {
        std::fill_n(products, order, 0.0);
        for (std::size_t part = 0; part < along_.parts(); ++part) {
          const double *const of_k = &transforms[(part * modes + couple.k) * order],
                              *const of_l = &transforms[(part * modes + couple.l) * order];
          for (std::size_t i = 0; i < order; ++i) products[i] += of_k[i] * of_l[i];
        }
        const double* power = &powers[pair * order * most_lanes];
        double sums[most_lanes] = {};
        for (std::size_t i = 0; i < order; ++i, power += most_lanes)
          for (std::size_t lane = 0; lane < most_lanes; ++lane)
            sums[lane] += products[i] * power[lane];
        double* const to = &lanes.sums[couple.place * most_lanes];
        for (std::size_t lane = 0; lane < most_lanes; ++lane) to[lane] += sums[lane];
      }
  }
}

void RadiationResistance::add_last_panel(Lanes& lanes, std::size_t lane) const {
  const double k = lanes.wave_numbers[lane];
  const Points points = last_points(k);
  const std::size_t modes = across_of_.size();
  std::vector<double> here, of_pair(pairs_.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double p = points.at[i];
    along_.at(p, here);
    across(left_of(k, p), of_pair.data());
    for (std::size_t pair = 0; pair < pairs_.size(); ++pair)
      for (const Couple& couple : couples_[pair]) {
        double product = 0;
        for (std::size_t part = 0; part < along_.parts(); ++part)
          product += here[part * modes + couple.k] * here[part * modes + couple.l];
        lanes.sums[couple.place * most_lanes + lane] += points.weight[i] * of_pair[pair] * product;
      }
  }
}

std::vector<std::vector<double>> RadiationResistance::of_groups(
    std::span<const double> frequencies) const {
  std::vector<std::vector<double>> found;
  for (std::size_t first = 0; first < frequencies.size(); first += most_lanes) {
    const auto some = frequencies.subspan(first, std::min(most_lanes, frequencies.size() - first));
    Lanes lanes{{}, std::vector<double>(couple_count_ * most_lanes, 0.0)};
    for (const double frequency : some) lanes.wave_numbers.push_back(wave_number(frequency));
    add_whole_panels(lanes);
    for (std::size_t lane = 0; lane < some.size(); ++lane) {
      if (lanes.wave_numbers[lane] > 0) add_last_panel(lanes, lane);
      // omega density/(4 pi^2), twice: both signs of p give the same
      const double scale = some[lane] * air_.density / M_PI;
      std::vector<double>& of_one = found.emplace_back();
      for (std::size_t place = 0; place < couple_count_; ++place)
        of_one.push_back(scale * lanes.sums[place * most_lanes + lane]);
    }
  }
  return found;
}

std::vector<double> RadiationResistance::lower_half(double frequency) const {
  const std::size_t modes = across_of_.size();
  std::vector<double> found(modes * (modes + 1) / 2, 0.0);
  const std::vector<double> coupled = of_groups({&frequency, 1}).front();
  for (const std::vector<Couple>& couples : couples_)
    for (const Couple& couple : couples)  // k is not below l
      found[couple.k * (couple.k + 1) / 2 + couple.l] = coupled[couple.place];
  return found;
}

double RadiationResistance::of_mode(std::size_t mode, double frequency) const {
  const double k = wave_number(frequency);
  if (!(k > 0)) return 0;
  const std::size_t a = across_of_[mode], modes = across_of_.size();
  const auto pair = static_cast<std::size_t>(
      std::find(pairs_.begin(), pairs_.end(), std::pair{a, a}) - pairs_.begin());
  std::vector<double> here, of_pair(pairs_.size());
  double sum = 0;
  const auto add = [&](const Points& points, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const double p = points.at[i];
      along_.at(p, here);
      across(left_of(k, p), of_pair.data());
      for (std::size_t part = 0; part < along_.parts(); ++part)
        sum += points.weight[i] * of_pair[pair] * here[part * modes + mode] *
               here[part * modes + mode];
    }
  };
  add(points_, whole_panels(k) * static_cast<std::size_t>(fineness_.points));
  add(last_points(k), last_points(k).size());
  return frequency * air_.density / M_PI * sum;
}

double inertia_of_air(const Radiator& radiator, const Air& air, double mass_per_area) {
  // The integral of 1/r over any region of this area is at most that over a disc about its centre,
  // 2 pi radius. So is the norm of the integral operator (Schur), and |cos(k r)/r| <= 1/r.
  const double radius = std::sqrt(radiator.area() / M_PI);
  // Two sides add at most 2 density radius to the mass; half of that is taken off the frequency.
  return air.density * radius / mass_per_area;
}

}  // namespace ra2d
