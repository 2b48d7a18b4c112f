#include "figure_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "csv.h"
#include "grouser/terrain/config.h"

namespace grouser::report {

namespace {

using Row = CsvRecords::Row;

bool same(const std::string& cell, const std::string& value) {
  const auto a = parse_number(cell), b = parse_number(value);
  return a && b ? *a == *b : cell == value;
}

/// Tables that were read before: several series draw from one file.
class Tables {
 public:
  /// nullptr: the file is not there or is not a table; noted at the node.
  const CsvRecords* at(const ConfigNode& node) {
    const std::size_t before = node.errors();
    const std::filesystem::path file = node.existing_file("file");
    if (node.errors() != before) return nullptr;
    const auto found = tables_.find(file);
    if (found != tables_.end()) return &found->second;
    FileErrors errors(file);
    CsvRecords table = CsvRecords::read(file, errors);
    errors.report_to(node);
    return errors.any() ? nullptr : &tables_.emplace(file, std::move(table)).first->second;
  }

 private:
  std::map<std::filesystem::path, CsvRecords> tables_;
};

/// Index of the column that `key` names; the error stands at the key.
std::optional<std::size_t> column(const ConfigNode& node, const std::string& key, const CsvRecords& t) {
  const std::size_t before = node.errors();
  const std::string name = node.text(key);
  if (node.errors() != before) return std::nullopt;
  const auto k = t.column(name);
  if (!k) node.error_at(key, t.unknown_column(name));
  return k;
}

/// Rows that meet `where`. With none an error, so that no empty figure passes for a result.
std::vector<const Row*> selected(const ConfigNode& node, const CsvRecords& t) {
  std::vector<const Row*> rows;
  for (const Row& r : t.rows) rows.push_back(&r);
  const ConfigNode where = node.optional_map("where");
  if (!where.present()) return rows;
  bool wrong = false;
  for (const std::string& name : where.keys()) {
    const std::string value = where.text(name);
    const auto k = t.column(name);
    if (!k) {
      where.error_at(name, t.unknown_column(name));
      wrong = true;
      continue;
    }
    std::erase_if(rows, [&](const Row* r) { return !same(r->cells[*k].text, value); });
  }
  where.finish();
  if (rows.empty() && !wrong) node.error_at("where", "no row of the file meets this");
  return rows;
}

/// Numbers of one column; a cell that is none is an error at `key`.
std::vector<double> values(const ConfigNode& node, const std::string& key, const CsvRecords& t, std::size_t column,
                           const std::vector<const Row*>& rows, double scale) {
  std::vector<double> out;
  for (const Row* r : rows) {
    const auto& [cell, place] = r->cells[column];
    const bool gap = cell.empty() || cell == "nan";
    const auto v = gap ? std::numeric_limits<double>::quiet_NaN() : parse_number(cell);
    if (!v) {
      node.report({t.file.string(), r->line, place,
                   "column '" + t.columns[column] + "': '" + cell +
                       "' is not a number; the file of figures draws it as " + key});
      return {};
    }
    out.push_back(*v * scale);
  }
  return out;
}

/// Rows grouped by the text of one column, in the order of first appearance.
std::vector<std::pair<std::string, std::vector<const Row*>>> groups(const std::vector<const Row*>& rows,
                                                                    std::size_t column) {
  std::vector<std::pair<std::string, std::vector<const Row*>>> out;
  for (const Row* r : rows) {
    const auto it =
        std::find_if(out.begin(), out.end(), [&](const auto& g) { return g.first == r->cells[column].text; });
    auto& group = it == out.end() ? out.emplace_back(r->cells[column].text, std::vector<const Row*>{}) : *it;
    group.second.push_back(r);
  }
  return out;
}

void read_series(const ConfigNode& node, Tables& tables, Plot& plot) {
  Series s;
  s.name = node.text_or("name", "");
  s.style = static_cast<Series::Style>(std::map<std::string, int>{{"line", 0}, {"dashed", 1}, {"points", 2}}.at(
      node.choice_or("style", "line", {"line", "dashed", "points"})));
  s.colour = static_cast<int>(node.integer_or("colour", -1, 0, 7));
  const double x_scale = node.quantity_or("x_scale", 1, "1"), y_scale = node.quantity_or("y_scale", 1, "1");
  if (const CsvRecords* t = tables.at(node)) {
    const auto x = column(node, "x", *t), y = column(node, "y", *t);
    const auto error = node.has("error") ? column(node, "error", *t) : std::nullopt;
    const auto each = node.has("each") ? column(node, "each", *t) : std::nullopt;
    const auto rows = selected(node, *t);
    if (x && y && !rows.empty()) {
      const auto parts = each ? groups(rows, *each) : decltype(groups(rows, 0)){{"", rows}};
      for (const auto& [value, part] : parts) {
        Series one = s;
        if (const auto at = one.name.find("{}"); each && at != std::string::npos)
          one.name.replace(at, 2, value);
        else if (each)
          one.name += (one.name.empty() ? "" : " ") + value;
        one.x = values(node, "x", *t, *x, part, x_scale);
        one.y = values(node, "y", *t, *y, part, y_scale);
        if (error) one.error = values(node, "error", *t, *error, part, std::abs(y_scale));
        plot.series.push_back(std::move(one));
      }
    }
  } else {
    for (const char* key : {"x", "y", "error", "each", "where"}) node.node(key);  // named, not checked
  }
  node.finish();
}

Plot read_plot(const ConfigNode& node, Tables& tables) {
  Plot p;
  p.title = node.text("title");
  p.x_label = node.text("x_label");
  p.y_label = node.text("y_label");
  p.caption = node.text_or("caption", "");
  p.log_x = node.boolean_or("log_x", false);
  p.log_y = node.boolean_or("log_y", false);
  for (const ConfigNode& s : node.list("series")) read_series(s, tables, p);
  node.finish();
  return p;
}

std::string shown(const std::string& cell, int digits) {
  const auto v = digits > 0 ? parse_number(cell) : std::nullopt;
  if (!v) return cell;
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, *v, std::chars_format::general, digits).ptr;
  return {text, end};
}

FigureTable read_figure_table(const ConfigNode& node, Tables& tables) {
  FigureTable out;
  out.title = node.text_or("title", "");
  const auto digits = static_cast<int>(node.integer_or("digits", 0, 1, 15));
  std::vector<std::string> heads;
  for (const ConfigNode& h : node.optional_list("heads")) heads.push_back(h.as_text());
  const auto wanted = node.optional_list("columns");
  if (const CsvRecords* t = tables.at(node)) {
    std::vector<std::size_t> kept;
    for (const ConfigNode& c : wanted) {
      const auto k = t->column(c.as_text());
      if (k)
        kept.push_back(*k);
      else
        c.error(t->unknown_column(c.as_text()));
    }
    if (wanted.empty())
      for (std::size_t k = 0; k < t->columns.size(); ++k) kept.push_back(k);
    for (const std::size_t k : kept) out.columns.push_back(t->columns[k]);
    for (const Row* r : selected(node, *t)) {
      auto& row = out.rows.emplace_back();
      for (const std::size_t k : kept) row.push_back(shown(r->cells[k].text, digits));
    }
    if (!heads.empty() && heads.size() != kept.size())
      node.error_at("heads", std::to_string(heads.size()) + " heads for " + std::to_string(kept.size()) + " columns");
    else if (!heads.empty())
      out.columns = heads;
  } else {
    node.node("where");
  }
  node.finish();
  return out;
}

}  // namespace

FigurePage read_figures(const std::filesystem::path& yaml) {
  const ConfigDocument doc = ConfigDocument::from_file(yaml);
  FigurePage page;
  const ConfigNode root = doc.root();
  if (root.present()) {
    Tables tables;
    page.title = root.text("title");
    page.summary = root.text_or("summary", "");
    for (const ConfigNode& item : root.list("items")) {
      if (item.has("plot"))
        page.items.emplace_back(read_plot(item.map("plot"), tables));
      else if (item.has("table"))
        page.items.emplace_back(read_figure_table(item.map("table"), tables));
      else if (item.has("text"))
        page.items.emplace_back(Paragraph{item.text("text")});
      else if (item.keys().empty())
        item.error("an item is one of plot:, table:, text:");
      item.finish();
    }
    root.finish();
  }
  doc.check();
  return page;
}

}  // namespace grouser::report
