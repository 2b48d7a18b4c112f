// Tables on disk: one HDF5 file in the form of a run, every grid point readable as it stands; and the YAML that asks
// for a table.
#include "grouser/terrain/csv.h"
#include "grouser/terrain/loaders.h"
#include "grouser/terrain/recorder.h"
#include "table_data.h"

namespace grouser::bekker {

namespace {

constexpr double format_version = 1;

/// Every block and sheet with the name of its datasets.
template <class Side, class Block, class Sheet>
void each_part(Side& sides, Block&& block, Sheet&& sheet) {
  for (auto& side : sides) {
    if (!side.present) continue;
    const std::string s = side.braking ? "braking" : "driving";
    sheet(s + ".edge_load", side.edge);
    for (auto* zone : {&side.deeper, &side.in_rut}) {
      const std::string z = s + (zone == &side.deeper ? ".deeper" : ".in_rut");
      sheet(z + ".turn", zone->turn);
      block(z + ".near", side, *zone, zone->near);
      block(z + ".far", side, *zone, zone->far);
    }
  }
}

const std::array<ChannelSpec, 4> channels{
    ChannelSpec{"entry_angle", "rad", "entry angle to the undisturbed ground", "", 1},
    ChannelSpec{"thrust", "N", "shear stress's share of the drawbar pull", "", 1},
    ChannelSpec{"resistance", "N", "pressure's share of the drawbar pull, positive against the travel", "", 1},
    ChannelSpec{"torque", "N m", "driving torque", "", 1}};
const std::array<ChannelSpec, 3> axes{
    ChannelSpec{"slip", "1", "slip of each point, (r w - v)/max(|r w|, |v|)", "", 1},
    ChannelSpec{"load", "N", "load of each point", "", 1},
    ChannelSpec{"unloading_sinkage", "m", "sinkage that an earlier pass left, of each point", "", 1}};

ChannelSpec named(const std::string& prefix, ChannelSpec s) {
  s.name = prefix + "." + s.name;
  return s;
}

std::vector<std::uint64_t> extents(const std::array<int, 3>& n) {
  return {static_cast<std::uint64_t>(n[0]), static_cast<std::uint64_t>(n[1]), static_cast<std::uint64_t>(n[2])};
}

/// Numbers of a table that are no grid, by name, for writing and reading alike.
template <class Data, class F>
void each_number(Data& d, F&& f) {
  auto& s = d.spec;
  f("wheel_radius", s.wheel.radius);
  f("wheel_width", s.wheel.width);
  f("lug_height", s.wheel.lug_height);
  f("lug_ratio", s.wheel.lug_ratio);
  f("slip_lower", s.slip.lower);
  f("slip_upper", s.slip.upper);
  f("load_lower", s.load.lower);
  f("load_upper", s.load.upper);
  f("unloading_sinkage_lower", s.unloading_sinkage.lower);
  f("unloading_sinkage_upper", s.unloading_sinkage.upper);
  f("error_bound", s.error_bound);
  f("error_found", d.error_found);
  for (std::size_t i = 0; i < 2; ++i) {
    auto& side = d.sides[i];
    const std::string n = i ? "braking" : "driving";
    f(n + ".deeper.zu_last", side.deeper.zu_last);
    f(n + ".in_rut.zu_first", side.in_rut.zu_first);
    f(n + ".in_rut.zu_last", side.in_rut.zu_last);
    f(n + ".in_rut.first", side.in_rut.first);
  }
}

}  // namespace

void WheelTable::write(const std::filesystem::path& file, const std::string& version) const {
  const Data& d = *data_;
  Recorder out = Recorder::create(file, {"table", d.spec.inputs, d.spec.title, "bekker", version, 0});
  out.set_attribute("table_format", format_version);
  out.set_attribute("hash", hash_text());
  each_number(d, [&](const std::string& name, double x) { out.set_attribute(name, x); });
  each_part(
      d.sides,
      [&](const std::string& name, const TableSide& side, const TableZone& zone, const TableBlock& b) {
        if (!b.present()) return;
        std::vector<double> column(b.values.size());
        for (std::size_t c = 0; c < channels.size(); ++c) {
          for (std::size_t i = 0; i < column.size(); ++i) column[i] = b.values[i][c];
          out.write_static(named(name, channels[c]), column, extents(b.n));
        }
        for (std::size_t c = 0; c < axes.size(); ++c) {
          std::size_t m = 0;
          for (int i = 0; i < b.n[0]; ++i)
            for (int j = 0; j < b.n[1]; ++j)
              for (int k = 0; k < b.n[2]; ++k)
                column[m++] = d.at(side, zone, &b == &zone.near, grid_place(b.n, i, j, k))[c];
          out.write_static(named(name, axes[c]), column, extents(b.n));
        }
      },
      [&](const std::string& name, const TableSheet& s) {
        if (s.values.empty()) return;
        const bool edge = name.ends_with("edge_load");
        out.write_static({name, edge ? "1" : "rad",
                          edge ? "log of the load [N] that just reaches the earlier pass's sinkage"
                               : "entry angle without slip, by which the braking slip is scaled",
                          "", 1},
                         s.values, {static_cast<std::uint64_t>(s.n[0]), static_cast<std::uint64_t>(s.n[1])});
      });
  out.close();
}

WheelTable WheelTable::read(const std::filesystem::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != "table")
    fail("is a " + in.attributes().kind + ", not a table; make one with 'grouser bekker table build'");
  const double format = in.number("table_format", 0);
  if (format != format_version)
    fail("is a table of format " + std::to_string(static_cast<int>(format)) + ", and this program reads format " +
         std::to_string(static_cast<int>(format_version)) + "; build the table again");
  WheelTable t(std::make_unique<Data>());
  Data& d = *t.data_;
  d.spec.inputs = in.attributes().scenario;
  d.spec.title = in.attributes().title;
  d.version = in.attributes().version;
  bool complete = true;
  each_number(d, [&](const std::string& name, double& x) {
    x = in.number(name, std::numeric_limits<double>::quiet_NaN());
    complete = complete && std::isfinite(x);
  });
  const auto damaged = [&] {
    fail("is damaged: its content does not match its stored hash; copy it again or build it again");
  };
  if (!complete || !(d.spec.load.lower > 0)) damaged();
  d.set_ranges();
  const auto read_grid = [&](const std::string& name, std::size_t count, auto& n) {
    std::vector<std::uint64_t> size;
    std::vector<double> v = in.read(name, &size);
    if (size.size() != count) damaged();
    for (std::size_t i = 0; i < count; ++i) n[i] = static_cast<int>(size[i]);
    return v;
  };
  each_part(
      d.sides,
      [&](const std::string& name, TableSide&, TableZone&, TableBlock& b) {
        if (!in.has(name + ".entry_angle")) return;
        for (std::size_t c = 0; c < channels.size(); ++c) {
          std::array<int, 3> n{};
          const std::vector<double> v = read_grid(name + "." + channels[c].name, 3, n);
          if (c == 0) {
            b.n = n;
            b.values.resize(v.size());
          }
          if (n != b.n) damaged();
          for (std::size_t i = 0; i < v.size(); ++i) b.values[i][c] = v[i];
        }
      },
      [&](const std::string& name, TableSheet& s) {
        if (in.has(name)) s.values = read_grid(name, 2, s.n);
      });
  if (t.hash_text() != in.attribute("hash")) damaged();
  for (TableSide& side : d.sides) {
    if (!side.present) continue;
    d.make_edge_splines(side);
    for (TableZone* z : {&side.deeper, &side.in_rut})
      if (!z->turn.values.empty()) z->turn.make_spline();
  }
  each_part(
      d.sides,
      [&](const std::string&, TableSide& side, TableZone& zone, TableBlock& b) {
        if (b.present()) d.make_spline(side, zone, b);
      },
      [](const std::string&, TableSheet&) {});
  return t;
}

namespace {

/// "5 N..200 N", "0..20 mm", "-0.7..0.9" or one value; a unit may stand once, at the end.
TableRange range_of(const ConfigNode& node, const std::string& key, const std::string& unit, Range allowed) {
  const ConfigNode value = node.node(key);
  if (!value.present()) {
    const std::string u = unit == "1" ? "" : " " + unit;
    node.error("missing key '" + key + "'; for example '" + key + ": " +
               (unit == "1" ? "-0.5..0.8" : "5.." + ("100" + u)) + "'");
    return {};
  }
  const std::string text = value.as_text();
  const std::size_t dots = text.find("..");
  std::string first = text.substr(0, dots), last = dots == std::string::npos ? first : text.substr(dots + 2);
  const auto trim = [](std::string s) {
    const auto a = s.find_first_not_of(' ');
    return a == std::string::npos ? std::string() : s.substr(a, s.find_last_not_of(' ') - a + 1);
  };
  first = trim(first);
  last = trim(last);
  // A lower end without a unit takes the upper end's.
  const std::size_t space = last.find(' ');
  if (unit != "1" && first.find_first_not_of("+-.0123456789eE") == std::string::npos && space != std::string::npos)
    first += last.substr(space);
  const auto end = [&](const std::string& s) {
    const ConfigDocument one = ConfigDocument::from_text(key + ": \"" + s + "\"", key);
    const double x = one.root().quantity(key, unit, allowed);
    for (const Diagnostic& e : one.diagnostics()) {
      const std::string prefix = key + ": ";
      node.error_at(key, e.message.starts_with(prefix) ? e.message.substr(prefix.size()) : e.message);
    }
    return x;
  };
  const std::size_t before = node.errors();
  const TableRange r{end(first), end(last)};
  if (node.errors() == before && r.upper < r.lower)
    node.error_at(key, "the range '" + text + "' runs down; write the lower end first");
  return r;
}

}  // namespace

TableSpec load_table_spec(const std::filesystem::path& file) {
  const ConfigDocument doc = ConfigDocument::from_file(file);
  const ConfigNode root = doc.root();
  if (!root.present()) doc.check();
  TableSpec s;
  s.title = root.text("table");
  const auto wheel_file = root.existing_file("wheel"), soil_file = root.existing_file("soil");
  s.slip = range_of(root, "slip", "1", Range::between(-1, 1));
  s.load = range_of(root, "load", "N", Range::positive());
  if (root.has("unloading_sinkage"))
    s.unloading_sinkage = range_of(root, "unloading_sinkage", "mm", Range::non_negative());
  s.error_bound = root.quantity_or("error_bound", s.error_bound, "1", Range::between(1e-5, 0.1));
  const std::string method = root.choice_or("method", "nonlinear", {"nonlinear", "quadratic", "linear"});
  s.method = method == "linear" ? Method::linear : method == "quadratic" ? Method::quadratic : Method::nonlinear;
  const std::string law = root.choice_or("theta_m_law", "linear", {"linear", "wong_braking"});
  root.finish();

  const auto part = [&](const std::filesystem::path& f, auto&& load) {
    if (!std::filesystem::is_regular_file(f)) return;  // noted already
    try {
      load(f);
    } catch (const ConfigError& e) {
      for (const Diagnostic& x : e.diagnostics()) root.report(x);
    }
  };
  part(wheel_file, [&](const std::filesystem::path& f) {
    const RunningGear gear = load_running_gear_file(f);
    s.wheel = {gear.radius(), gear.width()};
    if (const auto* lugged = std::get_if<LuggedCylinder>(&gear.shape)) {
      s.wheel.lug_height = lugged->lug_height;
      s.wheel.lug_ratio = lugged->lug_ratio;
    } else if (std::holds_alternative<TriangleMesh>(gear.shape)) {
      root.error_at("wheel",
                    "'" + gear.name + "' is a triangle mesh; the law needs a cylinder (shape: smooth or lugged)");
    }
  });
  part(soil_file, [&](const std::filesystem::path& f) {
    const Soil soil = load_soil_file(f);
    if (!soil.bekker) {
      root.error_at("soil", "soil '" + soil.name + "' has no 'bekker:' section");
      return;
    }
    s.soil = SoilLaw::of(*soil.bekker, s.wheel.width > 0 ? s.wheel.width : 1,
                         law == "linear" ? ThetaMLaw::linear : ThetaMLaw::wong_braking);
    if (s.unloading_sinkage.upper > 0 && !soil.bekker->repetitive)
      root.error_at(
          "unloading_sinkage",
          "soil '" + soil.name + "' has no 'repetitive:' section; give ko and Au there, or leave this key out");
  });
  doc.check();
  s.inputs = doc.text() + "--- # wheel\n" + read_text_file(wheel_file) + "--- # soil\n" + read_text_file(soil_file);
  return s;
}

}  // namespace grouser::bekker
