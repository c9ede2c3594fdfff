// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/chart/accuracy_chart.hpp"
#include "host/chart/chart_files.hpp"
#include "host/chart/context.hpp"

namespace ra2d {
namespace {

constexpr double targets[] = {1e-2, 1e-3, 1e-4, 1e-6};  // errors of the tables
constexpr double advised[] = {1e-3, 1e-6};              // ... and of the sentence at the end

/// Measure `i` of an error: of the states, one an instant, and of the energy behind them. What
/// impacts take under multipliers is no error.
double error_of(const Measured& point, std::size_t i, std::size_t instants) {
  if (i == instants) return point.name.law == "penalty" ? point.energy_closure : quiet_nan;
  return i < point.states.size() ? point.states[i].error : quiet_nan;
}

std::string number(double value, const char* format = "{:.6g}") {
  return std::isnan(value) ? std::string{} : fmt::format(fmt::runtime(format), value);
}

/// The size of the step or the tolerance alone.
std::string short_size(const Method& setting) {
  return setting.time.tolerance ? fmt::format("tol {:g}", *setting.time.tolerance)
                                : fmt::format("{:g} s", setting.time.step);
}

/// Whether `point` is within an error, and every finer one of its method: a chaotic motion may come
/// close by luck.
bool stays_within(const AccuracyChart& chart, const Measured& point, std::size_t measure,
                  double error) {
  const auto within = [&](const Measured& p) {
    return error_of(p, measure, chart.instants.size()) <= error;
  };
  return within(point) &&
         std::all_of(chart.points.begin(), chart.points.end(), [&](const Measured& finer) {
           return finer.name.text != point.name.text ||
                  finer.setting.time.step > point.setting.time.step ||
                  finer.setting.time.tolerance > point.setting.time.tolerance ||
                  std::isnan(error_of(finer, measure, chart.instants.size())) || within(finer);
         });
}

/// How far timings of one setting lie apart, largest over smallest: in the chart as a whole, from
/// the settings that were timed three times or more. Where there are none it is taken for 1.5.
double scatter_of(const AccuracyChart& chart) {
  double scatter = 1.0;
  bool has_measure = false;
  for (const Measured& point : chart.points) {
    if (point.wall.size() < 3) continue;
    const auto [least, most] = std::minmax_element(point.wall.begin(), point.wall.end());
    scatter = std::max(scatter, *most / *least);
    has_measure = true;
  }
  return has_measure ? scatter : 1.5;
}

/// Whether timings of one point may be as low as another's: their ranges meet. One or two timings
/// say too little of their own scatter: they have the chart's.
bool may_cost_no_more(const Measured& point, const Measured& other, double scatter) {
  const auto range = [&](const Measured& p) {
    const auto [least, most] = std::minmax_element(p.wall.begin(), p.wall.end());
    const double few = p.wall.size() < 3 ? scatter : 1.0;
    return std::pair{*least / few, *most * few};
  };
  return range(point).first <= range(other).second;
}

bool is_looser(const Method& a, const Method& b) {
  return a.time.tolerance && b.time.tolerance ? *a.time.tolerance > *b.time.tolerance
                                              : a.time.step > b.time.step;
}

/// The cheapest point of those that `fits` within an error; null when there is none. A looser
/// setting of a method is not dearer: where the timings do not tell it from the one with the lowest
/// median, it is taken.
template <class Fits>
const Measured* cheapest(const AccuracyChart& chart, std::size_t measure, double error,
                         const Fits& fits) {
  std::vector<const Measured*> fitting;
  for (const Measured& point : chart.points)
    if (!point.wall.empty() && fits(point) && stays_within(chart, point, measure, error))
      fitting.push_back(&point);
  if (fitting.empty()) return nullptr;
  const Measured* const fastest = *std::min_element(
      fitting.begin(), fitting.end(),
      [](const Measured* a, const Measured* b) { return a->wall_median() < b->wall_median(); });
  const Measured* best = fastest;
  const double scatter = scatter_of(chart);
  for (const Measured* point : fitting)
    if (point->name.text == fastest->name.text && is_looser(point->setting, best->setting) &&
        may_cost_no_more(*point, *fastest, scatter))
      best = point;
  return best;
}

/// In six characters: three digits, all before the point where there are more, fewer behind zeros.
std::string time_cell(double seconds) {
  if (seconds >= 999.5) return fmt::format("{:.0f}", seconds);
  std::string text = fmt::format("{:.3g}", seconds);
  for (int digits = 2; digits > 0 && text.size() > 6; --digits)
    text = fmt::format("{:.{}g}", seconds, digits);
  return text;
}
/// Step or tolerance in as few characters as its value allows.
std::string size_cell(const Method& setting) {
  const std::string text = short_size(setting);
  if (!setting.time.tolerance) return text;
  const std::string power = fmt::format("{:.0e}", *setting.time.tolerance);
  return std::stod(power) == *setting.time.tolerance ? "tol " + power : text;
}

/// Rows of one measure: a line a method.
std::string measure_table(const AccuracyChart& chart, std::size_t measure) {
  std::string lines;
  std::vector<std::string> done;
  for (const Measured& row : chart.points) {
    if (std::find(done.begin(), done.end(), row.name.text) != done.end()) continue;
    done.push_back(row.name.text);
    const auto same = [&](const Measured& point) { return point.name.text == row.name.text; };
    double least = quiet_nan;
    for (const Measured& point : chart.points)
      if (same(point)) least = std::fmin(least, error_of(point, measure, chart.instants.size()));
    if (std::isnan(least)) continue;
    lines += fmt::format("  {:<28}", row.name.text);
    for (const double target : targets) {
      const Measured* point = cheapest(chart, measure, target, same);
      lines += fmt::format("{:<20}", point == nullptr
                                         ? std::string("-")
                                         : fmt::format("{} at {} ", time_cell(point->wall_median()),
                                                       size_cell(point->setting)));
    }
    lines += fmt::format("{:.1e}\n", least);
  }
  return lines;
}

std::string heading(const std::string& what) {
  std::string line = fmt::format("\n{}\n  {:<28}", what, "to");
  for (const double target : targets) line += fmt::format("{:<20}", fmt::format("{:g}", target));
  return line + "least\n";
}

/// How many digits behind the point show the first one of an error.
int places(double error) {
  return std::isnan(error) || error <= 0
             ? 2
             : std::clamp(-static_cast<int>(std::floor(std::log10(error))), 0, 2);
}

std::string statistic_text(const Statistic& s, double unit) {
  if (std::isnan(s.mean)) return "-";
  const auto pair = [&](double value, double error, const char* sign) {
    if (std::abs(value / unit) < 0.005 && error / unit < 0.005) return std::string("<0.01");
    const int digits = places(error / unit);
    std::string out =
        fmt::format(fmt::runtime(fmt::format("{{:{}.{}f}}", sign, digits)), value / unit);
    if (!std::isnan(error)) out += fmt::format("+-{:.{}f}", error / unit, digits);
    return out;
  };
  std::string out = pair(s.mean, s.error, "");
  if (!std::isnan(s.difference))
    out += fmt::format(" ({})", pair(s.difference, s.difference_error, "+"));
  return out;
}

std::string long_table(const AccuracyChart& chart) {
  if (chart.long_runs.empty()) return fmt::format("\n{}\n", chart.long_notes);
  std::string text = fmt::format(
      "\nOver {} of sliding, {}; in brackets how far from the first line's\n",
      seconds_text(chart.long_time),
      chart.seeds == 1 ? std::string("one run of each")
                       : fmt::format("mean of {} surfaces and its standard error", chart.seeds));
  text += fmt::format("  {:<35}{:>8}  {:<26}{:<27}{}\n", "", "wall, s/s", "level, dB",
                      "shocks, 1/s", "median, us");
  for (const LongRun& run : chart.long_runs) {
    text += fmt::format("  {:<35}{:>8.3g}  ",
                        fmt::format("{}, {}", run.name.text, short_size(run.setting)), run.wall);
    if (!run.note.empty()) {
      text += run.note;
      text += '\n';
      continue;
    }
    text += fmt::format("{:<26}{:<27}{}\n", statistic_text(run.statistics[level_quantity], 1),
                        statistic_text(run.statistics[shock_rate], 1),
                        statistic_text(run.statistics[shock_duration], 1e-6));
  }
  return text;
}

/// The setting to choose for an error in one measure.
std::string advice(const AccuracyChart& chart, std::size_t measure, double error) {
  const auto ours = [](const Measured& point) {
    return point.name.program == "ra2d" && point.name.law == "penalty";
  };
  if (measure < chart.instants.size() && error < chart.reference_error[measure])
    return fmt::format("to {:g} nothing, for the reference itself is not known that well", error);
  const Measured* point = cheapest(chart, measure, error, ours);
  if (point == nullptr) return fmt::format("to {:g} nothing that was measured", error);
  return fmt::format("to {:g} {} at {} ({:.3g} s a simulated second)", error, point->name.text,
                     short_size(point->setting), point->wall_median());
}

std::string advice(const AccuracyChart& chart) {
  const std::size_t last = chart.instants.size() - 1;
  const auto both = [&](std::size_t measure) {
    return fmt::format("{}, {}", advice(chart, measure, advised[0]),
                       advice(chart, measure, advised[1]));
  };
  return fmt::format("To choose under penalty: for {} {}; for the closure of the energy {}.",
                     chart.instants[last].text, both(last), both(last + 1));
}

/// Breaks at blanks, so that no line is longer than a table's.
std::string wrapped(const std::string& text) {
  constexpr std::size_t most = 116;
  std::string out;
  std::size_t begin = 0;
  while (text.size() - begin > most) {
    std::size_t blank = text.rfind(' ', begin + most);
    if (blank == std::string::npos || blank <= begin) break;
    out.append(text, begin, blank - begin) += '\n';
    begin = blank + 1;
  }
  return out.append(text, begin) += '\n';
}

/// Columns are separated by commas: texts do without.
std::string cell(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string comments(const Context& context) {
  std::string text;
  for (const auto& [what, which] : context) text += fmt::format("# {}: {}\n", what, which);
  return text;
}

std::string setting_columns(const Name& name, const Method& setting) {
  return fmt::format("{},{},{},{},{},{},{}", name.program, name.scheme, name.law,
                     name.contact_force, name.nodes,
                     number(setting.time.step > 0 ? setting.time.step : quiet_nan),
                     number(setting.time.tolerance.value_or(quiet_nan)));
}

/// A fine setting is followed over a shorter stretch, and the closure grows with the time.
std::string closure_heading(const AccuracyChart& chart) {
  double least = quiet_nan, most = quiet_nan;
  for (const Measured& point : chart.points)
    if (!std::isnan(point.energy_closure)) {
      least = std::fmin(least, point.stretch);
      most = std::fmax(most, point.stretch);
    }
  return "closure of the energy" +
         (std::isnan(least) ? std::string()
                            : fmt::format(", each over the stretch that it was timed on, {:.2g} to "
                                          "{:.2g} s: it grows with the time",
                                          least, most));
}

}  // namespace

std::string describe(const AccuracyChart& chart) {
  std::string text =
      "Speed against accuracy: seconds of one thread per simulated second of the cheapest "
      "setting within an error\n";
  for (std::size_t i = 0; i < chart.instants.size(); ++i) {
    text += heading(chart.instants[i].text);
    text += measure_table(chart, i);
  }
  text += heading(closure_heading(chart));
  text += measure_table(chart, chart.instants.size());
  text += long_table(chart);

  std::string reference = fmt::format(
      "States of penalty are measured against {}, which is apart "
      "from the same at {} by",
      chart.reference, chart.reference_check);
  for (std::size_t i = 0; i < chart.instants.size(); ++i)
    reference += fmt::format("{} {} ({})", i > 0 ? "," : "",
                             std::isnan(chart.reference_error[i])
                                 ? std::string("nothing")
                                 : fmt::format("{:.1e}", chart.reference_error[i]),
                             chart.instants[i].kind);
  text += '\n';
  text += wrapped(reference + "; " + chart.confirmed +
                  ". Under multipliers, another model, each scheme's are measured against its own "
                  "finest run at the same time.");
  return text + wrapped(advice(chart));
}

Context chart_context(const Scene& scene, const AccuracyChart& chart) {
  Context context = timing_context();
  context.emplace_back("scene", printable(title(scene)));
  for (std::size_t i = 0; i < chart.instants.size(); ++i) {
    context.emplace_back(chart.instants[i].kind, chart.instants[i].text);
    context.emplace_back(chart.instants[i].kind + " of the reference",
                         number(chart.reference_error[i], "{:.2g}"));
  }
  context.emplace_back("reference", chart.reference);
  context.emplace_back("confirmed", chart.confirmed);
  context.emplace_back("took", seconds_text(chart.seconds));
  return context;
}

std::string points_csv(const AccuracyChart& chart, const Context& context) {
  std::string text = comments(context) + heading(accuracy_tables().tables[0]);
  for (const Measured& point : chart.points)
    for (std::size_t i = 0; i <= chart.instants.size(); ++i) {
      const bool energy = i == chart.instants.size();
      if (energy && point.name.program != "ra2d") continue;
      const bool there = !point.wall.empty();
      std::string how =
          there ? std::string("timed from t = 0 on") : fmt::format("left out: {}", point.left_out);
      if (there && !energy && i < point.states.size()) {
        const StateError& state = point.states[i];
        if (!state.note.empty()) how += "; no state: " + state.note;
        if (state.step > 0) how += fmt::format("; state with a step of {:.9g} s", state.step);
      }
      if (there && energy && std::isnan(point.energy_closure)) how += "; too short for a closure";
      if (there && energy && point.name.law != "penalty")
        how += "; what impacts take is in it and no error";
      const auto [least, most] = std::minmax_element(point.wall.begin(), point.wall.end());
      text += fmt::format(
          "{},{},{},{},{},{},{},{},{},{}\n", setting_columns(point.name, point.setting),
          energy ? "energy" : chart.instants[i].kind,
          number(energy ? point.energy_closure : error_of(point, i, chart.instants.size())),
          cell(energy || !there ? "" : point.against), number(point.wall_median()),
          there ? number(*least) : "", there ? number(*most) : "", point.wall.size(),
          number(there ? point.stretch : quiet_nan), cell(how));
    }
  return text;
}

std::string long_runs_csv(const AccuracyChart& chart, const Context& context) {
  std::string text = comments(context) + heading(accuracy_tables().tables[1]);
  for (const LongRun& run : chart.long_runs)
    for (std::size_t q = 0; q < quantities; ++q) {
      const Statistic& s = run.statistics[q];
      text +=
          fmt::format("{},{},{},{},{},{},{},{:.6g},{},{}\n", setting_columns(run.name, run.setting),
                      quantity_names[q], number(s.mean), number(s.error), number(s.difference),
                      number(s.difference_error), chart.seeds, chart.long_time, number(run.wall),
                      cell(run.reference      ? "what the others are compared with"
                           : run.note.empty() ? chart.long_notes
                                              : run.note));
    }
  return text;
}

}  // namespace ra2d
