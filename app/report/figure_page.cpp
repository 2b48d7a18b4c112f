#include "figure_page.h"

#include <charconv>
#include <cmath>

#include "grouser/terrain/recorder.h"
#include "page.h"

namespace grouser::report {

using nlohmann::json;

namespace {

/// Seven digits are more than a plot shows and half the bytes; what is not finite is a gap.
json numbers(const std::vector<double>& values) {
  json out = json::array();
  for (const double v : values) {
    if (!std::isfinite(v)) {
      out.push_back(nullptr);
      continue;
    }
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, v, std::chars_format::general, 7).ptr;
    double rounded = 0;
    std::from_chars(text, end, rounded);
    out.push_back(rounded);
  }
  return out;
}

json to_json(const Series& s, const std::string& plot) {
  if (s.y.size() != s.x.size() || (!s.error.empty() && s.error.size() != s.x.size()))
    throw ResultsError("plot '" + plot + "', series '" + s.name + "': x, y and error have " +
                       std::to_string(s.x.size()) + ", " + std::to_string(s.y.size()) + " and " +
                       std::to_string(s.error.size()) + " values");
  constexpr const char* styles[] = {"line", "dashed", "points"};
  return {{"name", s.name},
          {"style", styles[static_cast<int>(s.style)]},
          {"x", numbers(s.x)},
          {"y", numbers(s.y)},
          {"error", numbers(s.error)},
          {"colour", s.colour}};
}

json to_json(const Plot& p) {
  json series = json::array();
  for (const Series& s : p.series) series.push_back(to_json(s, p.title));
  return {{"kind", "plot"},       {"title", p.title}, {"x_label", p.x_label}, {"y_label", p.y_label},
          {"caption", p.caption}, {"log_x", p.log_x}, {"log_y", p.log_y},     {"series", std::move(series)}};
}

json to_json(const FigureTable& t) {
  for (const auto& row : t.rows)
    if (row.size() != t.columns.size())
      throw ResultsError("table '" + t.title + "': a row has " + std::to_string(row.size()) + " cells where " +
                         std::to_string(t.columns.size()) + " columns are named");
  return {{"kind", "table"}, {"title", t.title}, {"columns", t.columns}, {"rows", t.rows}};
}

json to_json(const Paragraph& p) { return {{"kind", "text"}, {"text", p.text}}; }

}  // namespace

void write_figure_page(const FigurePage& page, const std::filesystem::path& html) {
  json items = json::array();
  for (const auto& item : page.items) items.push_back(std::visit([](const auto& i) { return to_json(i); }, item));
  write_page(html, page.title,
             {{"format", 1},
              {"title", page.title},
              {"runs", json::array()},
              {"rigs", json::array()},
              {"figures", {{"summary", page.summary}, {"items", std::move(items)}}}},
             {});
}

}  // namespace grouser::report
