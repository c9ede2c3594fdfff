// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <string>

#include "host/report/asked.hpp"

/// The parts of all pages of `ra2d report`.
namespace ra2d {

std::string table_of(const FactTable& facts);

/// A paragraph (markup), a button that copies, and the text itself (none). `what` it is to the
/// button, `id` to the page.
std::string text_to_copy(const std::string& paragraph, const std::string& what,
                         const std::string& id, const std::string& text);

/// A page, complete in itself; title and body are markup. `command`: what made it.
std::string whole_page(const std::string& title, const std::string& body,
                       const std::string& command);

}  // namespace ra2d
