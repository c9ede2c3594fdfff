// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace ra2d {

/// Numbers that all copies of this object hold in common: the maps of an areal scene take hundreds
/// of megabytes. Read like a vector.
class SharedNumbers {
 public:
  using value_type = double;
  using const_iterator = std::vector<double>::const_iterator;
  using iterator = const_iterator;

  SharedNumbers() : SharedNumbers(std::vector<double>()) {}
  SharedNumbers(std::initializer_list<double> numbers)
      : SharedNumbers(std::vector<double>(numbers)) {}
  SharedNumbers(std::vector<double> numbers)
      : numbers_{std::make_shared<std::vector<double>>(std::move(numbers))} {}

  operator const std::vector<double>&() const { return *numbers_; }
  std::size_t size() const { return numbers_->size(); }
  bool empty() const { return numbers_->empty(); }
  const double* data() const { return numbers_->data(); }
  const_iterator begin() const { return numbers_->begin(); }
  const_iterator end() const { return numbers_->end(); }
  const double& operator[](std::size_t n) const { return (*numbers_)[n]; }
  const double& back() const { return numbers_->back(); }

  /// To change them: a copy of its own, where other objects hold them, too.
  std::vector<double>& edit() {
    if (numbers_.use_count() > 1) numbers_ = std::make_shared<std::vector<double>>(*numbers_);
    return *numbers_;
  }

  friend bool operator==(const SharedNumbers& a, const SharedNumbers& b) {
    return *a.numbers_ == *b.numbers_;
  }
  friend bool operator==(const SharedNumbers& a, const std::vector<double>& b) {
    return *a.numbers_ == b;
  }

 private:
  std::shared_ptr<std::vector<double>> numbers_;
};

}  // namespace ra2d
