// SPDX-License-Identifier: BSD-3-Clause
#include "host/savings/savings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "host/device/backend.hpp"
#include "host/errors.hpp"
#include "host/format.hpp"
#include "host/plan/plan.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

using Clock = std::chrono::steady_clock;
using Runs = std::shared_ptr<Ensemble>;

constexpr double reference_tolerance = 1e-10;
constexpr int first_pairs = 4, sure_pairs = 8;  // before a trial is judged, before it is given up
constexpr double samples_per_run = 100;         // for the energy; what a file would hold costs time

// Until when each part may go on, as shares of the budget.
constexpr double numerics_end = 0.45, modes_end = 0.6, slider_end = 0.65, spacing_end = 0.73,
                 together_end = 0.88;
// ... and the most that one scheme and step may take
constexpr double numerics_share = 0.06;
// of which the reference takes so much for its first runs
constexpr double reference_share = 0.25;

/// A scheme with its step or tolerance, and what it costs.
struct Numerics {
  TimeSettings time;
  double cost = 0;  // as of Ensemble, expected
};

std::string text_of(const Scene& scene) {
  return fmt::format("{}, {}", short_text(choice_of(scene)),
                     is_adaptive(scene)
                         ? fmt::format("{:g}", scene.time.tolerance.value_or(usual_tolerance))
                         : seconds_text(scene.time.step));
}

/// 1, 2 and 5 times powers of ten, downwards from at most `largest`.
std::vector<double> ladder(double largest, double smallest) {
  std::vector<double> steps;
  for (int power = static_cast<int>(std::floor(std::log10(largest))); power > -15; --power)
    for (const int digit : {5, 2, 1}) {
      // read as it will be written, 2e-07 and not twice what 1e-07 is rounded to
      const double step = std::stod(fmt::format("{}e{}", digit, power));
      if (step > largest * (1 + 1e-9)) continue;
      if (step < smallest * (1 - 1e-9)) return steps;
      steps.push_back(step);
    }
  return steps;
}

int elastic_modes(const Beam& beam) {
  return static_cast<int>(std::count_if(beam.modes.begin(), beam.modes.end(),
                                        [](const ModeShape& m) { return m.omega > 0; }));
}

std::string modes_text(const BodySpec& body, int modes) {
  return modes == 0 ? std::string("no elastic mode")
                    : fmt::format("{} elastic, up to {:.4g} kHz", modes,
                                  1e-3 * elastic_frequency(body, modes - 1));
}

/// The first sentence of a message, without what counts its faults.
std::string first_sentence(std::string text) {
  const auto line = text.find('\n');
  if (line != std::string::npos && text.find(" fault") < line) text = text.substr(line + 1);
  return text.substr(0, std::min(text.find('\n'), text.find(". ")));
}

class Search {
 public:
  Search(const Scene& scene, const SavingsOptions& options)
      : written_{scene}, options_{options}, begun_{Clock::now()} {
    out_.accuracy = options.accuracy;
    out_.written = out_.chosen = scene;
    plain_ = scene.time;
    plain_.force = false;
    plain_.nodes = Nodes::candidates;  // the answer is the same
  }
  Savings run();

 private:
  double spent() const {
    return std::chrono::duration<double>(Clock::now() - begun_).count() / options_.budget;
  }
  double left(double end) const { return (end - spent()) * options_.budget; }
  void say(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  Scene for_runs(Scene scene) const {
    scene.duration = out_.duration;
    scene.output.rate = std::min(scene.output.rate, samples_per_run / scene.duration);
    scene.output.probes.clear();
    return scene;
  }
  Scene marched(const TimeSettings& time) const {
    Scene scene = written_;
    scene.time = time;
    return scene;
  }
  TimeSettings adaptive(double tolerance) const {
    TimeSettings time = plain_;
    time.scheme = SchemeKind::adaptive;
    time.tolerance = tolerance;
    return time;
  }
  Runs runs_of(const Scene& scene) const { return std::make_shared<Ensemble>(for_runs(scene)); }

  void set_reference();
  void find_numerics();
  std::vector<Numerics> numerics() const;
  void find_modes(const char* key, BodySpec Scene::*body, const Beam& beam, double end);
  void find_spacing();
  void take_together();
  void look_beyond();
  void measure_costs();
  Trial try_out(Trial trial, const Runs& base, double end, double expected_cost = 0);
  Trial changed(const std::string& key, const std::string& what, std::function<void(Scene&)> change,
                const Scene& from) const;

  Scene written_;       // with all that the search needs said
  TimeSettings plain_;  // its own, as far as the answer goes
  const SavingsOptions options_;
  const Clock::time_point begun_;
  Savings out_;
  Runs reference_, base_;  // base_: with the numerics that were chosen
  Runs last_;              // of the last trial
};

/// Whether the scene can be marched; throws RequestError.
void require_possible(const Scene& scene) {
  const Scene read = parse_scene(echo(scene), scene.file);
  if (is_adaptive(read)) return;
  const Model model = make_model(read);
  const std::string beyond = beyond_limit(model, step_limits(model, choice_of(read)));
  if (!beyond.empty()) throw RequestError(beyond);
}

Trial Search::changed(const std::string& key, const std::string& what,
                      std::function<void(Scene&)> change, const Scene& from) const {
  Trial trial;
  trial.key = key;
  trial.what = what;
  trial.scene = from;
  change(trial.scene);
  trial.change = std::move(change);
  return trial;
}

Trial Search::try_out(Trial trial, const Runs& base, double end, double expected_cost) {
  say(fmt::format("{}: {}", trial.key, trial.what));
  const double asked = options_.accuracy;
  Runs runs;
  const auto time_of = [&](double pairs) {
    const double own = runs && runs->runs() > 0
                           ? runs->seconds_per_run()
                           : std::max(expected_cost * out_.duration / backend_threads(),
                                      expected_cost > 0 ? 0.0 : base->seconds_per_run());
    return std::max(0.0, pairs - (runs ? runs->runs() : 0)) * own +
           std::max(0.0, pairs - base->runs()) * base->seconds_per_run();
  };
  if (time_of(first_pairs) > std::max(left(end), 0.0) + 0.02 * options_.budget) {
    trial.why = fmt::format("not run: {} pairs would take {}", first_pairs,
                            seconds_text(time_of(first_pairs)));
    return trial;
  }
  try {
    if (trial.key != "as written") require_possible(trial.scene);
    runs = runs_of(trial.scene);
    const bool alone = out_.runs == 1;
    for (int pairs = alone ? 1 : first_pairs;;) {
      base->extend(pairs);
      runs->extend(pairs);
      if (const std::string failure = runs->failure();
          !failure.empty() && base->failure() != failure) {
        trial.verdict = Verdict::moved;
        trial.why = failure;
        break;
      }
      trial.verdict = Verdict::kept;
      double wanted = 0;
      for (std::size_t q = 0; q < trial.moved.size(); ++q) {
        trial.moved[q] = movement(base->answers(), runs->answers(), quantities_of_answer[q]);
        const Verdict verdict = judge(trial.moved[q], asked);
        if (verdict == Verdict::open)
          wanted = std::max(wanted, pairs_needed(trial.moved[q], asked));
        if (verdict == Verdict::moved || trial.verdict == Verdict::kept) {
          if (trial.verdict != Verdict::moved) trial.verdict = verdict;
        }
      }
      if (trial.verdict != Verdict::open || alone) break;
      const double longer = time_of(wanted);
      if (pairs >= sure_pairs && (longer > 1.5 * left(end) || left(end) <= 0)) {
        trial.why = std::isfinite(longer) && longer < 1e7
                        ? fmt::format("open: to tell takes some {:.2g} pairs, {} more", wanted,
                                      seconds_text(longer))
                        : "open: it moves about as far as is allowed";
        break;
      }
      if (left(end) <= 0) {
        trial.why = "open: the time was up";
        break;
      }
      pairs = static_cast<int>(std::clamp(std::ceil(1.1 * wanted), pairs + 1.0, 2.0 * pairs));
    }
    trial.cheaper = base->cost() / runs->cost();
    trial.first = movement(base->answers(), runs->answers(), &Answer::first_duration);
    for (const Answer& a : runs->answers()) trial.closure += a.closure / runs->runs();
  } catch (const RequestError& fault) {
    trial.verdict = Verdict::moved;
    trial.why = "cannot be run: " + first_sentence(fault.what());
  }
  last_ = runs;
  return trial;
}

void Search::set_reference() {
  Scene& reference = out_.reference = written_;
  if (written_.contact.law == ContactLaw::penalty) {
    reference.time = adaptive(reference_tolerance);
  } else {
    reference.time.step = written_.time.step / 10;
    reference.time.force = false;
  }
  try {
    require_possible(reference);
  } catch (const RequestError& fault) {
    // only of fixed steps, for a scene that was read
    const StepLimits limits = step_limits(make_model(reference), choice_of(reference));
    throw refusal(
        written_, "time.scheme",
        fmt::format("the reference would be the scene's own scheme at a tenth of its step, and {}. "
                    "{}",
                    fault.what(), step_cure(reference, limits.holds())));
  }
  if (const std::string overlap = overlap_at_start(make_model(reference)); !overlap.empty())
    throw refusal(written_, "scene.gap", overlap);
  say("the reference");
  out_.duration = written_.duration;
  const double wall = reference_share * options_.budget;
  const double cost = measure_cost(for_runs(reference), 0.1 * wall);
  const double longest = wall * backend_threads() / (2 * sure_pairs * cost);
  if (longest < out_.duration) {
    // whole milliseconds where there are any, for people
    out_.duration = longest > 1e-2 ? std::floor(longest * 1e3) * 1e-3 : longest;
    if (!is_adaptive(reference))  // a whole number of steps
      out_.duration =
          std::max(1.0, std::floor(out_.duration / reference.time.step)) * reference.time.step;
    // what is counted must be worth counting
    const double counted = out_.duration - written_.output.from;
    if (written_.output.from > 0 && counted < 0.1 * (written_.duration - written_.output.from))
      throw refusal(
          written_, "output.from",
          fmt::format("{} s are not counted, and in the time given a run of the reference comes to "
                      "{} only: expected a larger --budget, or an earlier time",
                      written_.output.from, seconds_text(longest)));
    out_.notes.push_back(
        fmt::format("the runs were cut short at {} of the scene's {}: a run of the reference takes "
                    "{} (--budget "
                    "allows more)",
                    seconds_text(out_.duration), seconds_text(written_.duration),
                    seconds_text(cost * written_.duration)));
  }
  reference_ = runs_of(reference);
  out_.runs = varied(written_).empty() ? 1 : first_pairs;
  reference_->extend(out_.runs);
  if (!reference_->failure().empty() &&
      std::all_of(reference_->answers().begin(), reference_->answers().end(),
                  [](const Answer& a) { return !a.failure.empty(); }))
    throw SimulationError(fmt::format("the reference, {}, did not reach its end: {}",
                                      text_of(reference), reference_->failure()));
}

/// All schemes and steps that cost less than the reference, by what they cost.
std::vector<Numerics> Search::numerics() const {
  std::vector<Numerics> list;
  const bool spring = written_.contact.law == ContactLaw::penalty;
  const double probe = 0.002 * options_.budget;
  Scene reference = out_.reference;
  reference.time.nodes = Nodes::candidates;
  double most = measure_cost(for_runs(reference), probe);
  if (spring)
    for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
      Numerics n{adaptive(tolerance)};
      n.cost = measure_cost(for_runs(marched(n.time)), probe);
      most = std::max(most, n.cost);
      list.push_back(n);
    }
  const Model model = make_model(out_.reference);
  const JoinedModes place = most_yielding(model);
  for (const TimeSettings& choice : choices_under(written_.contact.law)) {
    // what an impact gives back is the scheme's under multipliers: two let it rest alike
    if (!spring && choice.scheme != written_.time.scheme &&
        !(is_semi_implicit(choice.scheme) && is_semi_implicit(written_.time.scheme)))
      continue;
    // a shock in fewer than two steps is none
    double largest = std::min(
        {step_limits(model, choice, place).holds(), 1 / written_.output.rate, out_.duration});
    if (spring) largest = std::min(largest, M_PI / contact_frequency(model, place) / 2);
    if (!(largest > 0)) continue;
    double per_step = 0;
    for (const double step : ladder(largest, spring ? 1e-11 : written_.time.step)) {
      Numerics n{plain_};
      n.time.scheme = choice.scheme;
      if (spring && choice.scheme == SchemeKind::backward_euler)
        n.time.contact_force = choice.contact_force;
      n.time.step = step;
      if (per_step == 0) {
        try {
          per_step = measure_cost(for_runs(marched(n.time)), probe) * step;
        } catch (const RequestError&) {
          break;
        }
      }
      n.cost = per_step / step;
      if (spring && n.cost > most) break;
      list.push_back(n);
    }
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Numerics& a, const Numerics& b) { return a.cost < b.cost; });
  return list;
}

/// How much shorter a step must be before it is worth another run: across impacts no scheme gains
/// more than the square of that.
double shortening(const Trial& trial, double asked) {
  double most = asked;
  for (const Movement& m : trial.moved) most = std::max(most, std::abs(m.relative) - m.margin());
  if (trial.verdict == Verdict::open) most = std::max(most, trial.closure);
  // of what is far off altogether no more is known than that
  return std::min(0.6, std::sqrt(asked / std::min(most, std::max(0.3, asked))));
}

void Search::find_numerics() {
  say("what the schemes cost");
  std::vector<Numerics> list = numerics();
  std::optional<Trial> found;
  const auto attempt = [&](const Numerics& n, double end) {
    const auto change = [time = n.time](Scene& s) { s.time = time; };
    Trial trial = try_out(changed("time", text_of(marched(n.time)), change, written_), reference_,
                          end, n.cost);
    trial.by_balance = trial.verdict == Verdict::open && trial.first.pairs > 0 &&
                       trial.closure <= options_.accuracy &&
                       judge(trial.first, options_.accuracy) == Verdict::kept;
    const bool enough = trial.verdict == Verdict::kept || trial.by_balance;
    if (enough && !(found && found->cheaper >= trial.cheaper)) {
      found = trial;
      base_ = last_;
    }
    return trial;
  };

  // first what will do if anything does, so that there is time for it
  Numerics safe{written_.contact.law == ContactLaw::penalty ? adaptive(usual_tolerance) : plain_};
  safe.cost = measure_cost(for_runs(marched(safe.time)), 0.004 * options_.budget);
  out_.trials.push_back(attempt(safe, spent() + 2 * numerics_share));

  std::map<std::string, double> longest;  // worth trying, by scheme
  std::size_t left_out = 0;
  for (const Numerics& n : list) {
    if (n.cost >= safe.cost && found) break;
    if (n.time == safe.time) continue;
    if (found && found->what != out_.trials.front().what)
      break;  // by cost the first that does is the cheapest
    const std::string name = fmt::format("{} {}", static_cast<int>(n.time.scheme),
                                         static_cast<int>(n.time.contact_force));
    if (longest.contains(name) && n.time.step > longest[name] * (1 + 1e-9)) continue;
    Trial trial;
    if (spent() < numerics_end)
      trial = attempt(n, std::min(numerics_end, spent() + numerics_share));
    if (trial.moved[0].pairs == 0 && trial.verdict == Verdict::open) {
      ++left_out;
      continue;
    }
    if (!is_adaptive(n.time)) longest[name] = n.time.step * shortening(trial, options_.accuracy);
    out_.trials.push_back(std::move(trial));
  }
  if (left_out > 0)
    out_.notes.push_back(fmt::format(
        "{} more schemes and steps that may be cheaper were not tried for want of time (--budget)",
        left_out));
  if (!found) {
    base_ = reference_;
    out_.notes.push_back(
        "no cheaper scheme or step could be shown to do: the scene keeps its own (see --budget)");
    return;
  }
  found->change(out_.chosen);
  for (Trial& trial : out_.trials) trial.taken = trial.what == found->what;
}

void Search::find_modes(const char* key, BodySpec Scene::*body, const Beam& beam, double end) {
  const int kept = elastic_modes(beam);
  if ((written_.*body).support == Support::rigid || kept == 0) return;
  const double begin = spent();
  int least = kept, too_few = -1;
  std::optional<std::size_t> best;
  for (int tests = 1 + static_cast<int>(std::log2(kept + 1)); least - too_few > 1; --tests) {
    const int modes = (least + too_few) / 2;
    const auto change = [body, modes](Scene& s) {
      (s.*body).modes = modes;
      (s.*body).max_frequency.reset();
    };
    const double until =
        spent() + std::max(0.0, end - std::max(begin, spent())) / std::max(1, tests);
    Trial trial = try_out(changed(key, modes_text(written_.*body, modes), change, base_->scene()),
                          base_, until);
    const bool enough = trial.verdict == Verdict::kept;
    (enough ? least : too_few) = modes;
    if (enough) best = out_.trials.size();
    out_.trials.push_back(std::move(trial));
  }
  if (best) out_.trials[*best].taken = true;
}

std::string spacing_text(double spacing) { return fmt::format("{:g} um", spacing * 1e6); }

void Search::find_spacing() {
  std::optional<std::size_t> best;
  const double chi = written_.spacing;
  double wide = 1, too_wide = std::numeric_limits<double>::infinity();
  for (double factor = 2; factor < too_wide && factor < 1000;) {
    const double spacing = chi * factor;
    const auto change = [spacing](Scene& s) { s.spacing = spacing; };
    const double until = spent() + std::max(0.0, spacing_end - spent()) / 3;
    Trial trial = try_out(changed("scene.spacing", spacing_text(spacing), change, base_->scene()),
                          base_, until);
    const bool enough = trial.verdict == Verdict::kept;
    (enough ? wide : too_wide) = factor;
    if (enough) best = out_.trials.size();
    out_.trials.push_back(std::move(trial));
    // upwards by two, then once between
    const bool between =
        factor == 1.5 * wide || factor == 1.5 * std::exp2(std::floor(std::log2(factor)));
    if (between) break;
    factor = enough ? 2 * factor : 1.5 * wide;
  }
  if (best) out_.trials[*best].taken = true;
}

void Search::take_together() {
  std::vector<Trial*> taken;
  for (Trial& trial : out_.trials)
    if (trial.taken && trial.key != "time") taken.push_back(&trial);
  const Scene numerics = out_.chosen;
  while (!taken.empty()) {
    Scene all = numerics;
    std::vector<std::string> names;
    for (const Trial* trial : taken) {
      trial->change(all);
      names.push_back(trial->key);
    }
    const auto change = [all](Scene& s) { s = all; };
    const double until = spent() + std::max(0.0, together_end - spent()) / 2;
    Trial trial = try_out(
        changed("together", fmt::format("time, {}", fmt::join(names, ", ")), change, written_),
        reference_, until);
    // alone the scheme is open to chance as well, and rests on the balance
    trial.taken = trial.verdict == Verdict::kept;
    const bool enough = trial.taken;
    out_.together.push_back(std::move(trial));
    if (enough) {
      out_.chosen = all;
      return;
    }
    // the least valuable goes back to the one before it that would do alone, or altogether; of
    // equals the last, the spacing
    const auto gain = [](const Trial* t) { return std::isnan(t->cheaper) ? 1.0 : t->cheaper; };
    auto least = taken.begin();
    for (auto it = taken.begin(); it != taken.end(); ++it)
      if (gain(*it) <= gain(*least)) least = it;
    Trial* given_up = *least;
    given_up->taken = false;
    given_up->why = "given up: too much together with the others, or that could not be told";
    Trial* before = nullptr;
    for (Trial& other : out_.trials) {
      if (&other == given_up) break;
      if (other.key == given_up->key && other.verdict == Verdict::kept) before = &other;
    }
    if (before) {
      before->taken = true;
      *least = before;
    } else {
      taken.erase(least);
    }
  }
}

/// How the scene as written stands.
void Search::look_beyond() {
  std::vector<Trial> list;
  const Scene& from = out_.reference;
  if (!is_adaptive(written_)) {
    Trial own = changed(
        "as written", text_of(written_), [](Scene&) {}, written_);
    list.push_back(own);
  }
  const auto more = [&](const char* key, BodySpec Scene::*body, int modes) {
    const auto change = [body, modes](Scene& s) {
      (s.*body).modes = modes;
      (s.*body).max_frequency.reset();
    };
    list.push_back(changed(key, modes_text(written_.*body, modes), change, from));
  };
  const Model model = make_model(written_);
  if (written_.resonator.support != Support::rigid) {
    const int kept = elastic_modes(model.resonator);
    int modes = kept + 1;
    while (kept > 0 && elastic_frequency(written_.resonator, modes) <=
                           2 * elastic_frequency(written_.resonator, kept - 1))
      ++modes;
    more("resonator.modes", &Scene::resonator, modes);
  }
  if (written_.slider.support != Support::rigid)
    more("slider.modes", &Scene::slider, elastic_modes(model.slider) + 2);
  const double spacing = written_.spacing / 2;
  list.push_back(changed(
      "scene.spacing", spacing_text(spacing), [spacing](Scene& s) { s.spacing = spacing; }, from));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double end = spent() + std::max(0.0, 1 - spent()) / static_cast<double>(list.size() - i);
    const bool own = list[i].key == "as written";
    Trial trial = try_out(list[i], reference_, end, own ? out_.cost_written : 0);
    trial.checked = true;
    out_.trials.push_back(std::move(trial));
  }
}

/// In turns, so that what else the machine does meets both alike.
void Search::measure_costs() {
  say("what it costs");
  const double wall = 0.006 * options_.budget;
  std::vector<double> written, chosen;
  for (int i = 0; i < 3; ++i) {
    written.push_back(measure_cost(written_, wall));
    chosen.push_back(measure_cost(out_.chosen, wall));
  }
  std::sort(written.begin(), written.end());
  std::sort(chosen.begin(), chosen.end());
  out_.cost_written = written[1];
  out_.cost_chosen = chosen[1];
}

Savings Search::run() {
  set_reference();
  find_numerics();
  const Model model = make_model(written_);
  find_modes("resonator.modes", &Scene::resonator, model.resonator, modes_end);
  find_modes("slider.modes", &Scene::slider, model.slider, slider_end);
  find_spacing();
  take_together();
  measure_costs();
  look_beyond();

  const std::vector<Answer>& answers = reference_->answers();
  out_.runs = reference_->runs();
  for (std::size_t q = 0; q < quantities_of_answer.size(); ++q) {
    const auto quantity = quantities_of_answer[q];
    double sum = 0, square = 0;
    int count = 0;
    for (const Answer& a : answers) {
      if (!a.failure.empty() || std::isnan(a.*quantity)) continue;
      sum += a.*quantity;
      square += std::pow(a.*quantity, 2);
      ++count;
    }
    const double mean = count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
    out_.mean.*quantity = mean;
    out_.spread[q] =
        count > 1 && mean > 0
            ? std::sqrt(std::max(0.0, square / count - mean * mean) * count / (count - 1)) / mean
            : 0.0;
  }
  for (const Answer& a : answers) out_.closure += a.closure / static_cast<double>(answers.size());
  out_.seconds = spent() * options_.budget;
  return out_;
}

}  // namespace

Savings find_savings(const Scene& scene, const SavingsOptions& options) {
  return Search(scene, options).run();
}

}  // namespace ra2d
