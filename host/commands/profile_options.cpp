// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/profile_options.hpp"

#include <string>
#include <utility>

#include "host/commands/options.hpp"

namespace ra2d {
namespace {

/// The meaning of one of some words.
template <class T>
auto either(std::vector<std::pair<const char*, T>> words) {
  return [words = std::move(words)](const std::string& text) -> std::optional<T> {
    for (const auto& [word, meaning] : words)
      if (text == word) return meaning;
    return {};
  };
}

/// As many as a number says; 0 for "all".
std::optional<std::size_t> sampling_lengths_of(const std::string& text) {
  if (text == "all") return 0;
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  if (!digits || text.find_first_not_of('0') == text.npos || text.size() > 6) return {};
  return std::stoul(text);
}

/// Adds options one by one, and keeps a list of them.
class ProfileOptionList {
 public:
  explicit ProfileOptionList(CLI::App& command) : command_{command} {}

  /// A word that `understand` gives a meaning; `take` is given that.
  template <class Understand, class Take>
  void word(const char* name, const char* type, const char* description, const char* expected,
            Understand understand, Take take) {
    note(command_.add_option_function<std::string>(
             name, [=](const std::string& text) { take(*understand(text)); }, description),
         type)
        ->check(understood(expected, understand));
  }
  CLI::Option* length(const char* name, std::optional<double>& value, const char* description) {
    return note(command_.add_option(name, value, description), "M")->check(length_in_metres());
  }
  void index(const char* name, std::optional<int>& value, const char* description) {
    note(command_.add_option(name, value, description), "N")->transform(count());
  }
  std::vector<CLI::Option*> all;

 private:
  CLI::Option* note(CLI::Option* option, const char* type) {
    all.push_back(option->type_name(type));
    return option;
  }
  CLI::App& command_;
};

/// How a file is read.
void add_reading(ProfileOptionList& list, ProfileQuery& query) {
  const auto unit = [](const std::string& text) { return to_unit(text); };
  list.word("--x-unit", "UNIT:{m,mm,um,nm}", "of x [the file's own, or m]", "m, mm, um or nm", unit,
            [&query](const LengthUnit& u) { query.x_unit = u; });
  list.word("--z-unit", "UNIT:{m,mm,um,nm}", "of the heights [the file's own, or m]",
            "m, mm, um or nm", unit, [&query](const LengthUnit& u) { query.z_unit = u; });
  list.length("--spacing", query.spacing, "step in metres, of a file that has no x");
  list.index(
      "--column", query.column,
      "the column of heights, from 1 [the second, after x]; of an areal file a profile along y");
  list.index("--row", query.row, "the row of an areal file, from 1: a profile along x");
  list.word("--decimal", "MARK:{point,comma}",
            "the decimal mark, where the file is ambiguous [from the file]", "point or comma",
            either<DecimalMark>({{"point", DecimalMark::point}, {"comma", DecimalMark::comma}}),
            [&query](DecimalMark mark) { query.decimal = mark; });
}

/// Form and filters.
void add_filters(ProfileOptionList& list, ProfileOptions& options) {
  MeasureOptions& measure = options.measure;
  list.word(
      "--form", "FORM:{none,mean,line,poly:N}",
      "form to be taken off first, by least squares [none]",
      "none, mean, line or poly:N with N from 0 to 10",
      [](const std::string& text) { return understand_form(text); },
      [&measure](ProfileForm form) { measure.form = form; });
  list.word("--filter", "KIND:{gaussian,done,none}",
            "gaussian, which gives the roughness profile; done, where the instrument has filtered "
            "already; none, for the primary profile [gaussian]",
            "gaussian, done or none",
            either<ProfileFilter>({{"gaussian", ProfileFilter::gaussian},
                                   {"done", ProfileFilter::done},
                                   {"none", ProfileFilter::none}}),
            [&options](ProfileFilter filter) {
              options.measure.filter = filter;
              options.has_filter = true;
            });
  list.length("--cutoff", measure.cutoff,
              "cut-off, and sampling length, in metres [2.5e-3; one length with --filter none]")
      ->each([&options](const std::string&) { options.has_filter = true; });
  list.length("--cutoff-s", measure.cutoff_s,
              "cut-off of the Gaussian filter against short waves, in metres [no such filter]");
}

/// The measures and their definitions.
void add_measures(ProfileOptionList& list, MeasureOptions& measure) {
  list.word("--sampling-lengths", "N",
            "how many sampling lengths are evaluated, or all [5, or as many as fit]",
            "a number from 1 to 999999, or all", sampling_lengths_of,
            [&measure](std::size_t number) { measure.sampling_lengths = number; });
  list.word(
      "--fill", "linear:M",
      "straight lines through missing points, over gaps up to M metres [they are refused]",
      "linear:WIDTH, with a width in metres, like linear:1e-5",
      [](const std::string& text) { return to_fill_width(text); },
      [&measure](double width) { measure.fill = width; });
  const auto standard = either<RoughnessStandard>(
      {{"iso21920", RoughnessStandard::iso21920}, {"iso4287", RoughnessStandard::iso4287}});
  list.word("--standard", "NORM:{iso21920,iso4287}", "whose definitions are taken [iso21920]",
            "iso21920 or iso4287", standard,
            [&measure](RoughnessStandard norm) { measure.standard = norm; });
}

}  // namespace

std::vector<CLI::Option*> add_profile_options(CLI::App& command, ProfileOptions& options) {
  ProfileOptionList list(command);
  add_reading(list, options.query);
  add_filters(list, options);
  add_measures(list, options.measure);
  command
      .add_option_function<std::string>(
          "--rsm",
          [](const std::string&) {
            throw CLI::ValidationError(
                "--rsm",
                "is now --standard iso21920 or iso4287, which takes all definitions of a norm");
          },
          "")
      ->group("");  // not in the help
  return list.all;
}

}  // namespace ra2d
