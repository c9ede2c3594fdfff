// SPDX-License-Identifier: BSD-3-Clause
#include "host/commands/manual.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/commands/completion.hpp"
#include "host/scene_file/key_facts.hpp"
#include "host/system/input_file.hpp"
#include "host/system/partial_file.hpp"

namespace ra2d {
namespace {

/// A text as roff prints it.
std::string roff(const std::string& text) {
  std::string safe;
  for (const char c : text) switch (c) {
      case '\\':
        safe += "\\e";
        break;
      case '-':
        safe += "\\-";
        break;
      case '\'':
        safe += "\\(aq";
        break;
      case '"':
        safe += "\\(dq";
        break;
      case '`':
        safe += "\\(ga";
        break;
      case '^':
        safe += "\\(ha";
        break;
      case '~':
        safe += "\\(ti";
        break;
      default:
        safe += c;
    }
  return safe.starts_with('.') ? "\\&" + safe : safe;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string tagged(const std::string& tag, const std::string& text) {
  return ".TP\n" + tag + '\n' + (text.empty() ? "\\&" : text) + '\n';
}

std::string heading(const std::string& text) { return ".SH \"" + roff(text) + "\"\n"; }

std::string upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

std::string title_line(const std::string& name, const std::string& section) {
  return fmt::format(
      ".\\\" Made by the build of ra2d.\n.TH {} {} \"\" \"{}\" \"ra2d\"\n.nh\n.ad l\n",
      roff(upper(name)), section, roff("ra2d " + version()));
}

std::string page_name(const std::string& path) {
  std::string name = path;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

std::string reference(const std::string& name, const std::string& section) {
  return fmt::format("\\fB{}\\fR({})", roff(name), section);
}

/// "ra2d run [OPTIONS] SCENE", with the command in bold and the rest in italics.
std::string synopsis(const CommandFacts& command) {
  return bold(command.path) + italic(command.usage().substr(command.path.size()));
}

/// The tag of an option: its names in bold, the value in italics.
std::string option_tag(const OptionFacts& option) {
  std::string tag;
  for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
  if (!option.value.empty())
    tag += (tag.empty() ? "" : " ") + italic(option.value) +
           (option.names.empty() && option.repeats ? "..." : "");
  return tag;
}

/// The first clause of a description, for the line that apropos(1) shows.
std::string summary(std::string description) {
  if (const std::string prefix = "ra2d: "; description.starts_with(prefix))
    description.erase(0, prefix.size());
  std::size_t end = description.size();
  for (const char* mark : {"; ", ": ", ". "}) end = std::min(end, description.find(mark));
  return description.substr(0, end);
}

/// A description as a sentence.
std::string sentence(std::string description) {
  if (description.empty()) return description;
  if (description[0] >= 'a' && description[0] <= 'z' && !description.starts_with("ra2d"))
    description[0] = static_cast<char>(description[0] - 'a' + 'A');
  if (!description.ends_with('.')) description += '.';
  return description;
}

std::string manual_page(const CommandFacts& command, const CommandFacts& program) {
  std::string text = title_line(page_name(command.path), "1");
  text += heading("NAME") + roff(page_name(command.path)) + " \\- " +
          roff(summary(command.description)) + '\n';
  text += heading("SYNOPSIS") + synopsis(command) + '\n';
  text += heading("DESCRIPTION") + roff(sentence(command.description)) + '\n';
  if (!command.arguments.empty()) text += heading("ARGUMENTS");
  for (const OptionFacts& argument : command.arguments)
    text += tagged(option_tag(argument), roff(argument.text()));
  for (const auto& [group, options] : command.grouped_options()) {
    text += heading(upper(group));
    for (const OptionFacts* option : options)
      text += tagged(option_tag(*option), roff(option->text()));
  }
  if (!command.commands.empty()) text += heading("COMMANDS");
  for (const CommandFacts& below : command.commands)
    text += tagged(reference(page_name(below.path), "1"), roff(below.description));
  text += heading("EXIT STATUS");
  for (const auto& [number, meaning] : exit_statuses()) text += tagged(bold(number), roff(meaning));
  text += heading("SEE ALSO");
  if (command.path != program.path) text += reference(program.path, "1") + ", ";
  return text + reference(program.path + "-scene", "5") +
         "\n.PP\nThe pages of the documentation are installed in share/doc/ra2d/docs.\n";
}

void add_pages(const CommandFacts& command, const CommandFacts& program,
               std::vector<NamedText>& pages) {
  pages.emplace_back(page_name(command.path) + ".1", manual_page(command, program));
  for (const CommandFacts& below : command.commands) add_pages(below, program, pages);
}

/// A line of Markdown with its code, bold words and links.
std::string inline_roff(const std::string& line) {
  std::string text, plain;
  const auto flush = [&] {
    text += roff(plain);
    plain.clear();
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto until = [&](const char* mark, std::size_t from) { return line.find(mark, from); };
    std::size_t end = line.npos;
    if (line[i] == '`' && (end = until("`", i + 1)) != line.npos) {
      flush();
      text += bold(line.substr(i + 1, end - i - 1));
      i = end;
    } else if (line.compare(i, 2, "**") == 0 && (end = until("**", i + 2)) != line.npos) {
      flush();
      text += "\\fB" + inline_roff(line.substr(i + 2, end - i - 2)) + "\\fR";
      i = end + 1;
    } else if (line[i] == '[' && (end = until("](", i)) != line.npos &&
               until(")", end) != line.npos) {
      flush();
      text += inline_roff(line.substr(i + 1, end - i - 1));
      i = until(")", end);
    } else {
      plain += line[i];
    }
  }
  flush();
  return text;
}

/// The cells of a line "| a | b |".
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 1; begin < line.size();) {
    const std::size_t end = std::min(line.find('|', begin), line.size());
    cells.emplace_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

/// An entry of a table: the first cell is its tag, the last one the text, and those between stand
/// in brackets.
std::string table_entry(const std::vector<std::string>& heads,
                        const std::vector<std::string>& cells) {
  std::string facts;
  for (std::size_t i = 1; i + 1 < cells.size() && i < heads.size(); ++i) {
    if (cells[i].empty()) continue;
    const bool says_itself =
        heads[i].find(',') != std::string::npos || cells[i].starts_with("required");
    facts += (facts.empty() ? "" : "; ") + (says_itself ? "" : heads[i] + ": ") + cells[i];
  }
  std::string text = cells.size() > 1 ? cells.back() : "";
  if (!facts.empty()) text += (text.empty() ? "(" : " (") + facts + ")";
  return tagged(inline_roff(cells.front()), inline_roff(text));
}

/// Turns a document in Markdown into the body of a page, line by line.
class MarkdownReader {
 public:
  void take(const std::string& line) {
    if (line.starts_with("```")) {
      close();
      text_ += is_code_ ? ".EE\n.RE\n" : ".RS 4\n.EX\n";
      is_code_ = !is_code_;
    } else if (is_code_) {
      text_ += roff(line) + '\n';
    } else if (line.empty() || line.starts_with("<!--")) {
      close();
    } else if (line.starts_with("# ")) {
      title_ = line.substr(2);
    } else if (line.starts_with("## ")) {
      close();
      text_ += ".SH " + inline_roff(line.substr(3)) + '\n';
      is_after_heading_ = true;
    } else if (line.starts_with("### ")) {
      close();
      text_ += ".SS " + inline_roff(line.substr(4)) + '\n';
      is_after_heading_ = true;
    } else if (line.starts_with('|')) {
      take_row(cells_of(line));
    } else if (line.starts_with("- ")) {
      text_ += ".IP \\(bu 2\n" + inline_roff(line.substr(2)) + '\n';
      is_in_paragraph_ = true;
    } else {
      if (!is_in_paragraph_ && !is_after_heading_) text_ += ".PP\n";
      text_ += inline_roff(line) + '\n';
      is_in_paragraph_ = true;
      is_after_heading_ = false;
    }
  }
  const std::string& title() const { return title_; }
  const std::string& text() const { return text_; }

 private:
  void close() {
    heads_.clear();
    is_in_paragraph_ = false;
  }
  void take_row(const std::vector<std::string>& cells) {
    if (heads_.empty())
      heads_ = cells;
    else if (!cells.empty() && !cells.front().starts_with("---"))
      text_ += table_entry(heads_, cells);
    is_after_heading_ = false;
  }

  std::string title_, text_;
  std::vector<std::string> heads_;  // of the table that is read
  bool is_code_ = false, is_in_paragraph_ = false, is_after_heading_ = false;
};

}  // namespace

std::vector<NamedText> manual_pages(const CommandFacts& program) {
  std::vector<NamedText> pages;
  add_pages(program, program, pages);
  return pages;
}

NamedText manual_of_markdown(const std::string& name, const std::string& section,
                             const std::string& document) {
  MarkdownReader reader;
  std::istringstream lines(document);
  for (std::string line; std::getline(lines, line);) reader.take(line);
  std::string title = reader.title();
  if (!title.empty() && title[0] >= 'A' && title[0] <= 'Z')
    title[0] = static_cast<char>(title[0] - 'A' + 'a');
  std::string body = reader.text();
  if (!body.starts_with(".SH")) body = heading("DESCRIPTION") + body;
  if (const std::string opening = heading("DESCRIPTION") + ".PP\n"; body.starts_with(opening))
    body.erase(opening.size() - 4, 4);
  return {fmt::format("{}.{}", name, section),
          title_line(name, section) + heading("NAME") + roff(name) + " \\- " + inline_roff(title) +
              '\n' + body + heading("SEE ALSO") + reference("ra2d", "1") + ", " +
              reference("ra2d-run", "1") + '\n'};
}

void write_manuals(const CommandFacts& program, const std::filesystem::path& folder,
                   const std::filesystem::path& scene_page) {
  InputStream in(scene_page, "the page of the scene");
  std::ostringstream page;
  page << in.rdbuf();
  const auto write = [&](const char* below, const NamedText& file) {
    std::filesystem::create_directories(folder / below);
    write_text(folder / below / file.first, file.second);
  };
  for (const NamedText& manual : manual_pages(program)) write("man/man1", manual);
  write("man/man5", manual_of_markdown("ra2d-scene", "5", with_key_tables(page.str())));
  write("bash-completion/completions", {"ra2d", bash_completion(program)});
  write("zsh/site-functions", {"_ra2d", zsh_completion(program)});
  write("fish/vendor_completions.d", {"ra2d.fish", fish_completion(program)});
}

}  // namespace ra2d
