// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "host/base/errors.hpp"
#include "host/report/folders.hpp"
#include "host/report/html.hpp"
#include "host/report/page.hpp"
#include "host/report/svg_chart.hpp"
#include "host/study/law.hpp"
#include "host/study/ledger.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_series = 5, most_charts = 6;
constexpr std::size_t most_rows = 500;  // of the table of levels

using Place = std::vector<std::size_t>;

std::string unit_text(const StudyAxis& axis) {
  std::string unit = axis.units == "1" ? "" : axis.units;
  if (const std::size_t at = unit.find(" s-1"); at != unit.npos) unit.replace(at, 4, "/s");
  return unit;
}

std::string axis_text(const StudyAxis& axis) {
  const std::string unit = unit_text(axis);
  return unit.empty() ? axis.name : fmt::format("{}, {}", axis.name, unit);
}

std::string count_text(const StudyAnswers& answers) {
  const auto count = [&](RunStatus status) {
    return std::count(answers.status.begin(), answers.status.end(), static_cast<double>(status));
  };
  const auto done = count(RunStatus::done), missing = count(RunStatus::missing);
  return fmt::format("{} runs: {} done, {} failed, {} missing", answers.status.size(), done,
                     static_cast<std::ptrdiff_t>(answers.status.size()) - done - missing, missing);
}

std::string interval(double low, double high, const char* form = "{:.3f} to {:.3f}") {
  return std::isfinite(low) && std::isfinite(high) ? fmt::format(fmt::runtime(form), low, high)
                                                   : "too few runs for one";
}

// ---- the law -----------------------------------------------------------------------------------

std::string law_part(const std::optional<StudyLaw>& law, const std::string& why) {
  std::string text = "<h2>The law</h2>\n";
  if (!law) return text + "<p>" + html(why) + "</p>\n";
  std::string formula = "v<sub>rms</sub> ∝";
  for (const Exponent& e : law->exponents)
    formula += fmt::format(" {}<sup>{:.3f}</sup>", html(e.name), e.value);
  text += fmt::format(
      "<p><b>{}</b></p>\n<div class=\"wide\"><table class=\"means\">\n<tr><th>of</th>"
      "<th>exponent</th><th>95 %</th></tr>\n",
      formula);
  for (const Exponent& e : law->exponents)
    text += fmt::format("<tr><td>{}</td><td>{:.3f}</td><td>{}</td></tr>\n", html(e.name), e.value,
                        interval(e.low, e.high));
  text += fmt::format(
      "</table></div>\n<p class=\"soft\">Least squares of log v<sub>rms</sub> over {} runs; "
      "R² = {:.4f}",
      law->runs, law->explained);
  if (std::isfinite(law->deviation))
    text += fmt::format(", {:.2f} dB from the law to a run", law->deviation);
  text += ".";
  if (law->left_out > 0)
    text += fmt::format(" {} runs without a level are left out.", law->left_out);
  for (const std::string& name : law->pooled)
    text += fmt::format(" All values of {} are taken together.", html(name));
  text += law->seeds > 1
              ? fmt::format(
                    " The intervals are by the {} seeds: runs of one seed share their surfaces.",
                    law->seeds)
              : std::string(" The intervals take each run's deviation for chance of its own.");
  std::string shape = html(describe(law->line)) + ".";
  for (const LocalExponent& change : law->line.changes)
    shape += "<br>" + html(describe(change)) + ".";
  shape.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(shape.front())));
  const std::string paragraph = "<p>" + shape + "</p>\n";
  return text + "</p>\n" +
         (law->line.bends() ? "<div class=\"note\" role=\"note\">\n" + paragraph + "</div>\n"
                            : paragraph);
}

// ---- pictures ----------------------------------------------------------------------------------

/// So many of a list, evenly spread.
template <class T>
std::vector<T> some(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(all[i * (all.size() - 1) / (most - 1)]);
  return chosen;
}

ChartAxis axis_of(const StudyAxis& axis) {
  ChartAxis out;
  out.label = axis_text(axis);
  if (!axis.texts.empty()) {
    out.low = -0.5;
    out.high = static_cast<double>(axis.size()) - 0.5;
    for (std::size_t i = 0; i < axis.size(); ++i)
      out.ticks.emplace_back(static_cast<double>(i), axis.texts[i].substr(0, 14));
    return out;
  }
  const auto [low, high] = std::minmax_element(axis.numbers.begin(), axis.numbers.end());
  out.logarithmic = *low > 0;
  const double room = out.logarithmic ? std::pow(*high / *low, 0.08) : 0.08 * (*high - *low);
  out.low = out.logarithmic ? *low / room : *low - room;
  out.high = out.logarithmic ? *high * room : *high + room;
  std::vector<double> values = axis.numbers;
  std::sort(values.begin(), values.end());
  for (const double value : some(values, 6))
    out.ticks.emplace_back(value, fmt::format("{:g}", value));
  return out;
}

/// The levels, and the ends of their intervals as far as they leave the levels half of the axis.
/// Those of two runs reach over tens of dB.
std::vector<double> with_intervals(std::vector<double> levels,
                                   const std::vector<CombinationMean>& means) {
  const auto [lowest, highest] = std::minmax_element(levels.begin(), levels.end());
  const double room = std::max(5.0, *highest - *lowest) / 2;
  const double low = *lowest - room, high = *highest + room;
  for (const CombinationMean& mean : means)
    if (mean.level.count > 1) {
      levels.push_back(std::max(low, mean.level.low));
      levels.push_back(std::min(high, mean.level.high));
    }
  return levels;
}

/// The level against one dimension, a line of the law for each combination of the others.
class LevelChart {
 public:
  LevelChart(const StudyAnswers& answers, const std::vector<CombinationMean>& means,
             const std::optional<StudyLaw>& law, std::size_t dimension)
      : answers_{answers},
        axis_{answers.axes[dimension]},
        law_{axis_.texts.empty() ? law : std::nullopt},
        dimension_{dimension} {
    for (const CombinationMean& mean : means) {
      if (mean.level.count == 0) continue;
      levels_.push_back(mean.level.mean);
      if (law_) levels_.push_back(law_level(*law_, answers.axes, mean.place));
      Place others = mean.place;
      others[dimension] = 0;
      series_[others].push_back(&mean);
    }
    if (!levels_.empty()) levels_ = with_intervals(levels_, means);
  }

  /// The figure; empty where there are no levels.
  std::string figure() {
    if (levels_.empty()) return {};
    const auto [low, high] = rounded_limits(levels_, 10);
    SvgChart chart(axis_of(axis_), {low, high, false, "level, dB re 1 nm/s", {}},
                   "Level of the study against " + axis_.name);
    std::vector<Place> all;
    for (const auto& [others, members] : series_) all.push_back(others);
    const std::vector<Place> chosen = some(all, most_series);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const double middle = static_cast<double>(chosen.size() - 1) / 2;
      chart.begin_series(i, 8 * (static_cast<double>(i) - middle));
      draw(chart, chosen[i], low, high);
    }
    return fmt::format("<figure>\n{}<figcaption>{}</figcaption>\n</figure>\n", chart.svg(),
                       caption(chosen.size(), all.size()));
  }

 private:
  double at(const CombinationMean& mean) const {
    const std::size_t value = mean.place[dimension_];
    return axis_.texts.empty() ? axis_.numbers[value] : static_cast<double>(value);
  }

  /// Draws the combinations in which the other dimensions have these places.
  void draw(SvgChart& chart, const Place& others, double low, double high) {
    std::vector<const CombinationMean*> members = series_[others];
    std::sort(members.begin(), members.end(),
              [&](const auto* a, const auto* b) { return at(*a) < at(*b); });
    std::vector<double> x, y;
    for (const CombinationMean* mean : members) {
      x.push_back(at(*mean));
      y.push_back(law_ ? law_level(*law_, answers_.axes, mean->place) : mean->level.mean);
      if (mean->level.count > 1)
        chart.whisker(x.back(), std::max(low, mean->level.low), std::min(high, mean->level.high));
      chart.dot(x.back(), mean->level.mean);
    }
    if (axis_.texts.empty() && x.size() > 1) chart.line(x, y, true);
    std::string name;
    for (std::size_t a = 0; a < others.size(); ++a)
      if (a != dimension_ && answers_.axes[a].size() > 1)
        name += fmt::format("{}{} = {}", name.empty() ? "" : ", ", answers_.axes[a].name,
                            value_text(answers_.axes[a], others[a]));
    if (name.empty()) return;
    names_.push_back(name);
    const ChartAxis across = axis_of(axis_);
    const double aside = across.logarithmic  // from the last point to the number of its line
                             ? x.back() * (std::pow(across.high / across.low, 0.05) - 1)
                             : 0.05 * (across.high - across.low);
    chart.note(x.back() + aside, y.back(), std::to_string(names_.size()));
  }

  std::string caption(std::size_t drawn, std::size_t all) const {
    std::string text = fmt::format(
        "<b>Level against {}</b>: means over the seeds with 95 % intervals, "
        "which are cut at the ends of the axis.",
        html(axis_.name));
    if (law_) text += " Dashed: the law.";
    for (std::size_t i = 0; i < names_.size(); ++i)
      text += fmt::format("{} <b class=\"series{}\">{}</b>: {}", i == 0 ? "" : ";", i, i + 1,
                          html(names_[i]));
    if (!names_.empty()) text += ".";
    if (drawn < all) text += fmt::format(" {} of {} combinations are shown.", drawn, all);
    return text;
  }

  const StudyAnswers& answers_;
  const StudyAxis& axis_;
  const std::optional<StudyLaw> law_;  // none: of a dimension of words, too
  const std::size_t dimension_;
  std::map<Place, std::vector<const CombinationMean*>> series_;  // by the place of the others
  std::vector<double> levels_;
  std::vector<std::string> names_;  // of the series that are drawn
};

std::string charts_part(const StudyAnswers& answers, const std::vector<CombinationMean>& means,
                        const std::optional<StudyLaw>& law) {
  std::string charts;
  std::size_t drawn = 0;
  for (std::size_t a = 0; a + 1 < answers.axes.size() && drawn < most_charts; ++a)
    if (answers.axes[a].size() > 1) {
      charts += LevelChart(answers, means, law, a).figure();
      ++drawn;
    }
  return charts.empty() ? charts
                        : "<h2>Pictures</h2>\n<div class=\"columns\">\n" + charts + "</div>\n";
}

// ---- the numbers -------------------------------------------------------------------------------

std::string levels_part(const StudyAnswers& answers, const std::vector<CombinationMean>& means) {
  std::string text = "<h2>Levels</h2>\n<div class=\"wide\"><table class=\"means\">\n<tr>";
  for (std::size_t a = 0; a + 1 < answers.axes.size(); ++a)
    text += fmt::format("<th>{}</th>", html(axis_text(answers.axes[a])));
  text += "<th>runs</th><th>Lv, dB</th><th>95 %</th><th>shocks, 1/s</th><th>95 %</th></tr>\n";
  for (std::size_t i = 0; i < std::min(means.size(), most_rows); ++i) {
    const CombinationMean& mean = means[i];
    text += "<tr>";
    for (std::size_t a = 0; a < mean.place.size(); ++a)
      text += fmt::format("<td>{}</td>", html(value_text(answers.axes[a], mean.place[a])));
    text += fmt::format(
        "<td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", mean.level.count,
        mean.level.count > 0 ? fmt::format("{:.2f}", mean.level.mean) : "–",
        mean.level.count > 1 ? interval(mean.level.low, mean.level.high, "{:.2f} to {:.2f}") : "–",
        mean.shock_rate.count > 0 ? fmt::format("{:.4g}", mean.shock_rate.mean) : "–",
        mean.shock_rate.count > 1
            ? interval(mean.shock_rate.low, mean.shock_rate.high, "{:.4g} to {:.4g}")
            : "–");
  }
  text += "</table></div>\n";
  if (means.size() > most_rows)
    text +=
        fmt::format("<p>The first {} of {} combinations; the table results.h5 has them all.</p>\n",
                    most_rows, means.size());
  return text + "<p class=\"soft\">Means over the seeds, the level's in dB re 1 nm/s.</p>\n";
}

}  // namespace

std::string study_page(const StudyAnswers& answers, const std::string& name,
                       const std::string& command) {
  std::optional<StudyLaw> law;
  std::string why;
  try {
    law = fit_law(answers);
  } catch (const RequestError& fault) {
    why = fault.what();
  }
  const std::vector<CombinationMean> means =
      answers.v_rms.empty() ? std::vector<CombinationMean>() : combination_means(answers);
  std::string body =
      fmt::format("<p class=\"lead\">{}. {}</p>\n", count_text(answers), html(answers.origin));
  body += law_part(law, why) + charts_part(answers, means, law);
  if (!means.empty()) body += levels_part(answers, means);
  body += "<h2>The study</h2>\n";
  body += text_to_copy(
      "The study. Save it as <code>study.toml</code>, and its base under the name that it "
      "has there; then <code>ra2d study study.toml</code> runs it again.",
      "the study", "study", without_folders(answers.study));
  if (!answers.given.empty())
    body += text_to_copy("With these values of <code>--set</code>:", "them", "set",
                         without_folders(answers.given));
  body += text_to_copy("Its base:", "the base", "base", without_folders(answers.base));
  return whole_page("Study: " + html(name), body, command);
}

}  // namespace ra2d
