// SPDX-License-Identifier: BSD-3-Clause
#include "host/chart/stability_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "host/base/text.hpp"
#include "host/chart/chart_files.hpp"
#include "host/chart/growth.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"

namespace ra2d {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double least_growth =
    1e-10;  // a step, the least that measure_growth distinguishes from none
constexpr double least_x = 0.01, most_x = 10.0;

/// The texts of a scheme's row. Of the paper: Table 1, "" where it is blank.
struct Row {
  TimeSettings choice;
  const char *name, *type, *free_limit, *contact_limit;
  const char *paper_error, *paper_limit;
};
constexpr Row rows[] = {{{SchemeKind::explicit_euler},
                         "explicit Euler",
                         "explicit",
                         "x <= 2 zeta",
                         "x_c <= 2 zeta_c",
                         "o(tau)",
                         "unstable"},
                        {{SchemeKind::midpoint},
                         "midpoint",
                         "explicit, V staggered",
                         "x < 2 for every zeta",
                         "x_c < 2",
                         "o(tau^2)",
                         "tau < 2/omega"},
                        {{SchemeKind::backward_euler},
                         "backward Euler, old force",
                         "implicit, force explicit",
                         "every x",
                         "x_c < about 2 (1 + zeta_c)",
                         "o(tau^2)",
                         ""},
                        {{SchemeKind::backward_euler, ForceTime::new_time},
                         "backward Euler, new force",
                         "implicit",
                         "every x",
                         "every x_c",
                         "o(tau^2)",
                         ""},
                        {{SchemeKind::heun},
                         "Heun (RK2)",
                         "explicit",
                         "x^3/4 - zeta x^2 + 2 zeta^2 x <= 2 zeta",
                         "as free, of x_c and zeta_c",
                         "o(tau^2)",
                         "tau < sqrt(2)/omega"},
                        {{SchemeKind::rk4},
                         "RK4",
                         "explicit",
                         "|R(z)| <= 1; x <= 2 sqrt(2) at zeta = 0",
                         "as free, of x_c and zeta_c",
                         "o(tau^4)",
                         ""},
                        {{SchemeKind::rk8},
                         "RK8 (Cooper-Verner)",
                         "explicit",
                         "|R(z)| <= 1; x <= 3.002 at zeta = 0",
                         "as free, of x_c and zeta_c",
                         "o(tau^5)",
                         ""},
                        {{SchemeKind::exact},
                         "exact, force held",
                         "closed form",
                         "every x",
                         "x_c < about 4 zeta_c",
                         "not in it",
                         "not in it"},
                        {{SchemeKind::gautschi},
                         "Gautschi",
                         "closed form, V staggered",
                         "every x",
                         "x_c < 2",
                         "not in it",
                         "not in it"}};

double theory_of(const Limit& limit) {
  if (!limit.contact) return mode_limit(limit.choice.scheme, limit.zeta);
  const TrialMode mode(true);
  return mode.omega * contact_limit(limit.choice, mode.joined(limit.zeta), mode.stiffness);
}

double growth_of(const Limit& limit) {
  if (!limit.contact) return std::log(amplification(limit.choice.scheme, limit.zeta, growth_at));
  const TrialMode mode(true);
  return std::log(
      amplification(limit.choice, mode.joined(limit.zeta), mode.stiffness, growth_at / mode.omega));
}

/// `count` values between low and high, both left out, in equal ratios.
std::vector<double> between(double low, double high, int count) {
  std::vector<double> xs;
  for (int i = 1; i <= count; ++i) xs.push_back(low * std::pow(high / low, i / (count + 1.0)));
  return xs;
}

/// Tries steps xs of each limit (none: an empty list), and brackets the first that grows.
void narrow(std::vector<Limit>& limits, const std::vector<std::vector<double>>& xs, int steps) {
  std::vector<GrowthTrial> trials;
  for (std::size_t i = 0; i < limits.size(); ++i)
    for (const double x : xs[i])
      trials.push_back({limits[i].choice, limits[i].contact, limits[i].zeta, x});
  const std::vector<double> growth = measure_growth(trials, steps);
  auto next = growth.begin();
  for (std::size_t i = 0; i < limits.size(); ++i) {
    bool grows = false;
    for (const double x : xs[i]) {
      // not a number: it had left all bounds
      if (!grows && !(*next <= least_growth)) {
        grows = true;
        limits[i].high = x;
      }
      if (!grows) limits[i].low = x;
      ++next;
    }
  }
}

/// Four digits.
std::string digits(double x) {
  return fmt::format("{:.{}f}", x, std::max(0, 3 - static_cast<int>(std::floor(std::log10(x)))));
}

std::string limit_text(double x) { return x == 0 ? "none" : std::isinf(x) ? "every" : digits(x); }

/// The middle of the bracket; in parentheses how far its last digit may be off.
std::string measured_text(const Limit& limit) {
  if (limit.low == 0) return "none";
  if (std::isinf(limit.high)) return "every";
  const double middle = (limit.low + limit.high) / 2, half = (limit.high - limit.low) / 2;
  const double unit = std::pow(10.0, std::floor(std::log10(middle)) - 3);
  return fmt::format("{}({:.0f})", digits(middle), std::ceil(half / unit + 0.5));  // and rounding
}

const Row& row_of(const TimeSettings& choice) {
  return *std::find_if(std::begin(rows), std::end(rows),
                       [&](const Row& row) { return row.choice == choice; });
}

std::string line(std::string text) {
  text.erase(text.find_last_not_of(' ') + 1);
  text += '\n';
  return text;
}

std::string limit_table(const std::vector<Limit>& limits, bool contact) {
  std::vector<double> zetas;
  for (const Limit& limit : limits)
    if (std::find(zetas.begin(), zetas.end(), limit.zeta) == zetas.end())
      zetas.push_back(limit.zeta);
  std::string text(26, ' '), heading = text;
  for (const double zeta : zetas) {
    text += fmt::format("{:^23}", fmt::format("zeta = {:g}", zeta));
    heading += fmt::format("{:>9} | {:<11}", "theory", "measured");
  }
  text = line(text) + line(heading);
  for (const Row& row : rows) {
    std::string cells;
    for (const Limit& limit : limits)
      if (limit.contact == contact && &row_of(limit.choice) == &row)
        cells += fmt::format("{:>9} | {:<11}", limit_text(limit.theory), measured_text(limit));
    text += line(fmt::format("{:<26}{}", row.name, cells));
  }
  for (const Limit& limit : limits)
    if (limit.contact == contact && limit.theory == 0)
      text += fmt::format(
          "  {}, zeta = {:g}: a step of {} = {:g} multiplies the motion by 1 + {:.4e}, measured 1 "
          "+ "
          "{:.4e}\n",
          row_of(limit.choice).name, limit.zeta, contact ? "x_c" : "x", growth_at,
          std::expm1(limit.growth_theory), std::expm1(limit.growth_measured));
  return text;
}

/// Damping ratios from 0 to 1: narrow where small ones matter, and even in the angle of z.
std::vector<double> damping_ratios() {
  std::vector<double> zetas{0.0};
  for (int i = 0; i < 60; ++i) zetas.push_back(std::pow(10.0, -4 + i / 20.0));
  const double first = std::asin(0.1), last = M_PI / 2;
  for (int i = 0; i <= 120; ++i) zetas.push_back(std::sin(first + (last - first) * i / 120));
  zetas.back() = 1.0;
  return zetas;
}

/// A mode and a spring a million times as stiff, which is damped by zeta.
double spring_limit(const TimeSettings& choice, double zeta) {
  constexpr double ratio = 1000;  // of the frequencies
  const JoinedModes joined{{Mode{1.0, ratio * zeta, 1.0}}, {1.0}};
  return ratio * contact_limit(choice, joined, ratio * ratio);
}

/// Those that turn forwards, the slowest first.
std::vector<std::complex<double>> forwards(std::vector<std::complex<double>> motions) {
  std::erase_if(motions, [](const std::complex<double>& value) { return value.imag() < 0; });
  std::sort(motions.begin(), motions.end(),
            [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); });
  return motions;
}

std::string scheme_columns(const TimeSettings& choice) {
  return fmt::format("{},{}", schemes.name(choice.scheme), force_times.name(choice.contact_force));
}

const char* contact_column(bool contact) { return contact ? "closed" : "open"; }

}  // namespace

std::vector<TimeSettings> chart_schemes() {
  std::vector<TimeSettings> choices;
  for (const Row& row : rows) choices.push_back(row.choice);
  return choices;
}

std::vector<Limit> make_limits(const ChartOptions& options) {
  std::vector<Limit> limits;
  for (const bool contact : {false, true})
    for (const Row& row : rows)
      for (const double zeta : options.zetas) {
        Limit limit{.choice = row.choice, .contact = contact, .zeta = zeta};
        limit.theory = theory_of(limit);
        limit.growth_theory = growth_of(limit);
        limit.high = infinity;
        limits.push_back(limit);
      }

  std::vector<GrowthTrial> common;
  for (const Limit& limit : limits)
    common.push_back({limit.choice, limit.contact, limit.zeta, growth_at});
  const std::vector<double> growth = measure_growth(common, options.steps);
  std::vector<std::vector<double>> xs;
  for (std::size_t i = 0; i < limits.size(); ++i) {
    limits[i].growth_measured = growth[i];
    std::vector<double> tried = between(least_x, most_x, 29);
    tried.push_back(least_x);
    tried.push_back(most_x);
    if (limits[i].theory > 0 && std::isfinite(limits[i].theory))
      for (const double share : {0.5, 0.9, 0.99, 1.01, 1.1, 2.0})
        tried.push_back(share * limits[i].theory);
    std::sort(tried.begin(), tried.end());
    xs.push_back(tried);
  }
  narrow(limits, xs, options.steps);
  for (bool open = true; open;) {
    open = false;
    for (std::size_t i = 0; i < limits.size(); ++i) {
      const double low = limits[i].low, high = limits[i].high;
      const bool found = low == 0 || std::isinf(high) || high - low <= options.precision * high;
      xs[i] = found ? std::vector<double>{} : between(low, high, 8);
      open = open || !found;
    }
    if (open) narrow(limits, xs, options.steps);
  }
  return limits;
}

std::string describe(const std::vector<Limit>& limits) {
  std::string text =
      "Time schemes: the paper's Table 1, corrected. x = omega tau of a free mode, x_c = omega_c "
      "tau of a "
      "contact spring,\nzeta_c = zeta omega/omega_c the damping that the mode brings to it.\n\n";
  constexpr const char* columns = "{:<26}{:<25}{:>6}{:>7}   {:<28}{}";
  text += line(fmt::format(columns, "", "type", "stages", "order", "local error", "in the paper"));
  for (const Row& row : rows) {
    const SchemeTable& scheme = scheme_table(row.choice.scheme);
    std::string error = fmt::format("O(tau^{})", scheme.order + 1);
    if (row.choice.scheme == SchemeKind::exact) error = fmt::format("0 free, {} in contact", error);
    text += line(fmt::format(columns, row.name, row.type, scheme.stages, scheme.order, error,
                             row.paper_error));
  }
  constexpr const char* limit_columns = "{:<26}{:<41}{:<23}{}";
  text += "\n";
  text += line(
      fmt::format(limit_columns, "", "stable, a free mode", "in the paper", "stable, in contact"));
  for (const Row& row : rows)
    text += line(
        fmt::format(limit_columns, row.name, row.free_limit, row.paper_limit, row.contact_limit));
  text += "\nA free mode: largest stable x\n";
  text += limit_table(limits, false);
  text +=
      "\nThe same mode held by a contact spring a thousand times as stiff: largest stable x_c\n";
  text += limit_table(limits, true);
  text += fmt::format(
      "\nevery: no growth at any x up to {:g}; none: growth at every x from {:g} on; 2.828(1): "
      "2.828, "
      "the last digit known to 1.\nMeasured on the march itself, from how two motions grow in "
      "up to {} steps.\n",
      most_x, least_x, ChartOptions{}.steps);
  return text;
}

std::string limits_csv(const std::vector<Limit>& limits) {
  std::string text = heading(stability_tables().tables[0]);
  for (const Limit& limit : limits) {
    const SchemeTable& scheme = scheme_table(limit.choice.scheme);
    const TrialMode mode(limit.contact);
    text += fmt::format("{},{},{},{},{:g},{:.9g},{:.9g},{:.9g},{:.9g},{:g},{:.9g},{:.9g}\n",
                        scheme_columns(limit.choice), scheme.order, scheme.stages,
                        contact_column(limit.contact), limit.zeta,
                        limit.zeta * mode.omega_free / mode.omega, limit.theory, limit.low,
                        limit.high, growth_at, limit.growth_theory, limit.growth_measured);
  }
  return text;
}

std::string regions_csv() {
  std::string text = heading(stability_tables().tables[1]);
  for (const Row& row : rows)
    for (const bool contact : {false, true})
      for (const double zeta : damping_ratios()) {
        const double x =
            contact ? spring_limit(row.choice, zeta) : mode_limit(row.choice.scheme, zeta);
        text += fmt::format("{},{},{:.9g},{:.9g},", scheme_columns(row.choice),
                            contact_column(contact), zeta, x);
        text += std::isinf(x)
                    ? std::string(",\n")
                    : fmt::format("{:.9g},{:.9g}\n", -x * zeta, x * std::sqrt(1 - zeta * zeta));
      }
  return text;
}

std::string modes_csv(const Model& model) {
  std::string text = fmt::format("# scene: {}\n# step: {:g} s\n", printable(title(model.scene)),
                                 model.scene.time.step) +
                     heading(stability_tables().tables[2]);
  const auto add = [&](const char* contact, const char* body, std::size_t k,
                       std::complex<double> value) {
    const double size = std::abs(value);
    const std::complex<double> z = value * model.scene.time.step;
    text +=
        fmt::format("{},{},{},{:.9g},{:.9g},{:.9g},{:.9g}\n", contact, body, k, size / (2 * M_PI),
                    size > 0 ? -value.real() / size : 0.0, z.real(), z.imag());
  };
  for (const auto& [name, body] :
       {std::pair<const char*, const Body&>{"resonator", model.resonator},
        {"slider", model.slider}})
    for (std::size_t k = 0; k < body.modes.size(); ++k) {
      const Mode& mode = body.modes[k];
      const std::complex<double> turn =
          std::complex<double>(0, 1) * std::sqrt(std::complex<double>(1 - mode.zeta * mode.zeta));
      add("open", name, k, mode.omega * (-mode.zeta + turn));
    }
  if (model.scene.contact.law != ContactLaw::penalty) return text;
  const std::vector<std::complex<double>> coupled =
      forwards(joined_eigenvalues(most_compliant(model), model.node_stiffness));
  for (std::size_t k = 0; k < coupled.size(); ++k) add("closed", "both", k, coupled[k]);
  return text;
}

}  // namespace ra2d
