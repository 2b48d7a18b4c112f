#include "grouser/vehicle/rig_measured.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

namespace grouser::vehicle {

namespace {

std::string trimmed(const std::string& s) {
  const auto a = s.find_first_not_of(" \t\r");
  return a == std::string::npos ? "" : s.substr(a, s.find_last_not_of(" \t\r") - a + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(trimmed(cell));
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

/// A CSV table with one header line; lines that begin with # are notes.
struct Table {
  std::string file;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<int> lines;

  static Table read(const ConfigNode& node, const std::filesystem::path& path) {
    Table t;
    t.file = path.string();
    std::ifstream in(path);
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      if (trimmed(line).empty() || trimmed(line)[0] == '#') continue;
      auto cells = cells_of(line);
      if (t.columns.empty()) {
        t.columns = cells;
      } else if (cells.size() != t.columns.size()) {
        node.report(
            {t.file, number, 1,
             std::to_string(cells.size()) + " cells in a table of " + std::to_string(t.columns.size()) + " columns"});
      } else {
        t.rows.push_back(std::move(cells));
        t.lines.push_back(number);
      }
    }
    if (t.rows.empty()) node.report({t.file, 1, 1, "no data: a header line and at least one row are wanted"});
    return t;
  }

  std::vector<double> column(const ConfigNode& node, const std::string& key, const std::string& name,
                             double scale) const {
    std::vector<double> out;
    const auto at = std::find(columns.begin(), columns.end(), name);
    if (at == columns.end()) {
      const auto near = did_you_mean(name, columns);
      node.error_at(
          key, "the table " + file + " has no column '" + name + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
      return out;
    }
    const auto c = static_cast<std::size_t>(at - columns.begin());
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const std::string& cell = rows[r][c];
      double x = 0;
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), x);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(x)) {
        node.report({file, lines[r], 1, "column '" + name + "': '" + cell + "' is not a finite number"});
        x = 0;
      }
      out.push_back(x * scale);
    }
    return out;
  }
};

std::optional<double> unit_scale(const ConfigNode& node, const std::string& unit, const char* wanted) {
  try {
    const UnitScale u = parse_unit(unit);
    if (u.compatible(parse_unit(wanted))) return u.scale;
    node.error_at("unit", "'" + unit + "' is not a unit of this channel; it is measured in " + wanted);
  } catch (const std::invalid_argument& e) {
    node.error_at("unit", e.what());
  }
  return std::nullopt;
}

}  // namespace

const std::vector<RigChannel>& rig_channels() {
  static const std::vector<RigChannel> channels{{"drawbar_pull", "N", "N", 1},
                                                {"driving_torque", "N m", "Nm", 1},
                                                {"side_force", "N", "N", 1},
                                                {"normal_force", "N", "N", 1},
                                                {"sinkage", "m", "mm", 1000}};
  return channels;
}

RigMeasured load_rig_measured(const ConfigNode& node) {
  RigMeasured m;
  const std::filesystem::path path = node.existing_file("file");
  m.source = node.text_or("source", "");
  const std::string slip = node.text_or("slip", "slip");
  std::vector<std::pair<const RigChannel*, ConfigNode>> wanted;
  for (const RigChannel& c : rig_channels())
    if (const ConfigNode n = node.optional_map(c.name); n.present()) wanted.emplace_back(&c, n);
  if (wanted.empty())
    node.error("no channel is compared; give at least one, for example 'drawbar_pull: {column: drawbar_N, unit: N}'");
  node.finish();
  const bool readable = std::filesystem::is_regular_file(path);
  const Table table = readable ? Table::read(node, path) : Table{};
  m.file = path.string();
  if (readable) m.slip = table.column(node, "slip", slip, 1);
  for (const auto& [c, n] : wanted) {
    RigMeasuredChannel channel{c->name, {}, {}};
    const std::string column = n.text("column");
    const auto scale = unit_scale(n, n.text("unit"), c->unit);
    const std::string error = n.text_or("error", "");
    n.finish();
    if (!readable || !scale) continue;
    channel.value = table.column(n, "column", column, *scale);
    if (!error.empty()) channel.error = table.column(n, "error", error, *scale);
    m.channels.push_back(std::move(channel));
  }
  return m;
}

}  // namespace grouser::vehicle
