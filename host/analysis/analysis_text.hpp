// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>
#include <vector>

#include "host/analysis/analysis.hpp"

/// An analysis as text: for people, for programs (docs/analysis.md) and for tables.
namespace ra2d {

/// One screen.
std::string describe(const Analysis& analysis);

/// The means of several, a line a figure.
std::string describe_means(const std::vector<Analysis>& analyses);

/// One object, or of several {"files": [...], "mean": {...}}; null for what is not finite. Ends with a
/// line end.
std::string json_of(const std::vector<Analysis>& analyses);

/// Comma-separated, with a first line of names: the spectrum's lines, the bands, and the bins of the
/// shocks' histograms.
std::string spectrum_csv(const Analysis& analysis);
std::string bands_csv(const Analysis& analysis);
std::string shocks_csv(const Analysis& analysis);

}  // namespace ra2d
