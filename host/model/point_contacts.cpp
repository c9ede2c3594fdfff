// SPDX-License-Identifier: BSD-3-Clause
#include "host/model/point_contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>

#include "host/scene/hertz.hpp"

namespace ra2d {
namespace {

constexpr double most_summit_nodes = 2e7;  // in all places along the path together
constexpr double few_summit_nodes = 1e6;   // for a doubt
constexpr double much_error = 0.4;         // of rates and durations, relative
constexpr int most_summit_places = 200;
constexpr std::size_t summits_a_place = 3;  // a free block rests on as many

/// Both faces together where the slider's corner stands at a place.
class FacesTogether {
 public:
  FacesTogether(const Model& model, double x)
      : model_{model},
        base_{std::min(static_cast<int>(x / model.scene.spacing),
                       model.row_heights() - model.row_nodes())},
        share_{x / model.scene.spacing - base_} {}

  double operator()(int row, int along) const {
    const double* const face =
        model_.resonator_height.data() + static_cast<std::size_t>(row) * model_.row_heights();
    const int left = std::min(base_ + along, model_.row_heights() - 1),
              right = std::min(left + 1, model_.row_heights() - 1);
    return model_.slider_height[static_cast<std::size_t>(row) * model_.row_nodes() + along] +
           std::lerp(face[left], face[right], share_);
  }
  /// Whether none of the eight neighbours is higher, and all of them are there.
  bool is_summit(int row, int along) const {
    if (row < 1 || row + 1 >= model_.rows || along < 1 || along + 1 >= model_.row_nodes())
      return false;
    const double own = (*this)(row, along);
    for (int j = row - 1; j <= row + 1; ++j)
      for (int i = along - 1; i <= along + 1; ++i)
        if ((*this)(j, i) > own) return false;
    return true;
  }

 private:
  const Model& model_;
  int base_;
  double share_;
};

/// A summit: where it is.
struct SummitPlace {
  double x, height;  // m: where the slider stands, and how high both faces are together
  int row, along;
};

/// The highest summits where the slider stands at `x`.
std::vector<SummitPlace> highest_summits(const Model& model, double x) {
  const FacesTogether faces(model, x);
  std::vector<SummitPlace> highest;
  for (int row = 1; row + 1 < model.rows; ++row)
    for (int i = 1; i + 1 < model.row_nodes(); ++i) {
      const double height = faces(row, i);
      if (highest.size() == summits_a_place && height <= highest.back().height) continue;
      if (!faces.is_summit(row, i)) continue;
      highest.push_back({x, height, row, i});
      std::sort(highest.begin(), highest.end(),
                [](const SummitPlace& a, const SummitPlace& b) { return a.height > b.height; });
      if (highest.size() > summits_a_place) highest.pop_back();
    }
  return highest;
}

/// The mean radius of summits over a half-width, by their mean curvature; 0 where none is round.
double mean_radius(const Model& model, const std::vector<SummitPlace>& summits, double half_width) {
  constexpr int most_half = 100;
  const double spacing = std::max(model.scene.spacing, model.spacing_y);
  const int half =
      static_cast<int>(std::clamp(std::round(half_width / spacing), 1.0, 1.0 * most_half));
  double curvature = 0;
  int count = 0;
  std::vector<double> heights;
  for (const SummitPlace& summit : summits) {
    if (summit.row < half || summit.row + half >= model.rows || summit.along < half ||
        summit.along + half >= model.row_nodes())
      continue;
    const FacesTogether faces(model, summit.x);
    heights.clear();
    for (int j = summit.row - half; j <= summit.row + half; ++j)
      for (int i = summit.along - half; i <= summit.along + half; ++i)
        heights.push_back(faces(j, i));
    const double radius = summit_radius(heights, model.scene.spacing, model.spacing_y);
    if (!(radius > 0)) continue;
    curvature += 1 / radius;
    ++count;
  }
  return count > 0 ? count / curvature : 0.0;
}

/// Error where a contact is one node wide; it goes with the square of the spacing.
double error_of_one(Faces faces) { return faces == Faces::smooth ? 0.1 : 0.4; }

}  // namespace

double shock_error_of(double nodes, Faces faces) { return error_of_one(faces) / (nodes * nodes); }

double nodes_for(double shock_error, Faces faces) {
  return std::sqrt(error_of_one(faces) / shock_error);
}

PointContact point_contact(double modulus, double radius, double force) {
  PointContact contact;
  contact.half_width = std::cbrt(3 * force * radius / (4 * modulus));
  contact.stiffness = 2 * modulus * contact.half_width;
  contact.kappa = 3 * modulus / (4 * std::numbers::pi * contact.half_width);
  return contact;
}

double width_on_springs(double kappa, double radius, double force) {
  const double depth = std::sqrt(force / (std::numbers::pi * kappa * radius));
  return 2 * std::sqrt(2 * radius * depth);
}

double summit_radius(const std::vector<double>& heights, double spacing, double spacing_y) {
  const auto side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(heights.size()))));
  const int half = side / 2;
  const double mean = half * (half + 1) / 3.0;  // of i^2, i = -half ... half
  double xx = 0, yy = 0, xy = 0, weight = 0;
  for (int j = -half; j <= half; ++j)
    for (int i = -half; i <= half; ++i) {
      const double z = heights[static_cast<std::size_t>((j + half) * side + i + half)];
      xx += (i * i - mean) * z;
      yy += (j * j - mean) * z;
      xy += i * j * z;
      weight += (i * i - mean) * (i * i - mean);
    }
  const double cross = std::pow(side * mean, 2);  // the sum of i^2 j^2
  // second derivatives of the polynomial
  xx *= 2 / (weight * spacing * spacing);
  yy *= 2 / (weight * spacing_y * spacing_y);
  xy /= cross * spacing * spacing_y;
  const double product = xx * yy - xy * xy;
  return xx < 0 && product > 0 ? 1 / std::sqrt(product) : 0.0;
}

int pieces_of(const Model& model, const std::vector<int>& nodes) {
  std::vector<std::size_t> piece(nodes.size());
  std::iota(piece.begin(), piece.end(), std::size_t{0});
  const auto root = [&](std::size_t n) {
    while (piece[n] != n) n = piece[n] = piece[piece[n]];
    return n;
  };
  int count = static_cast<int>(nodes.size());
  const int row = model.row_nodes();
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (const int back : {1, row - 1, row, row + 1}) {
      const int other = nodes[n] - back;
      if (std::abs(other % row - nodes[n] % row) > 1) continue;  // at the other end of a row
      const auto found = std::lower_bound(nodes.begin(), nodes.end(), other);
      if (found == nodes.end() || *found != other) continue;
      const std::size_t a = root(n), b = root(static_cast<std::size_t>(found - nodes.begin()));
      if (a == b) continue;
      piece[a] = b;
      --count;
    }
  return count;
}

namespace {

PointContacts contacts_of(const Model& model, int contacts, double most_nodes) {
  const Scene& scene = model.scene;
  PointContacts found;
  if (!model.is_areal || scene.contact.law != ContactLaw::penalty) return found;
  if (!(model.slider.load_force > 0) || model.slider.modes.empty()) return found;
  found.modulus = plate_contact_modulus(scene);
  if (!(found.modulus > 0) || std::isinf(found.modulus)) return found;
  const double travel = scene.speed * scene.duration;
  const int places =
      travel > 0 ? std::clamp(static_cast<int>(most_nodes / model.nodes()), 1, most_summit_places)
                 : 1;
  std::vector<SummitPlace> summits;
  for (int i = 0; i < places; ++i)
    for (const SummitPlace& summit : highest_summits(model, scene.start + travel * i / places))
      summits.push_back(summit);
  found.contacts = std::max(contacts, scene.slider.support == Support::free ? 3 : 1);
  found.load = model.slider.load_force / found.contacts;
  found.radius = mean_radius(model, summits, 0);
  // the curvature over the contact's own width, which depends on it: a few rounds settle it
  for (int round = 0; round < 8 && found.radius > 0; ++round) {
    found.hertz = point_contact(found.modulus, found.radius, found.load);
    const double wide = mean_radius(model, summits, found.hertz.half_width);
    if (!(wide > 0)) break;
    found.radius = wide;
  }
  if (!(found.radius > 0)) return found;
  found.hertz = point_contact(found.modulus, found.radius, found.load);
  found.width = width_on_springs(scene.contact.stiffness, found.radius, found.load);
  found.nodes = found.width / (model.has_smooth_faces() ? model.spacing_y
                                                        : std::max(scene.spacing, model.spacing_y));
  found.shock_error = shock_error_of(found.nodes, scene.faces);
  return found;
}

}  // namespace

PointContacts point_contacts_of(const Model& model, const ModalStart& start) {
  return contacts_of(model, model.is_areal ? pieces_of(model, start.loaded_nodes) : 0,
                     most_summit_nodes);
}

std::string doubt_mesh(const Model& model) {
  const PointContacts found = contacts_of(model, 0, few_summit_nodes);
  if (!(found.shock_error > much_error)) return {};
  return fmt::format(
      "contacts are about {:.2g} um wide, {:.2g} {} of nodes: rates and durations of shocks may be "
      "off by more than half ('ra2d plan' names finer spacings)",
      found.width * 1e6, found.nodes, model.has_smooth_faces() ? "rows" : "spacings");
}

}  // namespace ra2d
