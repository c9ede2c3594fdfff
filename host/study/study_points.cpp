// SPDX-License-Identifier: BSD-3-Clause
#include "host/study/study_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <unordered_set>
#include <utility>

#include "host/base/errors.hpp"
#include "host/plan/expected_work.hpp"
#include "host/scene_file/reader.hpp"
#include "host/scene_file/scene_file.hpp"
#include "host/system/blocks.hpp"
#include "host/system/host_threads.hpp"

namespace ra2d {
namespace {

constexpr std::size_t most_listed = 3;  // scenes that are wrong

/// Of run k: both surfaces' seeds + 1000 k, within the numbers that TOML knows.
void shift_seeds(Scene& scene, std::int64_t k) {
  constexpr auto most = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  for (BodySpec* body : {&scene.resonator, &scene.slider})
    if (body->surface.kind == SurfaceKind::gaussian)
      body->surface.seed = (body->surface.seed + 1000 * static_cast<std::uint64_t>(k)) & most;
}

bool has_seed(const Scene& scene) {
  return scene.resonator.surface.kind == SurfaceKind::gaussian ||
         scene.slider.surface.kind == SurfaceKind::gaussian;
}

void replace_all(std::string& text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

}  // namespace

StudyPoints::StudyPoints(Study study) : study_{std::move(study)} {
  for (const StudyDimension& dimension : study_.dimensions) combinations_ *= dimension.size();
}

std::vector<std::size_t> StudyPoints::shape() const {
  std::vector<std::size_t> shape;
  for (const StudyDimension& dimension : study_.dimensions) shape.push_back(dimension.size());
  shape.push_back(study_.seeds.size());
  return shape;
}

std::vector<std::size_t> StudyPoints::place(std::size_t point) const {
  const std::vector<std::size_t> lengths = shape();
  std::vector<std::size_t> place(lengths.size());
  for (std::size_t axis = lengths.size(); axis-- > 0; point /= lengths[axis])
    place[axis] = point % lengths[axis];
  return place;
}

std::string StudyPoints::name(std::size_t point) const {
  const std::vector<std::size_t> at = place(point);
  std::string name;
  for (std::size_t d = 0; d < study_.dimensions.size(); ++d)
    name += fmt::format("{} = {}, ", study_.dimensions[d].name, study_.dimensions[d].shown(at[d]));
  return name + fmt::format("seed {}", study_.seeds[at.back()]);
}

std::vector<std::string> StudyPoints::overrides(const std::vector<std::size_t>& place) const {
  std::vector<std::string> texts = study_.set;
  texts.insert(texts.end(), study_.given.begin(), study_.given.end());
  for (std::size_t d = 0; d < study_.dimensions.size(); ++d) {
    const StudyDimension& dimension = study_.dimensions[d];
    for (std::size_t k = 0; k < dimension.keys.size(); ++k)
      texts.push_back(dimension.keys[k] + "=" + dimension.values[place[d]][k]);
  }
  return texts;
}

Scene StudyPoints::combination(std::size_t point) const {
  return parse_scene(study_.base_text, study_.base, overrides(place(point)));
}

Scene StudyPoints::combination(std::size_t point, const std::optional<ParsedText>& base) const {
  if (base) try {
      return parse_scene(*base, study_.base, overrides(place(point)));
    } catch (const RequestError&) {  // once more, with the lines of the text
    }
  return combination(point);
}

Scene StudyPoints::scene(std::size_t point) const {
  Scene scene = combination(point);
  shift_seeds(scene, study_.seeds[point % study_.seeds.size()]);
  return scene;
}

std::string StudyPoints::in_words_of_the_study(std::string fault, std::size_t point) const {
  const std::string base = study_.base.filename().string();
  replace_all(fault, study_.base.string(), base);
  const std::string one = base + ": 1 fault\n";
  if (fault.starts_with(one)) fault.erase(0, one.size());
  for (const std::string& change : overrides(place(point)))
    if (std::find(study_.given.begin(), study_.given.end(), change) == study_.given.end())
      replace_all(fault, "--set " + change, "the study's " + change);
  return fault;
}

namespace {

/// Says about five times a second how far threads have come together.
class SharedProgress {
 public:
  explicit SharedProgress(const std::function<void(std::size_t)>& tell) : tell_{tell} {}
  void add(std::size_t points) {
    if (!tell_) return;
    const std::lock_guard lock(mutex_);
    points_so_far_ += points;
    const auto now = std::chrono::steady_clock::now();
    if (now - reported_at_ < std::chrono::milliseconds(200)) return;
    reported_at_ = now;
    tell_(points_so_far_);
  }

 private:
  const std::function<void(std::size_t)>& tell_;
  std::mutex mutex_;
  std::size_t points_so_far_ = 0;
  std::chrono::steady_clock::time_point reported_at_ = std::chrono::steady_clock::now();
};

/// Combinations whose scenes are wrong, and why the first few are.
class WrongScenes {
 public:
  void add(std::size_t combination, const std::string& why) {
    const std::lock_guard lock(mutex_);
    ++count_;
    why_.emplace(combination, why);
    if (why_.size() > most_listed) why_.erase(std::prev(why_.end()));
  }
  void refuse(const StudyPoints& points) const {
    if (count_ == 0) return;
    std::string text;
    for (const auto& [combination, why] : why_) {
      const std::size_t point = combination * points.study().seeds.size();
      const std::string name = points.name(point);
      const std::size_t end = name.rfind(", seed ");
      text +=
          fmt::format("\n{}:\n{}", end == name.npos ? "every run" : "with " + name.substr(0, end),
                      points.in_words_of_the_study(why, point));
    }
    throw RequestError(fmt::format(
        "{}: {} of {} scenes {} wrong{}{}", points.study().file.string(), count_,
        points.combinations(), count_ == 1 ? "is" : "are", text,
        count_ > most_listed ? fmt::format("\nand {} more", count_ - most_listed) : ""));
  }

 private:
  std::mutex mutex_;
  std::size_t count_ = 0;
  std::map<std::size_t, std::string> why_;
};

/// The base of a study, parsed once: its text takes longer to parse than all the rest of a scene.
std::optional<ParsedText> parsed(const std::string& text) {
  try {
    return ParsedText(text);
  } catch (const RequestError&) {
    return {};  // the text itself will say what is wrong
  }
}

}  // namespace

PointCensus::PointCensus(const StudyPoints& points,
                         const std::function<void(std::size_t)>& progress) {
  constexpr std::size_t a_block = 64;  // combinations or seeds
  const Study& study = points.study();
  const std::vector<std::int64_t>& seeds = study.seeds;
  const std::optional<ParsedText> base = parsed(study.base_text);
  FileHashes files;
  SharedProgress so_far(progress);
  WrongScenes wrong;
  std::atomic<bool> any_seed = false;
  keys.resize(points.size());
  costs.resize(points.size());

  const auto count = [&](const Scene& scene, std::size_t first_point, std::size_t first,
                         std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      Scene shifted = scene;
      shift_seeds(shifted, seeds[k]);
      keys[first_point + k] = scene_key(shifted, files, study.keeps_microphones());
    }
  };
  const auto take = [&](std::size_t combination) {
    const std::size_t point = combination * seeds.size();
    const Scene scene = points.combination(point, base);
    std::fill_n(costs.begin() + static_cast<std::ptrdiff_t>(point), seeds.size(),
                static_cast<float>(expected_work(scene).seconds()));
    if (has_seed(scene)) {
      any_seed = true;
      in_blocks(seeds.size(), a_block, [&](std::size_t, std::size_t first, std::size_t last) {
        count(scene, point, first, last);
        so_far.add(last - first);
      });
    } else {  // one run for all
      count(scene, point, 0, 1);
      std::fill_n(keys.begin() + static_cast<std::ptrdiff_t>(point), seeds.size(), keys[point]);
      so_far.add(seeds.size());
    }
  };
  const std::size_t combinations = points.combinations();
  on_threads(host_threads(), (combinations + a_block - 1) / a_block, [&](std::size_t block) {
    const std::size_t last = std::min(combinations, (block + 1) * a_block);
    for (std::size_t c = block * a_block; c < last; ++c) try {
        take(c);
      } catch (const RequestError& fault) {
        wrong.add(c, fault.what());
      }
  });
  has_seeds = any_seed;
  profiles = files.names();
  wrong.refuse(points);
}

std::vector<std::size_t> PointCensus::different() const {
  std::vector<std::size_t> points;
  std::unordered_set<Key128> seen;
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (seen.insert(keys[i]).second) points.push_back(i);
  return points;
}

}  // namespace ra2d
