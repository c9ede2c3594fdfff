// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/plan/plan.hpp"
#include "host/savings/face_search.hpp"
#include "host/savings/savings.hpp"
#include "host/scene/names.hpp"
#include "host/scene/schemes.hpp"
#include "host/scene_file/scene_file.hpp"

namespace ra2d {
namespace {

/// Digits of a percentage that an accuracy makes worth reading.
int digits_of(double accuracy) {
  return std::clamp(static_cast<int>(std::ceil(-std::log10(accuracy))), 1, 8);
}

std::string percent(const Movement& m, int digits) {
  if (m.pairs == 0) return "-";
  if (!std::isfinite(m.relative)) return "from 0";
  const std::string margin = m.pairs > 1 ? fmt::format(" ±{:.{}f}", 100 * m.margin(), digits) : "";
  return fmt::format("{:+.{}f}{}", 100 * m.relative, digits, margin);
}

double decibels(double relative) { return 20 * std::log10(std::max(1 + relative, 1e-30)); }

std::string level_text(const Movement& m) {
  if (m.pairs == 0 || !std::isfinite(m.relative)) return "-";
  return m.relative <= -1 ? "none" : fmt::format("{:+.3f}", decibels(m.relative));
}

std::string verdict_text(const Trial& trial) {
  if (trial.checked)
    return trial.verdict == Verdict::kept    ? "the same"
           : trial.verdict == Verdict::moved ? "differs"
                                             : "open";
  if (trial.taken) return trial.by_balance ? "taken, by its energy balance" : "taken";
  if (trial.by_balance) return "accurate enough, by its energy balance";
  return trial.verdict == Verdict::kept    ? "accurate enough"
         : trial.verdict == Verdict::moved ? "no"
                                           : "open";
}

/// Beyond the scene as written modes of both bodies stand under each other.
std::string name_of(const Trial& trial) {
  const std::size_t end = trial.key.find(".modes");
  if (!trial.checked || end == std::string::npos) return trial.what;
  std::string what = trial.what;
  if (const std::size_t word = what.find(" elastic,"); word != std::string::npos)
    what.erase(word, std::string_view(" elastic").size());
  return trial.key.substr(0, end) + ": " + what;
}

std::string row(const Trial& trial, int digits, bool costs) {
  const bool ran = trial.moved[0].pairs > 0 || trial.moved[1].pairs > 0;
  std::string text = fmt::format("  {:<32}", name_of(trial));
  if (ran) {
    const int pairs = std::max(trial.moved[0].pairs, trial.moved[1].pairs);
    text += fmt::format("{:>7} {:>5} {:>8} {:>14} {:>14} {:>14}  {}",
                        costs && trial.cheaper > 0 ? fmt::format("{:.3g}", trial.cheaper) : "",
                        pairs, level_text(trial.moved[0]), percent(trial.moved[0], digits),
                        percent(trial.moved[1], digits), percent(trial.moved[2], digits),
                        verdict_text(trial));
  } else {
    text += fmt::format("  {}", verdict_text(trial));
  }
  text += '\n';
  if (!trial.why.empty()) text += fmt::format("      {}\n", trial.why);
  if (trial.by_balance && trial.taken)
    text += fmt::format(
        "      accepted on its energy balance, too few pairs to decide: off by {:.1e}, and the "
        "first\n"
        "      shocks, before chaos parts the runs, last as long within {} %\n",
        trial.energy_closure, percent(trial.first, digits));
  return text;
}

std::string heading(const std::string& what) {
  // the sign of ± takes two bytes and one column
  return fmt::format("\n{:<34}{:>7} {:>5} {:>8} {:>14} {:>14} {:>14}\n", what, "cheaper", "pairs",
                     "dB", "level %", "shocks %", "duration %");
}

std::string table(const Savings& s, const std::string& key, const std::string& what, bool checked) {
  std::string text;
  for (const Trial& trial : s.trials)
    if (trial.checked == checked && (checked || trial.key == key))
      text += row(trial, digits_of(s.accuracy), !checked);
  return text.empty() ? text : heading(what) + text;
}

std::string choice_text(const Scene& scene) {
  return is_adaptive(scene) ? fmt::format("{} to {:g}", schemes.name(scene.time.scheme),
                                          scene.time.tolerance.value_or(usual_tolerance))
                            : fmt::format("{}{}, step {:g} s", schemes.name(scene.time.scheme),
                                          choice_of(scene).contact_force == ForceTime::new_time
                                              ? " with the new force"
                                              : "",
                                          scene.time.step);
}

/// The trial that the chosen scene rests on; null where it is the scene as written.
const Trial* resting_on(const Savings& s) {
  if (!s.combinations.empty() && s.combinations.back().taken) return &s.combinations.back();
  for (const Trial& trial : s.trials)
    if (trial.taken && trial.key == "time") return &trial;
  return nullptr;
}

/// The change of each quantity, in a line.
std::string movement_text(const Trial& trial, double accuracy) {
  const int digits = digits_of(accuracy);
  std::string text = fmt::format("level {} dB ({} %)", level_text(trial.moved[0]),
                                 percent(trial.moved[0], digits));
  for (const auto& [name, m] :
       {std::pair{"shock rate", trial.moved[1]}, std::pair{"median duration", trial.moved[2]}})
    if (m.pairs > 0) text += fmt::format(", {} {} %", name, percent(m, digits));
  return text;
}

std::string modes_of(const BodySpec& body) {
  return body.modes ? fmt::format("{}", *body.modes)
                    : fmt::format("those up to {:g} kHz", 1e-3 * body.max_frequency.value_or(0));
}

std::string spacing_of(const Scene& scene) { return fmt::format("{:g} um", scene.spacing * 1e6); }

/// How the cost compares with that of the scene as written.
std::string cost_text(const Savings& s) {
  const double cheaper = s.cost_written / s.cost_chosen;
  return cheaper >= 1 ? fmt::format("{:.3g} times cheaper", cheaper)
                      : fmt::format("{:.3g} times dearer", 1 / cheaper);
}

/// The scene with the reference's faces.
std::string reference_text(const Savings& s) {
  return s.reference.faces == s.written.faces ? "the scene as written"
                                              : fmt::format("the scene as written with {} faces",
                                                            face_choices.name(s.reference.faces));
}

/// The accuracy, the reference and its answer.
std::string describe_reference(const Savings& s) {
  const int digits = digits_of(s.accuracy);
  std::string text = fmt::format(
      "accuracy   level, rate of shocks and their median duration within {:g} % (level: {:.2g} "
      "dB)\n",
      100 * s.accuracy, decibels(s.accuracy));
  text += fmt::format("reference  {}, {}; its energy balance is off by {:.1e}\n", reference_text(s),
                      choice_text(s.reference), s.energy_closure);
  text += s.runs > 1 ? fmt::format("runs       {} of {}, {}; compared in pairs of the same\n",
                                   s.runs, seconds_text(s.duration), varied(s.written))
                     : fmt::format("runs       one of {}: there is nothing to vary\n",
                                   seconds_text(s.duration));
  text += s.mean.v_rms > 0
              ? fmt::format("answer     level {:.2f} dB", 20 * std::log10(s.mean.v_rms / 1e-9))
              : "answer     no level: the resonator does not move";
  text += fmt::format(", {:.4g} shocks a second", s.mean.shock_rate);
  if (s.mean.shock_rate > 0)
    text += fmt::format(", median {}", seconds_text(s.mean.shock_duration_median));
  text += '\n';
  if (s.runs > 1)
    text += fmt::format("           one run alone spreads by {:.{}f} %, {:.{}f} % and {:.{}f} %\n",
                        100 * s.spread[0], digits, 100 * s.spread[1], digits, 100 * s.spread[2],
                        digits);
  return text +
         "           below: what moved, ± the margin of 95 % (two standard errors, Student's t)\n";
}

std::string describe_trials(const Savings& s) {
  std::string text = table(s, "time", "scheme and step", false);
  text += table(s, "resonator.modes", "modes of the resonator", false);
  text += table(s, "slider.modes", "modes of the slider", false);
  text += table(s, "scene.faces", "faces and spacing", false);
  text += table(s, "scene.spacing", "spacing", false);
  if (!s.combinations.empty()) {
    text += heading("together");
    for (const Trial& trial : s.combinations) text += row(trial, digits_of(s.accuracy), true);
  }
  return text + table(s, "", "beyond the scene as written", true);
}

/// How much of a part of the model will do.
std::string describe_part(const Savings& s, const std::string& key, const std::string& all) {
  const Trial *taken = nullptr, *any = nullptr;
  for (const Trial& trial : s.trials)
    if (trial.key == key && !trial.checked) (trial.taken ? taken : any) = &trial;
  if (taken != nullptr)
    return fmt::format("           {}: {} will do for {}\n", key, taken->what, all);
  if (any == nullptr) return {};
  return fmt::format("           {}: {} as written, nothing can be left out{}\n", key, all,
                     any->verdict == Verdict::moved  ? ""
                     : any->verdict == Verdict::kept ? " together with the rest"
                                                     : " for sure");
}

/// Whether linear and smooth faces were compared.
bool compares_faces(const Savings& s) {
  return std::any_of(s.trials.begin(), s.trials.end(),
                     [](const Trial& trial) { return trial.key == "scene.faces"; });
}

std::string describe_faces(const Savings& s) {
  const std::string written = faces_text(s.written.faces, s.written.spacing);
  if (s.chosen.faces != s.written.faces || s.chosen.spacing != s.written.spacing)
    return fmt::format("           faces: {} instead of {}\n",
                       faces_text(s.chosen.faces, s.chosen.spacing), written);
  const Trial* own = faces_as_written(s);
  return fmt::format("           faces: {} as written{}\n", written,
                     own == nullptr || own->verdict == Verdict::kept ? ""
                     : own->verdict == Verdict::moved                ? ", which are too far off"
                                                                     : ", which stays open");
}

/// The comment on chosen faces in a planned scene; empty where they are as written.
std::string faces_note(const Savings& s) {
  if (!compares_faces(s) ||
      (s.chosen.faces == s.written.faces && s.chosen.spacing == s.written.spacing))
    return {};
  std::string text = fmt::format("# was {}", faces_text(s.written.faces, s.written.spacing));
  const Trial* own = faces_as_written(s);
  if (own != nullptr && own->verdict == Verdict::moved)
    text += fmt::format(", which moves {}", movement_text(*own, s.accuracy));
  for (const Trial& trial : s.trials)
    if (trial.taken && trial.key == "scene.faces")
      text += fmt::format("; alone it moves {}", movement_text(trial, s.accuracy));
  return text;
}

/// The `modes` of a body as the key that the scene as written has.
std::string modes_word(const char* name, const BodySpec& written, int modes) {
  if (!written.max_frequency) return fmt::format("{}.modes={}", name, modes);
  // half way to the first that is left out; below the first one, none is kept
  const double next = elastic_frequency(written, modes);
  const double last = modes > 0 ? elastic_frequency(written, modes - 1) : 0.0;
  return fmt::format("{}.max_frequency={:.6g}", name, (last + next) / 2);
}

}  // namespace

std::vector<std::string> set_words(const Savings& s) {
  const Scene &from = s.written, &to = s.chosen;
  std::vector<std::string> words;
  const auto set = [&](const std::string& word) {
    words.emplace_back("--set");
    words.push_back(word);
  };
  if (from.time.scheme != to.time.scheme)
    set(fmt::format("time.scheme={}", schemes.name(to.time.scheme)));
  if (from.time.contact_force != to.time.contact_force)
    set(fmt::format("time.contact_force={}", force_times.name(to.time.contact_force)));
  if (!is_adaptive(to) && from.time.step != to.time.step)
    set(fmt::format("time.step={}", to.time.step));
  if (is_adaptive(to) &&
      from.time.tolerance.value_or(usual_tolerance) != to.time.tolerance.value_or(usual_tolerance))
    set(fmt::format("time.tolerance={}", to.time.tolerance.value_or(usual_tolerance)));
  if (from.faces != to.faces) set(fmt::format("scene.faces={}", face_choices.name(to.faces)));
  if (from.spacing != to.spacing) set(fmt::format("scene.spacing={}", to.spacing));
  if (from.spacing_y != to.spacing_y)
    set(fmt::format("scene.spacing_y={}", to.spacing_y.value_or(to.spacing)));
  if (from.resonator.modes != to.resonator.modes)
    set(modes_word("resonator", from.resonator, to.resonator.modes.value_or(0)));
  if (from.slider.modes != to.slider.modes)
    set(modes_word("slider", from.slider, to.slider.modes.value_or(0)));
  return words;
}

std::string describe(const Savings& s) {
  std::string text = describe_reference(s) + describe_trials(s);
  text += "\nneeded     " + choice_text(s.chosen) + '\n';
  text += describe_part(s, "resonator.modes", modes_of(s.written.resonator));
  text += describe_part(s, "slider.modes", modes_of(s.written.slider));
  text += compares_faces(s) ? describe_faces(s)
                            : describe_part(s, "scene.spacing", spacing_of(s.written));
  if (const std::vector<std::string> words = set_words(s); !words.empty())
    text += fmt::format("set        {}\n", fmt::join(words, " "));
  if (const Trial* rest = resting_on(s)) {
    text += fmt::format("which      moves {}\n", movement_text(*rest, s.accuracy));
    if (rest->by_balance)
      text += "           (by chance more than the accuracy; taken because its energy closes)\n";
  }
  text += fmt::format("cost       {} of the processor a simulated second, {} as written: {}\n",
                      seconds_text(s.cost_chosen), seconds_text(s.cost_written), cost_text(s));
  for (const std::string& note : s.notes) text += "note       " + note + '\n';
  for (const Trial& trial : s.trials)
    if (trial.checked && trial.verdict == Verdict::moved && trial.why.empty())
      text += fmt::format("note       {} is itself further off than the accuracy: {}, {}\n",
                          reference_text(s), trial.key == "as written" ? "its own" : trial.key,
                          trial.what);
  text += fmt::format("took       {}\n", seconds_text(s.seconds));
  return text;
}

std::string planned_scene(const Savings& s) {
  const Scene& scene = s.chosen;
  const std::string name = printable(s.written.file.filename().string());
  std::string text = fmt::format(
      "# {} with no more than level, rate of shocks and their median duration need to stay within\n"
      "# {:g} % of {}: 'ra2d plan --accuracy {:g}'.\n",
      name, 100 * s.accuracy, reference_text(s), s.accuracy);
  if (const Trial* rest = resting_on(s))
    text += fmt::format("# Moved: {}, over {} runs.\n", movement_text(*rest, s.accuracy),
                        rest->moved[0].pairs);
  text += fmt::format("# {} than as written.\n\n", cost_text(s));

  // where each choice comes from, before its line
  const auto note = [&](const std::string& section, const std::string& key) -> std::string {
    const auto from = [&](const std::string& trial_key) -> std::string {
      for (const Trial& trial : s.trials)
        if (trial.taken && trial.key == trial_key)
          return fmt::format(
              "# alone it moves {}{}", movement_text(trial, s.accuracy),
              trial.by_balance
                  ? fmt::format("; taken because its energy balance is off by only {:.1e}",
                                trial.energy_closure)
                  : "");
      return {};
    };
    if (section == "[time]" && key == "scheme")
      if (const std::string text = from("time"); !text.empty())
        return fmt::format("# was {}; {}", choice_text(s.written), text.substr(2));
    if (section == "[resonator]" && key == "modes") return from("resonator.modes");
    if (section == "[slider]" && key == "modes") return from("slider.modes");
    if (section == "[scene]" && key == (scene.faces == s.written.faces ? "spacing" : "faces"))
      if (const std::string text = faces_note(s); !text.empty()) return text;
    if (section == "[scene]" && key == "spacing") {
      const std::string text = from("scene.spacing");
      return text.empty() ? text : fmt::format("# was {:g}; {}", s.written.spacing, text.substr(2));
    }
    return {};
  };
  std::istringstream in(echo(scene));
  std::string section;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('[')) section = line.substr(0, line.find(' '));
    if (const auto end = line.find(" = "); end != std::string::npos)
      if (const std::string why = note(section, line.substr(0, end)); !why.empty())
        text += why + '\n';
    text += line + '\n';
  }
  return text;
}

}  // namespace ra2d
