// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "bench/peers/contact_equations.hpp"
#include "host/base/shared_numbers.hpp"
#include "host/model/model.hpp"

/// The equations of areal scenes: a plate pinned along its edges under a block.
///
/// Slider node (j, i) stands at (X + i chi, y_j) on the plate, X = x_0 + V t. There the plate's
/// displacement is, with q_mj = sum_n U_mn 2/sqrt(a b) sin(n pi y_j/b) and alpha_m = m pi/a,
///
///   sum_m q_mj (sin(alpha_m X) cos(alpha_m i chi) + cos(alpha_m X) sin(alpha_m i chi)),
///
/// and that of the block A_j + B_j i chi. So one table of a row's nodes serves every row and time:
/// cosines, sines, 1 and i chi. A row's coefficients are found once, those of some nodes or of all.
namespace ra2d::peers {

class ArealEquations final : public ContactEquations {
 public:
  explicit ArealEquations(const Model& model);

  int nodes() const override { return rows_ * row_nodes_; }
  /// By blocks of the map first: the highest h_1 of a block and the highest h_2 that comes under
  /// it, with the displacement in its middle and a bound on what that varies within the block.
  void list_above(double t, std::int64_t base, int windows, const double* u, double level,
                  std::vector<int>& out) override;
  void evaluate_only(const std::vector<int>& nodes) override;
  void contact(double t, const double* u, double* force) override;
  void outer_force(double t, double* force) const override;

  /// Overlaps [m] of the nodes that contact() evaluates, in their order.
  const Eigen::VectorXd& overlaps(double t, const double* u);

 private:
  /// Nodes of one row among those evaluated: `nodes_` from `first` on.
  struct RowOfNodes {
    int row;
    std::size_t first, count;
  };
  /// A block that may hold nodes to list, and the displacement in its middle [m].
  struct NearBlock {
    int along, row;
    double displacement;
  };

  void add_row(int row, int first, int last);
  void locate(double t);
  void set_displacements(const double* u);
  /// Of a line of constant y, for `table_`; `across`: of every (n) of the plate and of every mode
  /// of the slider.
  void find_coefficients(const double* across, Eigen::Ref<Eigen::VectorXd> out);
  double face(int row, std::int64_t at) const;
  void add_faces(int row, double* overlap) const;

  int rows_, row_nodes_, row_heights_;
  SharedNumbers height1_, height2_;  // m
  double delta_;                     // m
  double length_, width_;            // m, of the plate

  int along_, across_;         // the plate's largest m and n
  std::vector<int> place_of_;  // of each mode of the plate in `amplitude_`: m - 1 + along (n - 1)
  double highest_;             // 1/m, 2/sqrt(a b)
  Eigen::ArrayXd constant_, tilt_;  // of each mode of the slider, along x: 1/m, 1/m^2
  Eigen::MatrixXd table_;           // of a row's nodes (2 along + 2, i)
  Eigen::MatrixXd across_rows_;  // of each row: sin(n pi y/b), then across(y) of the slider's modes

  /// Blocks of `block_` x `block_` nodes: (row of blocks, block along x).
  int block_, block_rows_, row_blocks_;
  Eigen::MatrixXd block_table_, block_across_;  // as table_ and across_rows_, in their middles
  Eigen::ArrayXXd block_highest1_;              // m, of h_1 (block along x, row of blocks)
  Eigen::ArrayXXd strip_highest2_;  // m, of h_2 over a row of blocks (node, row of blocks)
  Eigen::ArrayXd variation_;        // of |psi| from a block's middle to its nodes

  // where the slider stands
  std::int64_t base_ = 0;
  double theta_ = 0;              // chi
  Eigen::ArrayXd sine_, cosine_;  // of alpha_m X

  Eigen::MatrixXd amplitude_;  // U_mn 2/sqrt(a b)
  Eigen::VectorXd u1_, line_;
  Eigen::VectorXd block_coefficients_;
  Eigen::MatrixXd coefficients_;  // a column for each of `lines_`
  std::vector<int> nodes_;        // evaluated: i
  std::vector<RowOfNodes> lines_;
  Eigen::VectorXd overlap_, row_force_;
  Eigen::MatrixXd forces_;  // as amplitude_
  std::vector<NearBlock> near_;
};

}  // namespace ra2d::peers
