#include "grouser/sdem/tables.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compact_file.h"
#include "grouser/terrain/state.h"
#include "grouser/terrain/types.h"

namespace grouser::sdem {

namespace fs = std::filesystem;

namespace {

constexpr double kFormat = 1;
constexpr const char* kKind = "sdem tables";

bool is_soil(std::size_t part) { return part < 4; }

/// Numbers by name, for writing, reading and hashing alike.
template <class T, class F>
void each_number(T& t, F&& f) {
  f("radius_m", t.radius);
  f("width_m", t.width);
  f("bed_depth_m", t.bed_depth);
  for (std::size_t p = 0; p < t.parts.size(); ++p) {
    const std::string n = kPartNames[p];
    f(n + ".u_first", t.parts[p].u.first);
    f(n + ".u_last", t.parts[p].u.last);
    f(n + ".v_first", t.parts[p].v.first);
    f(n + ".v_last", t.parts[p].v.last);
  }
}

bool ascending(const std::vector<double>& x) {
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(x[i]) || (i > 0 && x[i] <= x[i - 1])) return false;
  return !x.empty();
}

}  // namespace

Axis Axis::even(double first, double last, double spacing) {
  return {first, last, std::max(2, static_cast<int>(std::lround((last - first) / spacing)) + 1)};
}

void Grid::resize(std::size_t nodes) {
  for (auto* values : {&x, &z, &known}) values->assign(nodes * plane(), 0.0F);
}

void Tables::shape(const GridSettings& g) {
  const double r = radius, m = g.reach;
  const auto grid = [&](Part p, Axis u, Axis v) {
    part(p).u = u;
    part(p).v = v;
    part(p).resize(nodes());
  };
  const auto cells = [&](double a, double b) { return Axis::even(a, b, g.cell); };
  grid(Part::soil_bottom, cells(-m, 0), cells(-r, r));
  grid(Part::soil_top, cells(0, m), cells(-r, r));
  grid(Part::soil_left, cells(-m, m), cells(-m, -r));
  grid(Part::soil_right, cells(-m, m), cells(r, m));
  const Axis theta = Axis::even(-pi / 2, pi / 2, g.angle);
  grid(Part::wheel_bottom, Axis::even(g.lowest, g.highest, g.height), theta);
  grid(Part::wheel_top, Axis::even(0, m, g.height), theta);
}

std::size_t Tables::bytes() const {
  std::size_t n = 0;
  for (const Grid& g : parts) n += (g.x.size() + g.z.size()) * sizeof(float);
  return n;
}

std::string Tables::hash_text() const {
  Tables t = *this;
  State s;
  for (auto* text : {&t.title, &t.source, &t.wheel, &t.soil, &t.inputs}) s.field("text", *text);
  each_number(t, [&](const std::string& name, double& x) { s.field(name, x); });
  for (auto* nodes : {&t.w, &t.vx, &t.vz}) s.field("nodes", *nodes);
  for (const Grid& g : t.parts)
    for (const auto* v : {&g.x, &g.z, &g.known}) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(v->data());
      std::vector<std::uint8_t> copy(bytes, bytes + v->size() * sizeof(float));
      s.field("values", copy);
    }
  return s.hash_text();
}

std::vector<std::string> Tables::faults() const {
  std::vector<std::string> out;
  if (!(radius > 0 && width > 0 && bed_depth > 0)) out.push_back("radius, width and bed depth must be positive");
  for (const auto& [name, nodes] : {std::pair{"w", &w}, {"vx", &vx}, {"vz", &vz}})
    if (!ascending(*nodes)) out.push_back(std::string("the velocity nodes of ") + name + " do not ascend");
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Grid& g = parts[p];
    const std::string n = kPartNames[p];
    if (g.u.count < 2 || g.v.count < 2 || !(g.u.last > g.u.first) || !(g.v.last > g.v.first)) {
      out.push_back(n + " has an axis without extent");
      continue;
    }
    for (const auto* v : {&g.x, &g.z, &g.known})
      if (v->size() != nodes() * g.plane()) {
        out.push_back(n + " has " + std::to_string(v->size()) + " values for " + std::to_string(nodes()) +
                      " velocity nodes of " + std::to_string(g.plane()));
        break;
      }
    if (!std::all_of(g.x.begin(), g.x.end(), [](float f) { return std::isfinite(f); }) ||
        !std::all_of(g.z.begin(), g.z.end(), [](float f) { return std::isfinite(f); }))
      out.push_back(n + " has values that are not finite");
  }
  return out;
}

void Tables::write(const fs::path& file) const {
  if (const auto wrong = faults(); !wrong.empty()) throw ResultsError(file.string() + ": " + wrong.front());
  write_whole(file, [&](const fs::path& part) {
    {
      Recorder out = Recorder::create(part, {kKind, inputs, title, "sdem.v1", GROUSER_VERSION, 0});
      out.set_attribute("table_format", kFormat);
      out.set_attribute("hash", hash_text());
      out.set_attribute("source", source);
      out.set_attribute("wheel", wheel);
      out.set_attribute("soil", soil);
      each_number(*this, [&](const std::string& name, double x) { out.set_attribute(name, x); });
      out.write_static({"w", "rad/s", "spin of the wheel, nodes", "C", 1}, w, {w.size()});
      out.write_static({"vx", "m/s", "velocity forward, nodes", "C", 1}, vx, {vx.size()});
      out.write_static({"vz", "m/s", "velocity upward, nodes", "C", 1}, vz, {vz.size()});
      for (std::size_t p = 0; p < parts.size(); ++p) {
        const bool soil_part = is_soil(p);
        const std::string n = kPartNames[p];
        for (const bool first : {true, false}) {
          const Axis& a = first ? parts[p].u : parts[p].v;
          std::vector<double> at;
          for (int i = 0; i < a.count; ++i) at.push_back(a.at(i));
          const char* what = soil_part ? (first ? "place over the hub" : "place ahead of the hub")
                             : first   ? (p == 4 ? "hub above the floor" : "soil above the hub")
                             : p == 4  ? "angle from the lowest point, positive forward"
                                       : "angle from the highest point, positive forward";
          out.write_static({n + (first ? ".u" : ".v"), soil_part || first ? "m" : "rad", what, "C", 1}, at,
                           {at.size()});
        }
      }
      out.close();
    }
    std::vector<CompactArray> arrays;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const Grid& g = parts[p];
      const std::string n = kPartNames[p], unit = is_soil(p) ? "m/s" : "Pa";
      const std::vector<std::uint64_t> dims{nodes(), static_cast<std::uint64_t>(g.u.count),
                                            static_cast<std::uint64_t>(g.v.count)};
      const char* what = is_soil(p) ? "velocity of the surface there, node (w, vx, vz; vz fastest) x u x v"
                                    : "soil on wheel over the rim, node (w, vx, vz; vz fastest) x u x v";
      arrays.push_back({{n + ".x", unit, what, "C", 1}, g.x, dims});
      arrays.push_back({{n + ".z", unit, what, "C", 1}, g.z, dims});
      arrays.push_back({{n + ".known", "1", "1: from a run, 0: estimated", "", 1}, g.known, dims});
    }
    add_compact(part, arrays);
  });
}

Tables Tables::read(const fs::path& file) {
  const RunFile in(file);
  const auto fail = [&file](const std::string& what) { throw ResultsError(file.string() + ": " + what); };
  if (in.attributes().kind != kKind)
    fail("is a " + in.attributes().kind + ", not tables of the surrogate; make them with 'grouser sdem build'");
  if (in.number("table_format", 0) != kFormat)
    fail("holds tables of another format than this program reads; build them again");
  const auto damaged = [&] {
    fail("is damaged: its content does not match its stored hash; copy it again or build it again");
  };
  Tables t;
  t.inputs = in.attributes().scenario;
  t.title = in.attributes().title;
  t.source = in.attribute("source");
  t.wheel = in.attribute("wheel");
  t.soil = in.attribute("soil");
  each_number(
      t, [&](const std::string& name, double& x) { x = in.number(name, std::numeric_limits<double>::quiet_NaN()); });
  t.w = in.read("w");
  t.vx = in.read("vx");
  t.vz = in.read("vz");
  for (std::size_t p = 0; p < t.parts.size(); ++p) {
    Grid& g = t.parts[p];
    const auto read = [&](const std::string& what, std::vector<float>& out) {
      std::vector<std::uint64_t> dims;
      const std::vector<double> v = in.read(kPartNames[p] + what, &dims);
      if (dims.size() != 3) damaged();
      g.u.count = static_cast<int>(dims[1]);
      g.v.count = static_cast<int>(dims[2]);
      out.assign(v.begin(), v.end());
    };
    read(".x", g.x);
    read(".z", g.z);
    read(".known", g.known);
  }
  if (t.hash_text() != in.attribute("hash")) damaged();
  if (const auto wrong = t.faults(); !wrong.empty()) fail(wrong.front());
  return t;
}

}  // namespace grouser::sdem
