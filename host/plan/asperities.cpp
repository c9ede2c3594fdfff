// SPDX-License-Identifier: BSD-3-Clause
#include "host/plan/asperities.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/scene/hertz.hpp"

namespace ra2d {
namespace {

/// Places along the path where summits are searched for, nodes in all of them, and nodes beside a
/// summit.
constexpr int most_places = 200;
constexpr double most_nodes = 2e7;
constexpr std::size_t most_half_nodes = 4096;

/// Both faces together, where the slider's left end stands at `x0` [m].
void add_faces(const Model& m, double x0, std::vector<double>& sum) {
  sum = m.slider_height;
  const std::size_t last = m.resonator_height.size() - 1;
  const double position = x0 / m.scene.spacing;
  for (std::size_t n = 0; n < sum.size(); ++n) {
    const double at = std::min(position + static_cast<double>(n), static_cast<double>(last));
    const auto left = static_cast<std::size_t>(at);
    sum[n] += std::lerp(m.resonator_height[left], m.resonator_height[std::min(left + 1, last)],
                        at - static_cast<double>(left));
  }
}

/// Curvature [1/m] of the parabola through the 2 m + 1 nodes about one, by least squares. m grows
/// to `half_width`, and is at least 1; nothing where the nodes end before.
std::optional<double> curvature_at(const std::vector<double>& face, std::size_t node,
                                   double half_width, double spacing) {
  const auto half_nodes = static_cast<std::size_t>(
      std::clamp(std::round(half_width / spacing), 1.0, static_cast<double>(most_half_nodes)));
  if (node < half_nodes || node + half_nodes >= face.size()) return std::nullopt;
  const double mean =
      static_cast<double>(half_nodes * (half_nodes + 1)) / 3;  // of i^2, i = -m ... m
  double second = 0, weight = 0;
  for (std::size_t j = node - half_nodes; j <= node + half_nodes; ++j) {
    const double i = static_cast<double>(j) - static_cast<double>(node);
    second += (i * i - mean) * face[j];
    weight += (i * i - mean) * (i * i - mean);
  }
  return -2 * second / weight / (spacing * spacing);
}

/// Where both faces together are highest, and the nodes around.
struct Summit {
  std::vector<double> face;  // m
  std::size_t node;          // of it
};

/// The highest node that none beside it tops, away from the ends; 0 where there is none.
std::size_t highest_summit(const std::vector<double>& face) {
  constexpr std::size_t part_at_end = 20;
  const std::size_t margin = std::max<std::size_t>(1, face.size() / part_at_end);
  std::size_t top = 0;
  for (std::size_t n = margin; n + margin < face.size(); ++n)
    if (face[n] >= face[n - 1] && face[n] >= face[n + 1] && (top == 0 || face[n] > face[top]))
      top = n;
  return top;
}

/// At places along the slider's path.
std::vector<Summit> find_summits(const Model& m) {
  const Scene& scene = m.scene;
  const double travel = scene.speed * scene.duration;
  const double affordable = most_nodes / static_cast<double>(m.nodes());
  const int places = travel > 0 ? std::clamp(static_cast<int>(affordable), 1, most_places) : 1;
  std::vector<Summit> all, touching;
  std::vector<double> face;
  for (int i = 0; i < places; ++i) {
    add_faces(m, scene.start + travel * i / places, face);
    const std::size_t node = highest_summit(face);
    if (node == 0) continue;
    const std::size_t first = node - std::min(node, most_half_nodes);
    const std::size_t end = std::min(node + most_half_nodes + 1, face.size());
    // a slider that is held touches where the faces reach across the gap
    const bool reaches = scene.slider.support != Support::free && face[node] >= m.delta;
    (reaches ? touching : all)
        .push_back({{face.begin() + static_cast<std::ptrdiff_t>(first),
                     face.begin() + static_cast<std::ptrdiff_t>(end)},
                    node - first});
  }
  return touching.empty() ? all : touching;
}

/// Mean curvature of the summits [1/m] over a half-width; 0 where none is round.
double mean_curvature(const std::vector<Summit>& summits, double half_width, double spacing) {
  double sum = 0;
  int count = 0;
  for (const Summit& summit : summits) {
    const auto curvature = curvature_at(summit.face, summit.node, half_width, spacing);
    if (!curvature || !(*curvature > 0)) continue;
    sum += *curvature;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

/// Contacts under the static load: connected nodes.
int contacts_of(const ModalStart& start) {
  int contacts = 0;
  for (std::size_t i = 0; i < start.loaded_nodes.size(); ++i)
    contacts += i == 0 || start.loaded_nodes[i] > start.loaded_nodes[i - 1] + 1;
  return contacts;
}

/// 1/M of both bodies: each mode moves by psi^2/m, and psi^2 has the mean 1/L.
double mean_mobility(const Model& m) {
  double sum = 0;
  for (const Body* body : {&m.resonator, &m.slider})
    sum += static_cast<double>(body->modes.size()) / body->mass;
  return sum;
}

double rms_slope(const std::vector<double>& heights, double spacing) {
  double rises = 0;
  for (std::size_t n = 1; n < heights.size(); ++n)
    rises += (heights[n] - heights[n - 1]) * (heights[n] - heights[n - 1]);
  return std::sqrt(rises / std::max(1.0, static_cast<double>(heights.size() - 1))) / spacing;
}

/// F = 4/3 E sqrt(R) d^(3/2), from dF/dd = 2 E a with a = sqrt(R d) and a^3 = 3 F R/(4 E).
double half_width_under(double modulus, double radius, double load) {
  return std::cbrt(3 * load * radius / (4 * modulus));
}

/// By the law of Hertz with a modulus. `node`: N/m of one node, below which no contact's stiffness
/// falls; 0 of a half-space.
AsperityContact contact_of(const Asperities& scene, double modulus, double node) {
  AsperityContact contact;
  if (!(modulus > 0) || std::isinf(modulus)) return contact;
  if (scene.load > 0)
    contact.stiffness =
        std::max(node, 2 * modulus * half_width_under(modulus, scene.radius, scene.load));
  if (!(scene.closing > 0) || !(scene.inertia > 0)) return contact;
  // Hertz's impact: M v^2/2 = 8/15 E sqrt(R) d^(5/2); it lasts 2.943 d/v, 2.943 = 2 int_0^1
  // dx/sqrt(1 - x^(5/2))
  constexpr double lasts = 2.9432750;
  const double energy = scene.inertia * scene.closing * scene.closing / 2;
  const double depth = std::pow(15 * energy / (8 * modulus * std::sqrt(scene.radius)), 0.4);
  contact.shock = 2 * modulus * std::sqrt(scene.radius * depth);
  contact.peak = 2.0 / 3 * contact.shock * depth;
  contact.duration = lasts * depth / scene.closing;
  if (contact.shock < node) {  // narrower than a node: its spring alone
    contact.shock = node;
    contact.peak = scene.closing * std::sqrt(node * scene.inertia);
    contact.duration = std::numbers::pi * std::sqrt(scene.inertia / node);
  }
  return contact;
}

}  // namespace

Asperities asperities_of(const Model& m, const ModalStart& start) {
  const Scene& scene = m.scene;
  Asperities found;
  if (m.is_areal) return found;  // what follows is of ridges
  found.modulus = contact_modulus(scene);
  found.hertz = hertz_stiffness(scene);
  if (std::isinf(found.modulus)) return found;
  const std::vector<Summit> summits = find_summits(m);
  const double curvature = mean_curvature(summits, 0, scene.spacing);
  if (!(curvature > 0)) return found;
  found.radius = 1 / curvature;
  if (m.slider.load_force > 0 && !m.slider.modes.empty()) {
    found.contacts = std::max(contacts_of(start), scene.slider.support == Support::free ? 2 : 1);
    found.load = m.slider.load_force / found.contacts;
  }
  found.closing = scene.speed * std::hypot(rms_slope(m.resonator_height, scene.spacing),
                                           rms_slope(m.slider_height, scene.spacing));
  const double mobility = mean_mobility(m);
  found.inertia = mobility > 0 ? 1 / mobility : 0.0;
  // the curvature over the contact's own width, which depends on it: a few rounds settle it
  for (int round = 0; round < 8; ++round) {
    found.material = contact_of(found, found.modulus, 0);
    const double stiffest = std::max(found.material.stiffness, found.material.shock);
    const double wide = mean_curvature(summits, stiffest / (2 * found.modulus), scene.spacing);
    if (!(wide > 0)) break;
    found.radius = 1 / wide;
  }
  found.material = contact_of(found, found.modulus, 0);
  if (scene.contact.law == ContactLaw::penalty) {
    // a bed of springs below a ridge is Hertz's law with the modulus kappa w sqrt(2)
    const double width = std::min(scene.resonator.width, scene.slider.width);
    const double modulus = scene.contact.stiffness * width * std::numbers::sqrt2;
    const AsperityContact bed = contact_of(found, modulus, 0);  // however narrow it is
    found.springs = m.has_smooth_faces() ? bed : contact_of(found, modulus, m.node_stiffness);
    // dF/dd = 2 E a with a^2 = R d, and a ridge that is pressed in by d is sqrt(8 R d) wide
    const double a = bed.shock / (2 * modulus);
    found.width = std::numbers::sqrt2 * 2 * a;
    found.depth = a * a / found.radius;
  }
  return found;
}

}  // namespace ra2d
