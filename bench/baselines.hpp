// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host/model/model.hpp"

/// Baselines for the march: the paper's method as one would first write it, and the best that a
/// simple program does. Every node at every step, penalty contact, backward Euler. They keep the
/// state, the sum of V^2 and the number of steps in contact, which is less than the march records.
/// For pinned resonators, as in the paper.
namespace ra2d::bench {

/// The modes of one body and their step (kernels/schemes/backward_euler.hpp).
struct BaselineModes {
  std::vector<double> u, v, square;
  std::vector<double> c0, c1, c2;  // V1 = c0 V0 + c1 U0 + c2 F0
  std::vector<double> load;        // N m^(-1/2)

  BaselineModes(const Body& body, const std::vector<double>& u0, const std::vector<double>& v0,
                double tau);
  void advance(const double* force, double tau);
};

/// psi is written where it stands: a sine for each node and mode, then again for the force where
/// they touch.
class Plain {
 public:
  Plain(const Model& model, const ModalStart& start);
  void march(std::int64_t steps);

  BaselineModes resonator, slider;
  std::int64_t step = 0, contact_steps = 0;

 private:
  double tau_, spacing_, position_, advance_, delta_, stiffness_;
  double amplitude_;             // sqrt(2/L)
  std::vector<double> wave_;     // 1/m, beta_k
  std::vector<double> shapes1_;  // (slider mode, node): these nodes do not move
  std::vector<double> height1_, height2_;
  std::vector<double> force1_, force2_;
};

/// psi is tabulated at the resonator's nodes. Surface and displacement of the resonator are
/// interpolated together between them, linearly: the displacement is one matrix times vector. A
/// nodal force goes to the two nodes next to it, which makes the modal force the transposed
/// product; it has few entries, and only those are multiplied.
class Tables {
 public:
  Tables(const Model& model, const ModalStart& start);
  void march(std::int64_t steps);

  BaselineModes resonator, slider;
  std::int64_t step = 0, contact_steps = 0;

 private:
  double tau_, position_, advance_, stiffness_;
  Eigen::MatrixXd shapes1_;            // slider node, mode
  Eigen::MatrixXd shapes2_;            // resonator node, mode
  Eigen::VectorXd height1_, height2_;  // h_1 - delta; h_2
  Eigen::VectorXd lower_, overlap_;    // work space
  std::vector<Eigen::Index> touching_;
  Eigen::VectorXd force1_, force2_;
};

}  // namespace ra2d::bench
