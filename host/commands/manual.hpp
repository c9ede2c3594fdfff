// SPDX-License-Identifier: BSD-3-Clause
#pragma once
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "host/commands/command_facts.hpp"

/// Manual pages (roff, macros of man(7)), from the facts that the help has, too.
namespace ra2d {

/// A file that is installed: its name, and its text.
using NamedText = std::pair<std::string, std::string>;

/// A page for the program and for each of its commands: "ra2d.1", "ra2d-study-merge.1".
std::vector<NamedText> manual_pages(const CommandFacts& program);

/// The page of a document in Markdown, "ra2d-scene.5" from docs/scene.md. The document's title
/// becomes the page's name line. Headings, paragraphs, lists, tables, code, bold and links are
/// understood. An entry of a table becomes a tagged paragraph.
NamedText manual_of_markdown(const std::string& name, const std::string& section,
                             const std::string& document);

/// Writes all manual pages and completions into folders below `folder`, laid out as below
/// PREFIX/share: man/man1, man/man5, bash-completion/completions, zsh/site-functions,
/// fish/vendor_completions.d. `scene_page` is docs/scene.md. The build calls it.
void write_manuals(const CommandFacts& program, const std::filesystem::path& folder,
                   const std::filesystem::path& scene_page);

}  // namespace ra2d
