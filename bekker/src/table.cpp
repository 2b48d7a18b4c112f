#include "grouser/bekker/table.h"

#include "grouser/terrain/state.h"
#include "table_data.h"

namespace grouser::bekker {

std::string_view name_of(TableStatus status) {
  switch (status) {
    case TableStatus::ok:
      return "ok";
    case TableStatus::slip_out_of_range:
      return "slip_out_of_range";
    case TableStatus::load_out_of_range:
      return "load_out_of_range";
    case TableStatus::unloading_sinkage_out_of_range:
      return "unloading_sinkage_out_of_range";
  }
  return "";
}

double sinkage_of(double radius, double theta_f) {
  const double half = std::sin(0.5 * theta_f);
  return 2 * radius * half * half;
}

void WheelTable::Data::set_ranges() {
  radius = spec.wheel.outer_radius();
  load_first = std::log(spec.load.lower);
  load_last = std::log(spec.load.upper);
  const TableRange s = spec.slip;
  const auto set = [](TableSide& side, bool brakes, double first, double last) {
    side.present = true;
    side.braking = brakes;
    side.first = first;
    side.last = last;
    side.edge_first = brakes ? 0 : first;
    side.edge_last = brakes ? std::max(last, 0.8) : last;
    side.slip_scale = TableScale(side.first, side.last);
    side.edge_scale = TableScale(side.edge_first, side.edge_last);
  };
  zu_scale = TableScale(0, spec.unloading_sinkage.upper);
  load_scale = TableScale(load_first, load_last).scale;
  if (s.upper >= 0) set(sides[0], false, std::max(s.lower, 0.0), s.upper);
  if (s.lower < 0) set(sides[1], true, std::sqrt(std::max(-s.upper, 0.0)), std::sqrt(-s.lower));
}

std::array<double, 3> WheelTable::Data::at(const TableSide& s, const TableZone& z, bool near,
                                           const std::array<double, 3>& p) const {
  const double zu = z.zu_first + p[2] * (z.zu_last - z.zu_first);
  double t = s.first + p[0] * (s.last - s.first);
  if (s.braking) {
    const double turn = turn_share * z.turn.at(p[1], p[2]);
    t = std::min(near ? p[0] * turn : turn + p[0] * (beyond(turn, s.last, 0.05) - turn), 1.0);
  }
  const Edge e = edge(s, t, zu);
  const double log_load = e.from + (&z == &s.in_rut ? z.first * (1 - p[1]) : e.span > 0 ? p[1] / e.span : 0);
  return {s.braking ? braking_slip(spec, t) : t, std::exp(log_load), zu};
}

void WheelTable::Data::make_spline(const TableSide& side, const TableZone& zone, TableBlock& block) const {
  std::vector<double> scaled;
  scaled.reserve(4 * block.values.size());
  std::size_t m = 0;
  for (int i = 0; i < block.n[0]; ++i)
    for (int j = 0; j < block.n[1]; ++j)
      for (int k = 0; k < block.n[2]; ++k) {
        const TableValues& v = block.values[m++];
        const double load = at(side, zone, &block == &zone.near, grid_place(block.n, i, j, k))[1];
        scaled.insert(scaled.end(), {v[0], v[1] / load, v[2] / load, v[3] / (load * radius)});
      }
  block.spline = spline_coefficients(scaled, block.n, 4);
  const std::size_t row = 4 * (static_cast<std::size_t>(block.n[2]) + 2);
  block.view = {block.spline.data(),
                row,
                row * (static_cast<std::size_t>(block.n[1]) + 2),
                SplineAxis(block.n[0]),
                SplineAxis(block.n[1]),
                SplineAxis(block.n[2])};
}

void WheelTable::Data::make_edge_splines(TableSide& side) const {
  for (TableZone* z : {&side.deeper, &side.in_rut}) {
    z->zu_scale = TableScale(z->zu_first, z->zu_last);
    z->load_scale = z->first < 0 ? -1 / z->first : 0;
  }
  if (virgin()) return;
  side.edge.make_spline();
  side.span.n = side.edge.n;
  side.span.values.clear();
  for (const double e : side.edge.values) side.span.values.push_back(1 / (beyond(e, load_last, 0.2) - e));
  side.span.make_spline();
}

void TableSheet::make_spline() {
  const std::vector<float> three = spline_coefficients(values, {n[0], n[1], 1}, 1);
  spline.clear();
  for (std::size_t i = 0; i < three.size(); i += 3) spline.push_back(three[i]);
  view = {spline.data(), static_cast<std::size_t>(n[1]) + 2, SplineAxis(n[0]), SplineAxis(n[1])};
}

std::uint64_t WheelTable::Data::hash() const {
  State s;
  auto text = spec.inputs + "\n" + spec.title;
  s.field("inputs", text);
  double numbers[] = {spec.wheel.radius,
                      spec.wheel.width,
                      spec.wheel.lug_height,
                      spec.wheel.lug_ratio,
                      spec.slip.lower,
                      spec.slip.upper,
                      spec.load.lower,
                      spec.load.upper,
                      spec.unloading_sinkage.lower,
                      spec.unloading_sinkage.upper,
                      spec.error_bound,
                      error_found};
  s.reals("numbers", numbers, std::size(numbers));
  auto add = [&s](const std::vector<double>& v) {
    std::vector<double> copy = v;
    s.field("values", copy);
  };
  for (const TableSide& side : sides) {
    add(side.edge.values);
    for (const TableZone* z : {&side.deeper, &side.in_rut}) {
      add({z->zu_first, z->zu_last, z->first});
      add(z->turn.values);
      for (const TableBlock* b : {&z->near, &z->far}) {
        std::vector<double> v;
        for (const TableValues& x : b->values) v.insert(v.end(), x.begin(), x.end());
        add(v);
      }
    }
  }
  return s.hash();
}

// Compiled for each instruction set and chosen at run time.
namespace {
struct Found {
  Four values;
  double sinkage;
};
[[gnu::always_inline]] inline Found look_up_here(const WheelTable::Data& d, double slip, double load, double zu) {
  const Four x = WheelTable::Data::interpolate(d.find(slip, load, zu));
  const double half = sin_cos_polynomial(0.5 * static_cast<double>(x[0])).sin;
  return {x, 2 * d.radius * half * half};
}
Found look_up_any(const WheelTable::Data& d, double slip, double load, double zu) {
  return look_up_here(d, slip, load, zu);
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) Found look_up_avx2(const WheelTable::Data& d, double slip, double load, double zu) {
  return look_up_here(d, slip, load, zu);
}
__attribute__((target("avx512f,avx512dq,avx512vl,fma"))) Found look_up_avx512(const WheelTable::Data& d, double slip,
                                                                              double load, double zu) {
  return look_up_here(d, slip, load, zu);
}
#endif

auto best_look_up() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return look_up_avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return look_up_avx2;
#endif
  return look_up_any;
}
const auto look_up = best_look_up();
}  // namespace

TableStatus WheelTable::query(double slip, double load, double zu, TablePoint& out) const noexcept {
  const Data& d = *data_;
  if (!d.spec.slip.contains(slip)) return TableStatus::slip_out_of_range;
  if (!d.spec.load.contains(load)) return TableStatus::load_out_of_range;
  if (!d.spec.unloading_sinkage.contains(zu)) return TableStatus::unloading_sinkage_out_of_range;
  const auto [x, sinkage] = look_up(d, slip, load, zu);
  out.entry_angle = x[0];
  out.thrust = load * x[1];
  out.resistance = load * x[2];
  out.torque = load * d.radius * x[3];
  out.sinkage = sinkage;
  out.unloading_sinkage = std::max(zu, out.sinkage);
  return TableStatus::ok;
}

WheelTable::WheelTable(std::unique_ptr<Data> d) : data_(std::move(d)) {}
WheelTable::WheelTable(WheelTable&&) noexcept = default;
WheelTable& WheelTable::operator=(WheelTable&&) noexcept = default;
WheelTable::~WheelTable() = default;

const TableSpec& WheelTable::spec() const { return data_->spec; }
double WheelTable::error_found() const { return data_->error_found; }
std::string WheelTable::version() const { return data_->version; }
std::uint64_t WheelTable::hash() const { return data_->hash(); }
std::string WheelTable::hash_text() const {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash()));
  return text;
}
std::size_t WheelTable::points() const {
  std::size_t n = 0;
  for (const TableSide& s : data_->sides)
    for (const TableZone* z : {&s.deeper, &s.in_rut}) n += z->near.values.size() + z->far.values.size();
  return n;
}
std::string WheelTable::grid_text() const {
  std::string text;
  const auto add = [&text](const TableSide& s, const char* zone, const char* part, const TableBlock& b) {
    if (!b.present()) return;
    text += (text.empty() ? "" : "; ") + std::string(s.braking ? "braking " : "driving ") + zone + part + " " +
            std::to_string(b.n[0]) + " x " + std::to_string(b.n[1]) + " x " + std::to_string(b.n[2]);
  };
  for (const TableSide& s : data_->sides) {
    add(s, "deeper", " near", s.deeper.near);
    add(s, "deeper", s.braking ? " far" : "", s.deeper.far);
    add(s, "in the rut", " near", s.in_rut.near);
    add(s, "in the rut", s.braking ? " far" : "", s.in_rut.far);
  }
  return text;
}

}  // namespace grouser::bekker
