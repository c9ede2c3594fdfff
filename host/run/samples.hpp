// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <cstdint>
#include <vector>

#include "host/device/batch.hpp"
#include "host/model/model.hpp"
#include "host/result/record.hpp"

/// The rows that the march hands out, turned into the samples and shocks of a file, in SI units.
namespace ra2d {

/// The samples that were drained. The first of them is sample `first` of the run.
SampleBlock make_samples(const Model& model, const ModalStart& start, const Drained& drained,
                         std::int64_t first);

std::vector<Shock> make_shocks(const Model& model, const std::vector<ShockRow>& rows);

/// The shocks that are still going on, with their duration so far.
std::vector<Shock> make_shocks(const Model& model, const std::vector<OpenShock>& open);

}  // namespace ra2d
