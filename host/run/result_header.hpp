// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/model/model.hpp"
#include "host/store/store.hpp"

namespace ra2d {

/// What a result file says of a run before its first step. `key`: run_key.
ResultHeader result_header(const Model& model, const std::string& key);

}  // namespace ra2d
