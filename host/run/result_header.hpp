// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/model/model.hpp"
#include "host/store/store.hpp"

namespace ra2d {

/// The beginning of a run's result file. `key`: run_key.
ResultHeader result_header(const Model& model, const std::string& key);

}  // namespace ra2d
