// SPDX-License-Identifier: BSD-3-Clause
#include "bench/peers/areal_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "host/body/areal_shape.hpp"

namespace ra2d::peers {
namespace {

using Eigen::Index;
using std::numbers::pi;

/// Nodes along a side of a block: of fewer there are too many to look through, and within more the
/// heights differ too much.
int block_side(int nodes) { return nodes > 1'000'000 ? 32 : 8; }

}  // namespace

ArealEquations::ArealEquations(const Model& model)
    : ContactEquations{model},
      rows_{model.rows},
      row_nodes_{model.row_nodes()},
      row_heights_{model.row_heights()},
      height1_{model.slider_height},
      height2_{model.resonator_height},
      delta_{model.delta},
      length_{model.resonator.length},
      width_{model.scene.resonator.width} {
  along_ = across_ = 0;
  std::vector<std::pair<int, int>> numbers;
  for (const BodyMode& mode : model.resonator.modes) {
    const ArealShape& shape = areal_shape(mode);
    numbers.emplace_back(std::lround(shape.along.beta * length_ / pi),
                         std::lround(shape.wave * width_ / pi));
    along_ = std::max(along_, numbers.back().first);
    across_ = std::max(across_, numbers.back().second);
  }
  for (const auto& [m, n] : numbers) place_of_.push_back(m - 1 + along_ * (n - 1));
  highest_ = 2 / std::sqrt(length_ * width_);

  constant_ = tilt_ = Eigen::ArrayXd::Zero(modes1_);
  for (Index k = 0; k < modes1_; ++k) {
    const ArealShape& shape = areal_shape(model.slider.modes[k]);
    constant_[k] = shape.along.constant;
    tilt_[k] = shape.along.slope;
  }

  const auto fill_table = [&](Eigen::MatrixXd& table, int count, auto place) {
    table.resize(2 * along_ + 2, count);
    for (int i = 0; i < count; ++i) {
      const double x = place(i) * spacing;
      for (int m = 0; m < along_; ++m) {
        table(m, i) = std::cos((m + 1) * pi * x / length_);
        table(along_ + m, i) = std::sin((m + 1) * pi * x / length_);
      }
      table(2 * along_, i) = 1;
      table(2 * along_ + 1, i) = x;
    }
  };
  const auto fill_across = [&](Eigen::MatrixXd& out, int count, auto place) {
    out.resize(across_ + modes1_, count);
    for (int j = 0; j < count; ++j) {
      const double eta = (place(j) + 0.5) * model.spacing_y;
      for (int n = 0; n < across_; ++n)
        out(n, j) = std::sin((n + 1) * pi * (model.side + eta) / width_);
      for (Index k = 0; k < modes1_; ++k) {
        const ArealShape& shape = areal_shape(model.slider.modes[k]);
        out(across_ + k, j) = shape.offset + shape.tilt * eta;
      }
    }
  };
  fill_table(table_, row_nodes_, [](int i) { return static_cast<double>(i); });
  fill_across(across_rows_, rows_, [](int j) { return static_cast<double>(j); });

  block_ = block_side(nodes());
  block_rows_ = (rows_ + block_ - 1) / block_;
  row_blocks_ = (row_nodes_ + block_ - 1) / block_;
  const double middle = 0.5 * (block_ - 1);
  fill_table(block_table_, row_blocks_, [&](int i) { return i * block_ + middle; });
  fill_across(block_across_, block_rows_, [&](int j) { return j * block_ + middle; });
  block_highest1_.setConstant(row_blocks_, block_rows_, -std::numeric_limits<double>::infinity());
  strip_highest2_.setConstant(row_heights_, block_rows_, -std::numeric_limits<double>::infinity());
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < row_nodes_; ++i) {
      double& highest = block_highest1_(i / block_, j / block_);
      highest = std::max(highest, height1_[static_cast<std::size_t>(j) * row_nodes_ + i]);
    }
    auto strip = strip_highest2_.col(j / block_);
    strip = strip.max(Eigen::Map<const Eigen::ArrayXd>(
        height2_.data() + static_cast<std::size_t>(j) * row_heights_, row_heights_));
  }
  variation_.resize(modes());
  for (Index k = 0; k < modes(); ++k) {
    const ModeShape& shape =
        *(k < modes2_ ? model.resonator : model.slider).modes[k < modes2_ ? k : k - modes2_].shape;
    variation_[k] = middle * (spacing * shape.largest_slope(0) +
                              model.spacing_y * shape.across_rate() * shape.largest());
  }

  sine_ = cosine_ = Eigen::ArrayXd::Zero(along_);
  amplitude_ = forces_ = Eigen::MatrixXd::Zero(along_, across_);
  u1_ = Eigen::VectorXd::Zero(modes1_);
  line_ = Eigen::VectorXd::Zero(along_);
  block_coefficients_ = row_force_ = Eigen::VectorXd::Zero(2 * along_ + 2);
  for (int j = 0; j < rows_; ++j) add_row(j, 0, row_nodes_);
}

/// Nodes `first` to `last` - 1 of a row are evaluated, too.
void ArealEquations::add_row(int row, int first, int last) {
  if (lines_.empty() || lines_.back().row != row) lines_.push_back({row, nodes_.size(), 0});
  for (int i = first; i < last; ++i) nodes_.push_back(i);
  lines_.back().count = nodes_.size() - lines_.back().first;
}

void ArealEquations::evaluate_only(const std::vector<int>& nodes) {
  nodes_.clear();
  lines_.clear();
  for (const int node : nodes) add_row(node / row_nodes_, node % row_nodes_, node % row_nodes_ + 1);
}

void ArealEquations::locate(double t) {
  const double at = position(t);
  base_ = static_cast<std::int64_t>(std::floor(at));
  // rounded by its own size, not by the position's
  theta_ = std::fma(t, rate_, position_ - static_cast<double>(base_)) + lag * rate_;
  // sines of multiples by products of e^(i pi X/a)
  const double angle = pi * at * spacing / length_;
  const double s = std::sin(angle), c = std::cos(angle);
  double sine = s, cosine = c;
  for (int m = 0; m < along_; ++m) {
    sine_[m] = sine;
    cosine_[m] = cosine;
    const double next = sine * c + cosine * s;
    cosine = cosine * c - sine * s;
    sine = next;
  }
}

void ArealEquations::set_displacements(const double* u) {
  double* const to = amplitude_.data();
  for (Index k = 0; k < modes2_; ++k) to[place_of_[k]] = highest_ * u[k];
  for (Index k = 0; k < modes1_; ++k) u1_[k] = u[modes2_ + k];
}

void ArealEquations::find_coefficients(const double* across, Eigen::Ref<Eigen::VectorXd> out) {
  line_.noalias() = amplitude_ * Eigen::Map<const Eigen::VectorXd>(across, across_);
  out.head(along_) = line_.array() * sine_;
  out.segment(along_, along_) = line_.array() * cosine_;
  double constant = 0, tilt = 0;
  for (Index k = 0; k < modes1_; ++k) {
    constant += u1_[k] * constant_[k] * across[across_ + k];
    tilt += u1_[k] * tilt_[k] * across[across_ + k];
  }
  out[2 * along_] = constant;
  out[2 * along_ + 1] = tilt;
}

/// Beyond the resonator's end its last height repeats.
double ArealEquations::face(int row, std::int64_t at) const {
  const std::int64_t last = row_heights_ - 1;
  return height2_[static_cast<std::size_t>(row) * row_heights_ + std::min(at, last)];
}

const Eigen::VectorXd& ArealEquations::overlaps(double t, const double* u) {
  locate(t);
  set_displacements(u);
  const auto count = static_cast<Index>(nodes_.size());
  overlap_.resize(count);
  coefficients_.resize(2 * along_ + 2, static_cast<Index>(lines_.size()));
  for (std::size_t l = 0; l < lines_.size(); ++l)
    find_coefficients(across_rows_.col(lines_[l].row).data(),
                      coefficients_.col(static_cast<Index>(l)));
  if (count == nodes()) {
    ++displacement_sums;
    Eigen::Map<Eigen::MatrixXd>(overlap_.data(), row_nodes_, rows_).noalias() =
        table_.transpose() * coefficients_;
    for (int j = 0; j < rows_; ++j) add_faces(j, overlap_.data() + Index{j} * row_nodes_);
    return overlap_;
  }
  for (std::size_t l = 0; l < lines_.size(); ++l) {
    const auto& [row, first, nodes] = lines_[l];
    const double* const h1 = height1_.data() + static_cast<std::size_t>(row) * row_nodes_;
    for (std::size_t at = first; at < first + nodes; ++at) {
      const int i = nodes_[at];
      const double left = face(row, base_ + i), right = face(row, base_ + i + 1);
      overlap_[static_cast<Index>(at)] =
          h1[i] - delta_ + (left + theta_ * (right - left)) +
          table_.col(i).dot(coefficients_.col(static_cast<Index>(l)));
    }
  }
  return overlap_;
}

/// Adds h_1 - delta + h_2 to every node of a row.
void ArealEquations::add_faces(int row, double* overlap) const {
  const double* const h1 = height1_.data() + static_cast<std::size_t>(row) * row_nodes_;
  const std::int64_t inner = std::clamp<std::int64_t>(row_heights_ - 1 - base_, 0, row_nodes_);
  const double* const h2 = height2_.data() + static_cast<std::size_t>(row) * row_heights_ + base_;
  for (std::int64_t i = 0; i < inner; ++i)
    overlap[i] += h1[i] - delta_ + (h2[i] + theta_ * (h2[i + 1] - h2[i]));
  for (std::int64_t i = inner; i < row_nodes_; ++i)
    overlap[i] += h1[i] - delta_ + face(row, base_ + i);
}

void ArealEquations::contact(double t, const double* u, double* force) {
  overlaps(t, u);
  if (overlap_.size() == 0 || !(overlap_.maxCoeff() > 0)) return;
  forces_.setZero();
  for (const RowOfNodes& line : lines_) {
    row_force_.setZero();
    bool touches = false;
    for (std::size_t i = line.first; i < line.first + line.count; ++i) {
      const double overlap = overlap_[static_cast<Index>(i)];
      if (!(overlap > 0)) continue;
      touches = true;
      row_force_ += node_stiffness * overlap * table_.col(nodes_[i]);
    }
    if (!touches) continue;
    const double* const across = across_rows_.col(line.row).data();
    line_ = row_force_.head(along_).array() * sine_ +
            row_force_.segment(along_, along_).array() * cosine_;
    forces_.noalias() += line_ * Eigen::Map<const Eigen::RowVectorXd>(across, across_);
    for (Index k = 0; k < modes1_; ++k)
      force[modes2_ + k] -= across[across_ + k] * (constant_[k] * row_force_[2 * along_] +
                                                   tilt_[k] * row_force_[2 * along_ + 1]);
  }
  const double* const from = forces_.data();
  for (Index k = 0; k < modes2_; ++k) force[k] -= highest_ * from[place_of_[k]];
}

void ArealEquations::list_above(double t, std::int64_t base, int windows, const double* u,
                                double level, std::vector<int>& out) {
  locate(t);
  set_displacements(u);
  const double varies = (variation_ * Eigen::Map<const Eigen::ArrayXd>(u, modes()).abs()).sum();
  const double least = level - varies + delta_;
  const std::int64_t last = row_heights_ - 1;
  near_.clear();
  for (int bj = 0; bj < block_rows_; ++bj) {
    find_coefficients(block_across_.col(bj).data(), block_coefficients_);
    const auto strip = strip_highest2_.col(bj);
    for (int bi = 0; bi < row_blocks_; ++bi) {
      const std::int64_t from = std::min(base + bi * block_, last);
      const std::int64_t to = std::min(base + (bi + 1) * block_ - 1 + windows, last);
      const double displacement = block_table_.col(bi).dot(block_coefficients_);
      if (block_highest1_(bi, bj) + strip.segment(from, to - from + 1).maxCoeff() + displacement >=
          least)
        near_.push_back({bi, bj, displacement});
    }
  }
  // node by node, row by row
  out.clear();
  for (const NearBlock& block : near_) {
    const int last_row = std::min((block.row + 1) * block_, rows_);
    const int last_node = std::min((block.along + 1) * block_, row_nodes_);
    for (int j = block.row * block_; j < last_row; ++j)
      for (int i = block.along * block_; i < last_node; ++i) {
        double highest = face(j, base + i);
        for (int w = 1; w <= windows; ++w) highest = std::max(highest, face(j, base + i + w));
        const int node = j * row_nodes_ + i;
        if (height1_[node] + highest + block.displacement >= least) out.push_back(node);
      }
  }
  std::sort(out.begin(), out.end());
}

void ArealEquations::outer_force(double t, double* force) const {
  for (Index k = 0; k < load_.size(); ++k) force[k] = load_[k];
  for (const MovingForce& each : moving_) {
    const double x = each.start + each.speed * (t + lag);
    if (x < 0 || x > length_) continue;
    const double y = each.y.value();  // make_model refuses a scene without it
    for (Index k = 0; k < modes2_; ++k) {
      const int m = place_of_[k] % along_ + 1, n = place_of_[k] / along_ + 1;
      force[k] +=
          each.force * highest_ * std::sin(m * pi * x / length_) * std::sin(n * pi * y / width_);
    }
  }
}

}  // namespace ra2d::peers
