// SPDX-License-Identifier: BSD-3-Clause
#include "host/store/shock_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "host/store/read_back.hpp"

namespace ra2d {
namespace {

/// Rows of all the shocks' datasets, in memory.
class ShockWindow {
 public:
  explicit ShockWindow(const std::vector<Table>& tables)
      : tables_{tables}, columns_(tables.size()), row_(tables.size()) {
    for (std::size_t k = 0; k < tables.size(); ++k)
      if (tables[k].entry->path == std::string_view{"shocks/start"}) start_ = k;
  }

  void read(hsize_t first, hsize_t rows) {
    for (std::size_t k = 0; k < tables_.size(); ++k) {
      columns_[k].resize(rows);
      tables_[k].read(first, rows, columns_[k].data());
    }
  }
  void write(hsize_t first) const {
    for (std::size_t k = 0; k < tables_.size(); ++k)
      tables_[k].write(first, rows(), columns_[k].data());
  }
  std::size_t rows() const { return columns_.front().size(); }
  const double* column(std::size_t k) const { return columns_[k].data(); }
  double start(std::size_t row) const { return columns_[start_][row]; }
  bool is_full(std::size_t row) const { return !std::isnan(start(row)); }
  void put(std::size_t row, const Shock& shock) {
    for (std::size_t k = 0; k < tables_.size(); ++k)
      columns_[k][row] = std::get<PerShock>(tables_[k].entry->source).get(shock);
  }
  void close_holes() {
    std::size_t kept = 0;
    for (std::size_t row = 0; row < rows(); ++row)
      if (is_full(row)) {
        for (std::vector<double>& column : columns_) column[kept] = column[row];
        ++kept;
      }
    for (std::vector<double>& column : columns_) column.resize(kept);
  }
  void add(std::size_t row, HashSum& sum) { sum.add(gathered(row), row_.size()); }
  void take_back(std::size_t row, HashSum& sum) { sum.take_back(gathered(row), row_.size()); }

 private:
  const double* gathered(std::size_t row) {
    for (std::size_t k = 0; k < columns_.size(); ++k) row_[k] = columns_[k][row];
    return row_.data();
  }
  const std::vector<Table>& tables_;
  std::vector<std::vector<double>> columns_;  // of tables_
  std::vector<double> row_;
  std::size_t start_ = 0;  // the column of the starts
};

}  // namespace

long ShockRows::row_of(const Shock& shock) const {
  const std::vector<long>& open = start_.open_shocks;
  if (shock.serial >= start_.shocks_begun)
    return static_cast<long>(open.size()) + (shock.serial - start_.shocks_begun);
  const auto place = std::lower_bound(open.begin(), open.end(), shock.serial);
  if (place == open.end() || *place != shock.serial)
    throw std::logic_error("Shock: it began before the file, and was not going on there");
  return place - open.begin();
}

hsize_t ShockRows::rows_with(const std::vector<Shock>& shocks) const {
  hsize_t rows = rows_;
  for (const Shock& shock : shocks) rows = std::max<hsize_t>(rows, row_of(shock) + 1);
  return rows;
}

std::size_t ShockRows::growth(const std::vector<Shock>& shocks) const {
  return (rows_with(shocks) - rows_) * tables_.size() * sizeof(double);
}

/// Window by window: what a window holds already is read, the new rows are put in, and it goes back
/// in one piece, which is far quicker than a selection of single rows.
void ShockRows::write(std::vector<Shock>& shocks) {
  rows_ = rows_with(shocks);
  for (const Table& table : tables_) table.resize(rows_);

  std::stable_sort(shocks.begin(), shocks.end(),
                   [](const Shock& a, const Shock& b) { return a.serial < b.serial; });
  ShockWindow window(tables_);
  for (auto begin = shocks.begin(); begin != shocks.end();) {
    const long first = row_of(*begin);
    const long limit = (first / long(rows_at_once) + 1) * long(rows_at_once);  // a chunk's end
    const auto end = std::find_if(begin, shocks.end(),
                                  [&](const Shock& shock) { return row_of(shock) >= limit; });
    window.read(first, row_of(*(end - 1)) - first + 1);
    for (auto shock = begin; shock != end; ++shock) {
      const std::size_t row = row_of(*shock) - first;
      if (window.is_full(row)) window.take_back(row, sum_);  // an earlier word on this one
      window.put(row, *shock);
      window.add(row, sum_);
    }
    window.write(first);
    begin = end;
  }
  shocks.clear();
}
/// In place and window by window.
void ShockRows::close_holes() {
  hsize_t kept = 0;
  HashSum sum;
  double last = -std::numeric_limits<double>::infinity();
  ShockWindow window(tables_);
  for (hsize_t first = 0; first < rows_; first += rows_at_once) {
    const hsize_t count = std::min<hsize_t>(rows_at_once, rows_ - first);
    window.read(first, count);
    window.close_holes();
    for (std::size_t row = 0; row < window.rows(); ++row) {
      window.add(row, sum);
      require_as_given(last <= window.start(row));
      last = window.start(row);
    }
    for (std::size_t k = 0; k < tables_.size(); ++k)
      tables_[k].add_to_hash(window.column(k), window.rows());
    if (kept != first || window.rows() != count) window.write(kept);
    kept += window.rows();
  }
  require_as_given(sum == sum_);
  if (kept != rows_)
    for (const Table& table : tables_) table.resize(kept);
  rows_ = kept;
}
}  // namespace ra2d
