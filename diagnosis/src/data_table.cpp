#include "grouser/diagnosis/data_table.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <optional>

namespace grouser::diagnosis {
namespace {

namespace fs = std::filesystem;

/// What a header says behind its last '_'.
std::optional<std::string> unit_in_name(const std::string& name) {
  const std::string suffix = name.substr(name.rfind('_') + 1);
  if (name.find('_') == std::string::npos) return std::nullopt;
  if (suffix == "Nm") return "N m";
  for (const char* unit : {"mm", "cm", "m", "N", "kN", "Pa", "kPa", "MPa", "deg", "rad", "s", "kg", "g"})
    if (suffix == unit) return suffix;
  return std::nullopt;
}

std::optional<double> scale_of(const ConfigNode& node, const std::string& unit, std::string_view wanted) {
  try {
    const UnitScale u = parse_unit(unit);
    if (u.compatible(parse_unit(wanted))) return u.scale;
    node.error("'" + unit + "' is not a unit of this quantity; it is measured in " + std::string(wanted));
  } catch (const std::invalid_argument& e) {
    node.error(e.what());
  }
  return std::nullopt;
}

bool same(const std::string& cell, const std::string& text) {
  if (cell == text) return true;
  const auto a = parse_number(cell), b = parse_number(text);
  return a && b && *a == *b;
}

fs::path resolved_file(const ConfigNode& node) {
  const ConfigNode entry = node.node("file");
  const std::string prefix = "GROUSER_DATA/";
  if (!entry.is_scalar() || entry.as_text().rfind(prefix, 0) != 0) return node.existing_file("file");
  const fs::path full = measured_data_folder() / entry.as_text().substr(prefix.size());
  if (fs::is_regular_file(full)) return full;
  entry.error("file '" + entry.as_text() + "' not found; looked for " + full.string() +
              "; set GROUSER_DATA to the folder of the measured data");
  return {};
}

}  // namespace

fs::path measured_data_folder() {
  const char* named = std::getenv("GROUSER_DATA");
  return named ? fs::path(named) : fs::path("../shared/data/measured");
}

DataTable DataTable::load(const ConfigNode& node) {
  DataTable t;
  t.file_ = resolved_file(node);
  const std::size_t before = node.errors();
  if (!fs::is_regular_file(t.file_)) {
    if (node.has("where")) node.node("where");
    if (node.has("skip")) node.node("skip");
    t.file_.clear();
    return t;
  }
  FileErrors errors(t.file_);
  t.records_ = CsvRecords::read(t.file_, errors);
  if (t.records_.rows.empty() && !errors.any())
    errors.add(1, 1, "no data: a header line and at least one row are wanted");
  errors.report_to(node);
  t.keep(node, "where", true);
  t.keep(node, "skip", false);
  if (node.errors() == before && t.records_.rows.empty())
    node.error_at("where", "no row of " + t.file_.string() + " is left");
  return t;
}

int DataTable::column(const ConfigNode& node, const std::string& key, const std::string& name) const {
  const auto at = records_.column(name);
  if (at) return static_cast<int>(*at);
  node.error_at(key, records_.unknown_column(name));
  return -1;
}

std::vector<bool> DataTable::picked(const ConfigNode& map) const {
  std::vector<bool> in(size(), true);
  for (const std::string& name : map.keys()) {
    const ConfigNode value = map.node(name);
    std::vector<std::string> allowed;
    if (value.is_list())
      for (const ConfigNode& item : value.items()) allowed.push_back(item.as_text());
    else
      allowed.push_back(value.as_text());
    const int c = column(map, name, name);
    for (std::size_t r = 0; r < size(); ++r)
      in[r] = in[r] && c >= 0 && std::any_of(allowed.begin(), allowed.end(), [&](auto& a) {
                return same(records_.rows[r].cells[static_cast<std::size_t>(c)].text, a);
              });
  }
  return in;
}

void DataTable::keep(const ConfigNode& node, const std::string& key, bool wanted) {
  const ConfigNode map = node.optional_map(key);
  if (!map.present() || columns().empty()) return;
  const std::size_t before = node.errors();
  const std::vector<bool> in = picked(map);
  if (node.errors() != before) return;
  std::vector<CsvRecords::Row> rows;
  for (std::size_t r = 0; r < records_.rows.size(); ++r)
    if (in[r] == wanted) rows.push_back(std::move(records_.rows[r]));
  records_.rows = std::move(rows);
}

std::vector<double> DataTable::quantity(const ConfigNode& node, const std::string& key, std::string_view unit) const {
  const ConfigNode entry = node.node(key);
  if (!entry.present()) {
    node.text(key);  // notes the missing key
    return {};
  }
  std::string name, column_unit(unit);
  if (entry.is_map() && (entry.has("value") || entry.has("assumed")))
    return std::vector<double>(size(), entry.as_quantity(unit));
  if (entry.is_map()) {
    name = entry.text("column");
    if (unit != "1" || entry.has("unit")) column_unit = entry.text("unit");
    entry.finish();
  } else {
    const std::string text = entry.is_scalar() ? entry.as_text() : "";
    const bool a_column = std::find(columns().begin(), columns().end(), text) != columns().end();
    const bool a_number =
        !text.empty() && (std::isdigit(static_cast<unsigned char>(text[0])) || text[0] == '-' || text[0] == '.');
    if (a_number && !a_column) return std::vector<double>(size(), entry.as_quantity(unit));
    name = text;
    if (key == "column" && node.has("unit")) {
      column_unit = node.text("unit");
    } else if (unit != "1") {
      const auto in_name = unit_in_name(name);
      if (!in_name && a_column) {
        node.error_at(key,
                      "the unit of column '" + name + "' is not in its name; write {column: " + name + ", unit: ...}");
        return {};
      }
      column_unit = in_name.value_or(std::string(unit));
    }
  }
  if (columns().empty()) return {};
  const int c = column(node, key, name);
  if (c < 0) return {};
  const auto scale = scale_of(entry, column_unit, unit);
  if (!scale) return {};
  std::vector<double> out;
  bool good = true;
  for (std::size_t r = 0; r < size(); ++r) {
    const CsvCell& cell = records_.rows[r].cells[static_cast<std::size_t>(c)];
    const auto x = parse_number(cell.text);
    if (!x) {
      node.report(
          {file_.string(), line(r), cell.column, "column '" + name + "': '" + cell.text + "' is not a finite number"});
      good = false;
      continue;
    }
    out.push_back(*x * *scale);
  }
  return good ? out : std::vector<double>{};
}

std::vector<std::string> DataTable::label(const ConfigNode& node, const std::string& key) const {
  std::vector<std::string> out(size());
  const ConfigNode entry = node.node(key);
  if (!entry.present()) return out;
  std::vector<std::string> names;
  if (entry.is_list())
    for (const ConfigNode& item : entry.items()) names.push_back(item.as_text());
  else
    names.push_back(entry.as_text());
  if (columns().empty()) return out;
  for (const std::string& name : names) {
    const int c = column(node, key, name);
    if (c < 0) return out;
    for (std::size_t r = 0; r < size(); ++r)
      out[r] += (out[r].empty() ? "" : " ") + records_.rows[r].cells[static_cast<std::size_t>(c)].text;
  }
  return out;
}

}  // namespace grouser::diagnosis
