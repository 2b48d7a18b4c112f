#include "grouser/vehicle/rig_measured.h"

#include <optional>

#include "grouser/terrain/csv.h"

namespace grouser::vehicle {

namespace {

/// [SI] one value per row; cells that are no finite number are errors at their place.
std::vector<double> column(const CsvRecords& t, const ConfigNode& node, const std::string& key, const std::string& name,
                           double scale) {
  std::vector<double> out;
  const auto c = t.column(name);
  if (!c) {
    node.error_at(key, t.unknown_column(name));
    return out;
  }
  FileErrors errors(t.file);
  for (const CsvRecords::Row& row : t.rows) {
    const CsvCell& cell = row.cells[*c];
    const auto x = parse_number(cell.text);
    if (!x) errors.add(row.line, cell.column, "column '" + name + "': '" + cell.text + "' is not a finite number");
    out.push_back(x.value_or(0) * scale);
  }
  errors.report_to(node);
  return out;
}

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
  FileErrors errors(path);
  CsvRecords table;
  if (std::filesystem::is_regular_file(path))
    table = CsvRecords::read(path, errors);  // else the error is noted already
  const bool readable = !table.columns.empty();
  if (readable && table.rows.empty() && !errors.any())
    errors.add(1, 1, "no data: a header line and at least one row are wanted");
  errors.report_to(node);
  m.file = path.string();
  if (readable) m.slip = column(table, node, "slip", slip, 1);
  for (const auto& [c, n] : wanted) {
    RigMeasuredChannel channel{c->name, {}, {}};
    const std::string named = n.text("column");
    const auto scale = unit_scale(n, n.text("unit"), c->unit);
    const std::string error = n.text_or("error", "");
    n.finish();
    if (!readable || !scale) continue;
    channel.value = column(table, n, "column", named, *scale);
    if (!error.empty()) channel.error = column(table, n, "error", error, *scale);
    m.channels.push_back(std::move(channel));
  }
  return m;
}

}  // namespace grouser::vehicle
