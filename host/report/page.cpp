// SPDX-License-Identifier: BSD-3-Clause
#include "host/report/page.hpp"

#include <fmt/format.h>

#include "host/base/version.hpp"
#include "host/report/html.hpp"
#include "host/report/page_style.hpp"

namespace ra2d {

std::string table_of(const FactTable& facts) {
  std::string rows;
  for (const auto& [name, value] : facts)
    rows += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", name, value);
  return "<table class=\"facts\">\n" + rows + "</table>\n";
}

std::string text_to_copy(const std::string& paragraph, const std::string& what,
                         const std::string& id, const std::string& text) {
  return fmt::format(
      "<p>{} <button type=\"button\" hidden data-copies=\"{}\">Copy {}</button></p>\n<pre "
      "id=\"{}\" tabindex=\"0\">{}</pre>\n",
      paragraph, id, what, id, html_lines(text));
}

std::string whole_page(const std::string& title, const std::string& body,
                       const std::string& command) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "http-equiv=\"Content-Security-Policy\" content=\"{}\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n<h1>{}</h1>\n{}<footer><p>Made by ra2d {} ({}) with <code>{}</code>. The "
      "page is "
      "complete in itself and fetches "
      "nothing.</p></footer>\n<script>{}</script>\n</body>\n</html>\n",
      page_policy, title, page_style, title, body, version(), commit(), html(command), page_script);
}

}  // namespace ra2d
