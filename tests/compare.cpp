// SPDX-License-Identifier: BSD-3-Clause
#include "tests/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ra2d::test {
namespace {

std::uint64_t bits(std::int64_t x) { return std::bit_cast<std::uint64_t>(x); }
using test::bits;

/// Two numbers of different bits.
std::string difference(std::int64_t a, std::int64_t b) { return fmt::format("{} and {}", a, b); }

std::string difference(double a, double b) {
  std::string text = fmt::format("{} and {}", a, b);
  if (std::isnan(a) || std::isnan(b)) return text;
  if (a == b) return text + ", which is a zero's sign";
  // doubles in ascending order: how many lie below this one, but for a constant
  const auto rank = [](double x) {
    const std::uint64_t size = bits(std::abs(x));
    return std::signbit(x) ? -static_cast<std::int64_t>(size) : static_cast<std::int64_t>(size);
  };
  const std::uint64_t ulps = bits(rank(std::max(a, b))) - bits(rank(std::min(a, b)));
  return text + fmt::format(", {} ulp{} apart", ulps, ulps == 1 ? "" : "s");
}

}  // namespace

template <class Number>
void Comparison::compare(const std::string& name, const std::vector<Number>& a,
                         const std::vector<Number>& b, const Axes& axes) {
  ++quantities_;
  const std::size_t both = std::min(a.size(), b.size());
  std::size_t first = both, differing = 0;
  for (std::size_t i = both; i-- > 0;)
    if (bits(a[i]) != bits(b[i])) {
      first = i;
      ++differing;
    }
  if (differing == 0 && a.size() == b.size()) return;
  std::string text = name + ": ";
  if (a.size() != b.size()) text += fmt::format("{} and {} numbers; ", a.size(), b.size());
  if (differing == 0) text += "the same up to ";
  const std::size_t row = first / axes.columns;
  const bool timed = row < axes.times.size();
  text += fmt::format("{} {}", axes.row, row);
  if (timed) text += fmt::format(" (t = {:.9g} s)", axes.times[row]);
  if (axes.columns > 1) text += fmt::format(", {} {}", axes.column, first % axes.columns);
  if (differing > 0)
    text += fmt::format(": {}; {} of {} differ", difference(a[first], b[first]), differing, both);
  found_.push_back({timed ? axes.times[row] : std::numeric_limits<double>::infinity(), text});
}

void Comparison::add(const std::string& name, const std::vector<double>& a,
                     const std::vector<double>& b, const Axes& axes) {
  compare(name, a, b, axes);
}

void Comparison::add(const std::string& name, const std::vector<std::int64_t>& a,
                     const std::vector<std::int64_t>& b, const Axes& axes) {
  compare(name, a, b, axes);
}

void Comparison::add(const std::string& name, double a, double b) {
  ++quantities_;
  if (bits(a) != bits(b))
    found_.push_back({std::numeric_limits<double>::infinity(), name + ": " + difference(a, b)});
}

void Comparison::add(const std::string& name, std::int64_t a, std::int64_t b) {
  ++quantities_;
  if (a != b)
    found_.push_back({std::numeric_limits<double>::infinity(), name + ": " + difference(a, b)});
}

void Comparison::add(const Snapshot& a, const Snapshot& b, double tick) {
  add("status", static_cast<std::int64_t>(a.status), static_cast<std::int64_t>(b.status));
  add("last step", a.step, b.step);
  const Axes modes{.row = "mode"};
  add("last resonator displacement", a.resonator_u, b.resonator_u, modes);
  add("last resonator velocity", a.resonator_v, b.resonator_v, modes);
  add("last slider displacement", a.slider_u, b.slider_u, modes);
  add("last slider velocity", a.slider_v, b.slider_v, modes);
  add("sum of squared resonator velocities", a.resonator_square, b.resonator_square, modes);
  add("steps in contact", a.contact_steps, b.contact_steps);
  add("most nodes in contact", a.most_nodes, b.most_nodes);
  add("shocks begun", a.shocks_begun, b.shocks_begun);
  add("last energy", a.energy, b.energy);
  add("last limit of the energy", a.energy_limit, b.energy_limit);
  add("sum of the sliding work", a.sliding_work, b.sliding_work);
  add("sum of the moving forces' work", a.force_work, b.force_work);
  add_shocks("open shocks:", a.open_shocks, b.open_shocks, tick);
  std::vector<double> forces[2];
  for (const OpenShock& shock : a.open_shocks) forces[0].push_back(shock.force);
  for (const OpenShock& shock : b.open_shocks) forces[1].push_back(shock.force);
  add("open shocks: force", forces[0], forces[1], {.row = "shock"});
}

testing::AssertionResult Comparison::result() const {
  if (found_.empty()) return testing::AssertionSuccess() << "nothing differs";
  std::vector<Difference> found = found_;
  std::stable_sort(found.begin(), found.end(),
                   [](const Difference& a, const Difference& b) { return a.when < b.when; });
  constexpr std::size_t most = 10;
  testing::AssertionResult result = testing::AssertionFailure();
  result << found.size() << " of " << quantities_ << " quantities differ:";
  for (std::size_t i = 0; i < std::min(most, found.size()); ++i) result << "\n  " << found[i].text;
  if (found.size() > most) result << "\n  and " << found.size() - most << " more";
  return result;
}

testing::AssertionResult same(const Recording& a, const Recording& b) {
  Comparison comparison;
  const SampleBlock &s = a.samples, &t = b.samples;
  const std::size_t samples = std::max<std::size_t>(1, s.time.size());
  const auto add = [&](const char* name, std::vector<double> SampleBlock::*column,
                       const char* of = "mode") {
    const std::size_t columns = std::max<std::size_t>(1, (s.*column).size() / samples);
    comparison.add(name, s.*column, t.*column,
                   {.row = "sample", .times = s.time, .columns = columns, .column = of});
  };
  add("time", &SampleBlock::time);
  add("resonator displacement", &SampleBlock::resonator_displacement);
  add("resonator velocity", &SampleBlock::resonator_velocity);
  add("slider displacement", &SampleBlock::slider_displacement);
  add("slider velocity", &SampleBlock::slider_velocity);
  add("force", &SampleBlock::force);
  add("nodes in contact", &SampleBlock::nodes);
  add("probe displacement", &SampleBlock::probe_displacement, "probe");
  add("probe velocity", &SampleBlock::probe_velocity, "probe");
  add("slider probe displacement", &SampleBlock::slider_probe_displacement, "probe");
  add("slider probe velocity", &SampleBlock::slider_probe_velocity, "probe");
  add("kinetic energy", &SampleBlock::kinetic);
  add("elastic energy", &SampleBlock::elastic);
  add("contact energy", &SampleBlock::contact);
  add("damping loss", &SampleBlock::damping_loss);
  add("sliding work", &SampleBlock::sliding_work);
  add("load work", &SampleBlock::load_work);
  comparison.add_shocks("shocks:", a.shocks, b.shocks, a.model.tick);
  comparison.add(a.end, b.end, a.model.tick);
  comparison.add("what the energy misses", a.energy.residual, b.energy.residual);
  comparison.add("energy that went through", a.energy.turnover, b.energy.turnover);
  return comparison.result();
}

testing::AssertionResult same(const std::string& name, const std::vector<double>& a,
                              const std::vector<double>& b) {
  Comparison comparison;
  comparison.add(name, a, b);
  return comparison.result();
}

}  // namespace ra2d::test
