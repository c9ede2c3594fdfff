// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/errors.hpp"
#include "host/base/exit_status.hpp"
#include "host/base/text.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/map_report.hpp"
#include "host/commands/options.hpp"
#include "host/commands/print.hpp"
#include "host/scene/names.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/surface/map_output.hpp"
#include "host/surface/random_map.hpp"
#include "host/surface/random_profile.hpp"
#include "host/surface/surface.hpp"
#include "host/system/blocks.hpp"
#include "host/system/input_file.hpp"
#include "host/system/output_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

constexpr double most_nodes = 1e8;
constexpr double least_per_wave = 4;  // spacings, as in a scene (host/scene_file/checks.cpp)

struct GenerateRequest {
  std::filesystem::path output;
  double length = 0, spacing = 0;
  SurfaceSpec surface;
  std::string correlation = "gaussian", exact = "rq";
  std::optional<double> width, spacing_y, rsm_y;  // m, of a map
  bool quiet = false, json = false;
};

constexpr const char* generate_title = "ra2d surface generate";

void check_request(const GenerateRequest& request) {
  if (!(request.length / request.spacing <= most_nodes))
    throw RequestError(
        fmt::format("--length {} with --spacing {} makes {:.3g} nodes: expected at most {:g}",
                    request.length, request.spacing, request.length / request.spacing, most_nodes));
  for (const auto& [name, wave] :
       {std::pair{"--rsm", request.surface.rsm},
        std::pair{"--correlation-length", request.surface.correlation_length}})
    if (wave && *wave < least_per_wave * request.spacing)
      throw RequestError(
          fmt::format("{} {} m is not resolved by --spacing {} m: expected at least {} "
                      "spacings",
                      name, *wave, request.spacing, least_per_wave));
  if (request.surface.exact == Exactly::rq_and_rsm && !request.surface.rsm)
    throw RequestError("--exact rq+rsm needs --rsm");
  if (request.surface.seed > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    throw RequestError(fmt::format("--seed {}: expected at most {}, as in a scene",
                                   request.surface.seed, std::numeric_limits<std::int64_t>::max()));
  if (request.surface.rq > request.length)
    throw RequestError(
        fmt::format("--rq {} m is higher than the profile is long, {} m: expected a roughness "
                    "in metres",
                    request.surface.rq, request.length));
}

/// The places n * spacing as text. In decimals they are exact, as instruments write them, where the
/// spacing is so short a number that 64 bits hold them: 0.3 is not the double 3 * 0.1.
class Places {
 public:
  explicit Places(double spacing) : spacing_{spacing} {
    char digits[32];
    const char* const end =
        std::to_chars(digits, digits + sizeof digits, spacing, std::chars_format::scientific).ptr;
    const char* at = digits;
    for (bool behind_point = false; at != end && *at != 'e'; ++at)
      if (*at == '.')
        behind_point = true;
      else {
        mantissa_ = 10 * mantissa_ + static_cast<std::uint64_t>(*at - '0');
        decimals_ += behind_point;
      }
    int exponent = 0;
    std::from_chars(at + 1 + (at[1] == '+'), end, exponent);
    decimals_ -= exponent;
    exact_ = decimals_ >= 0 && decimals_ < most_digits &&
             static_cast<double>(mantissa_) * most_nodes < std::pow(10.0, most_digits);
  }

  /// Writes the place of node n, at most `longest` bytes, and returns their end.
  char* write(std::size_t n, char* at) const {
    if (!exact_) return std::to_chars(at, at + longest, static_cast<double>(n) * spacing_).ptr;
    char digits[2 * most_digits];
    std::fill_n(digits, most_digits, '0');
    char* const end =
        std::to_chars(digits + most_digits, digits + sizeof digits, n * mantissa_).ptr;
    char* const point = end - decimals_;
    at = std::copy(std::min(point - 1, digits + most_digits), point, at);
    if (decimals_ > 0) *at++ = '.';
    return std::copy(point, end, at);
  }
  static constexpr std::size_t longest = 24;

 private:
  static constexpr int most_digits = 18;
  double spacing_;
  std::uint64_t mantissa_ = 0;
  int decimals_ = 0;
  bool exact_;
};

/// Rows of heights[first], ..., heights[last - 1], with the digits that bring the doubles back.
void write_rows(const std::vector<double>& heights, const Places& places, std::size_t first,
                std::size_t last, std::string& text) {
  constexpr std::size_t longest = 24;  // bytes of a double
  text.resize((last - first) * (Places::longest + longest + 2));
  char* at = text.data();
  for (std::size_t n = first; n < last; ++n) {
    at = places.write(n, at);
    *at++ = ',';
    at = std::to_chars(at, at + longest, heights[n]).ptr;
    *at++ = '\n';
  }
  text.resize(static_cast<std::size_t>(at - text.data()));
}

/// Two columns that a scene and `ra2d surface measure` read.
void write_profile(const GenerateRequest& request, const std::vector<double>& heights) {
  constexpr std::size_t a_block = 1 << 13, at_once = 8 * a_block;  // nodes
  PartialFile file(request.output);
  file.write(fmt::format("# ra2d surface generate: surface = {}, {} m long\nx [m],z [m]\n",
                         surface_text(request.surface, {}), request.length));
  const auto write_all = [&](const std::vector<std::string>& parts) {
    for (const std::string& part : parts) file.write(part);
  };
  const Places places(request.spacing);
  std::vector<std::string> texts(at_once / a_block), before(texts.size());
  for (std::size_t begin = 0; begin < heights.size(); begin += at_once) {
    const std::size_t end = std::min(begin + at_once, heights.size());
    const std::size_t blocks = (end - begin + a_block - 1) / a_block;
    for (std::size_t b = blocks; b < texts.size(); ++b) texts[b].clear();
    in_blocks(1 + blocks, 1, [&](std::size_t task, std::size_t, std::size_t) {
      if (task == 0) return write_all(before);  // while the next ones are made
      const std::size_t first = begin + (task - 1) * a_block;
      write_rows(heights, places, first, std::min(first + a_block, end), texts[task - 1]);
    });
    std::swap(texts, before);
  }
  write_all(before);
  file.sync();
  file.publish();
}

/// Mean of a power of the heights, which have the mean 0, divided by `unit`: of 1e-300 m the square
/// alone is no double.
double moment(const std::vector<double>& heights, double unit, int power) {
  double sum = 0;
  for (const double h : heights) {
    double value = h / unit;
    for (int k = 1; k < power; ++k) value *= h / unit;
    sum += value;
  }
  return sum / static_cast<double>(heights.size());
}

void print_profile(const GenerateRequest& request, const RandomProfile& profile,
                   const std::vector<double>& heights) {
  const auto line = [](const char* what, const std::string& value) {
    print("  {:<20}{}\n", what, value);
  };
  const double rq = request.surface.rq * std::sqrt(moment(heights, request.surface.rq, 2));
  print("{} nodes, {:g} m apart\n", heights.size(), request.spacing);
  line("Rq", fmt::format("{:.4g} um", rq * 1e6));
  line("skewness, kurtosis",
       fmt::format("{:.3f}, {:.3f}", moment(heights, rq, 3), moment(heights, rq, 4)));
  line("correlation", correlations.name(profile.correlation));
  if (profile.correlation != Correlation::self_affine)
    line("correlation length", fmt::format("{:.4g} um", profile.correlation_length * 1e6));
  if (profile.correlation == Correlation::self_affine)
    line("Hurst exponent", fmt::format("{:g}", profile.hurst));
  if (profile.correlation == Correlation::self_affine)
    line("longest wave", fmt::format("{:.4g} um", profile.longest * 1e6));
  if (profile.correlation != Correlation::gaussian)
    line("shortest wave", fmt::format("{:.4g} um", profile.shortest * 1e6));
  line("spacing of elements",
       fmt::format("{:.4g} um between upward crossings of the mean line{}", profile.rsm * 1e6,
                   request.surface.exact == Exactly::rq_and_rsm ? "" : ", in expectation"));
  line("in a scene", "surface = " + surface_text(request.surface, {}));
  line("file", printable(request.output.string()));
}

/// Options of the other kind of surface that were given.
void check_kind(const GenerateRequest& request) {
  const auto refuse_with = [](const std::string& why) { throw RequestError(why); };
  const SurfaceSpec& s = request.surface;
  if (!request.width) {
    if (s.correlation != Correlation::self_affine)
      for (const auto& [name, value] :
           {std::pair{"--hurst", s.hurst}, std::pair{"--longest", s.longest}})
        if (value) refuse_with(fmt::format("{} is of --correlation self-affine", name));
    if (s.correlation == Correlation::gaussian && s.shortest)
      refuse_with("--shortest is of --correlation exponential and self-affine");
    for (const auto& [name, value] :
         {std::pair{"--spacing-y", request.spacing_y}, std::pair{"--rsm-y", request.rsm_y}})
      if (value) refuse_with(fmt::format("{} is of maps: give their --width, too", name));
    if (request.json) refuse_with("--json is of maps: give their --width, too");
    if (is_npy_name(request.output))
      refuse_with("an .npy takes maps: give their --width, too, or name a text with -o");
    return;
  }
  if (s.correlation != Correlation::gaussian)
    refuse_with(fmt::format("--correlation {}: a map has the gaussian one", request.correlation));
  for (const auto& [name, value] :
       {std::pair{"--hurst", s.hurst}, std::pair{"--longest", s.longest},
        std::pair{"--shortest", s.shortest}, std::pair{"--skewness", s.skewness},
        std::pair{"--kurtosis", s.kurtosis}})
    if (value) refuse_with(fmt::format("{} is of profiles: a map has none", name));
  if (s.exact == Exactly::rq_and_rsm)
    refuse_with("--exact rq+rsm is of profiles: expected rq or none for a map");
}

int generate_map(const GenerateRequest& request) {
  require_map_output(request.output, generate_title, {});
  const double rsm = resolve_random(request.surface, request.length).rsm;
  const RandomMap wanted{request.surface.rq, rsm, request.rsm_y.value_or(rsm),
                         request.surface.exact == Exactly::rq, request.surface.seed};
  const double spacing_y = request.spacing_y.value_or(request.spacing);
  std::vector<std::string> doubts;
  const HeightMap map =
      random_map(wanted, request.length, *request.width, request.spacing, spacing_y, &doubts);
  write_height_map(
      request.output, map,
      fmt::format("{}: a map of {} m by {} m, rq = {}, rsm = {}, rsm_y = {}, exact = {}, seed = {}",
                  generate_title, request.length, *request.width, wanted.rq, wanted.rsm,
                  wanted.rsm_y, request.exact, wanted.seed));
  say_doubts(doubts, request.quiet);
  if (request.json) {
    nlohmann::ordered_json json{{"file", request.output.string()}};
    json.update(map_json(map, 0));
    using Handler = nlohmann::ordered_json::error_handler_t;  // of names that are no UTF-8
    print_text(json.dump(2, ' ', false, Handler::replace) + '\n');
  } else if (!request.quiet) {
    print("{}: heights in metres\n", printable(request.output.string()));
    print_map(map, 0);
    if (is_npy_name(request.output))
      print("  {:<20}ra2d surface map {} --spacing {} --spacing-y {}\n", "to read it",
            printable(request.output.string()), map.spacing, map.spacing_y);
  }
  return exit_status::done;
}

int generate(GenerateRequest& request) {
  request.surface.kind = SurfaceKind::gaussian;
  for (const auto& [word, value] : correlations.words)
    if (word == request.correlation) request.surface.correlation = value;
  for (const auto& [word, value] : exact_choices.words)
    if (word == request.exact) request.surface.exact = value;
  check_kind(request);
  check_request(request);
  if (request.width) return generate_map(request);
  require_derived_output(request.output, {});
  std::error_code none;
  if (std::filesystem::exists(request.output, none) &&
      std::filesystem::file_size(request.output, none) > 0 &&
      InputFile(request.output).beginning(23) != std::string("# ") + generate_title)
    throw RequestError(fmt::format(
        "'{}' is there already, and 'ra2d surface generate' has not made it: it is left "
        "as it is. Name another file with -o, or remove it",
        request.output.string()));
  const RandomProfile profile = resolve_random(request.surface, request.length);
  std::vector<std::string> doubts;
  const std::vector<double> heights =
      make_surface(request.surface, request.length, request.spacing, {}, 0, &doubts);
  write_profile(request, heights);
  say_doubts(doubts, request.quiet);
  if (!request.quiet) print_profile(request, profile, heights);
  return exit_status::done;
}

template <class Value>
CLI::Option* add_length(CLI::App& command, const char* name, Value& value, const char* words) {
  return command.add_option(name, value, words)->type_name("METRES")->check(positive_number());
}

/// How rough the face is.
void add_face(CLI::App& command, GenerateRequest& request) {
  const auto length = [&](const char* name, auto& value, const char* words) {
    return add_length(command, name, value, words);
  };
  SurfaceSpec& s = request.surface;
  length("--rq", s.rq, "root mean square height")->required();
  CLI::Option* rsm = length(
      "--rsm", s.rsm, "mean spacing of its elements: between upward crossings of the mean line");
  const auto wave = [](const std::string& text) -> std::optional<double> {
    if (text == "inf") return std::numeric_limits<double>::infinity();
    const auto value = to_decimal(text);
    return value && *value > 0 ? value : std::nullopt;
  };
  command
      .add_option_function<std::string>(
          "--rsm-y", [&request, wave](const std::string& text) { request.rsm_y = wave(text); },
          "of a map: --rsm along y; inf makes every row the same [as --rsm]")
      ->type_name("METRES")
      ->check(understood("a length in metres, or inf", wave));
  length("--correlation-length", s.correlation_length, "where the correlation is 1/e")
      ->excludes(rsm);
  std::vector<std::string> words;
  for (const auto& named : correlations.words) words.push_back(named.first);
  command
      .add_option("--correlation", request.correlation,
                  "how the correlation of the heights falls with distance")
      ->check(CLI::IsMember(words))
      ->capture_default_str();
  command.add_option("--hurst", s.hurst, "self-affine: Hurst exponent")
      ->check(number_from(std::nextafter(0.0, 1.0), std::nextafter(1.0, 0.0), "between 0 and 1"));
  length("--longest", s.longest, "self-affine: longest wave");
  length("--shortest", s.shortest,
         "self-affine and exponential: shortest wave [exponential: a fiftieth of the correlation "
         "length]");
  constexpr double most = 1e3;
  command.add_option("--skewness", s.skewness, "of the heights [0]")
      ->check(number_from(-most, most, "a number"));
  command.add_option("--kurtosis", s.kurtosis, "of the heights; normal ones have 3 [3]")
      ->check(number_from(1, most, "a number from 1 on"));
  std::vector<std::string> exact;
  for (const auto& named : exact_choices.words) exact.push_back(named.first);
  command
      .add_option("--exact", request.exact,
                  "what holds exactly over this length; the rest holds in expectation")
      ->check(CLI::IsMember(exact))
      ->capture_default_str();
  command.add_option("--seed", s.seed, "a seed means one profile, at every spacing")
      ->transform(whole_number())
      ->capture_default_str();
}

}  // namespace

void add_surface_generate(CLI::App& surface, ChosenCommand& chosen) {
  const auto request = std::make_shared<GenerateRequest>();
  CLI::App* command = surface.add_subcommand(
      "generate",
      "makes a random rough profile, the one that a scene with the same words has; with --width "
      "a height map");
  const auto length = [&](const char* name, auto& value, const char* words) {
    return add_length(*command, name, value, words);
  };
  command
      ->add_option(
          "-o,--output", request->output,
          "the profile: two columns of text, x and z in metres. A map: a row of constant y in "
          "each line, or .npy of shape (rows, x)")
      ->type_name("FILE")
      ->required()
      ->check(path());
  length("--length", request->length, "how long it is")->required();
  length("--spacing", request->spacing, "from node to node")->required();
  length("--width", request->width, "makes a map that is so wide");
  length("--spacing-y", request->spacing_y, "of a map: from row to row [as --spacing]");
  add_face(*command, *request);
  command->add_flag("--json", request->json, "of a map: print JSON, in SI units");
  command->add_flag("--quiet", request->quiet, "print nothing but errors");
  command->callback([request, &chosen] { chosen.run = [request] { return generate(*request); }; });
}

}  // namespace ra2d
