// Building a table: grids are refined axis by axis until points between the grid's agree with the law.
#include <algorithm>
#include <atomic>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdio>
#include <optional>

#include "grouser/terrain/parallel.h"
#include "grouser/terrain/types.h"
#include "table_data.h"

namespace grouser::bekker {

namespace {

constexpr double aim = 0.7;       // share of the bound that the checked points must stay below
constexpr double per_axis = 0.3;  // share of the bound that one axis may take
constexpr std::size_t axis_samples = 1500;
constexpr std::size_t check_samples = 20000;
constexpr int edge_slips = 33, edge_depths = 65, turn_grid = 25;

std::string text(double x) {
  char buf[32];
  std::snprintf(buf, sizeof buf, "%.4g", x);
  return buf;
}

/// Tolerance of the law's own quadrature: far below the table's error.
double law_tolerance(const TableSpec& s) { return std::clamp(0.01 * s.error_bound, 1e-10, 1e-5); }

[[noreturn]] void no_equilibrium(double slip, double load, double zu, ForceStatus status) {
  throw TableError("no equilibrium at slip " + text(slip) + ", load " + text(load) + " N, unloading sinkage " +
                   text(1000 * zu) + " mm: " + std::string(name_of(status)) + "; narrow the ranges of the table");
}

/// Angles with theta_m and theta_r by the soil's laws.
ForceCase case_at(const TableSpec& s, double slip, double theta_f) {
  const ContactRange r = contact_range(s.soil, theta_f, slip);
  return {s.wheel, s.soil, {theta_f, r.theta_m, r.theta_r}, slip, 0, 0};
}

/// Deepest point of the surface that carries most of the load: the tips of the lugs or the surface between them. Where
/// that surface hardly touches, a share of the tips' depth keeps it above 0.
double deepest(const TableSpec& s, const ForceCase& c) {
  const double rs = s.wheel.outer_radius(), main = s.wheel.lug_ratio > 0.5 ? rs : s.wheel.radius;
  const double cm = std::cos(c.arc.theta_m), cf = std::cos(c.arc.theta_f);
  return std::max((s.wheel.lug_height > 0 ? main : rs) * cm - rs * cf, 0.02 * rs * (cm - cf));
}

/// Entry angle at which the deepest point is zu below the ground.
double angle_reaching(const TableSpec& s, double slip, double zu) {
  const auto excess = [&](double theta_f) { return deepest(s, case_at(s, slip, theta_f)) - zu; };
  const double high = pi / 2;
  if (!(excess(high) > 0))
    throw TableError("unloading sinkage " + text(1000 * zu) + " mm: the wheel would be in to its hub; lower the range");
  std::uintmax_t iterations = 100;
  const auto close = [](double a, double b) { return std::abs(b - a) <= 1e-12 * std::abs(b); };
  const auto bracket = boost::math::tools::toms748_solve(excess, 0.0, high, -zu, excess(high), close, iterations);
  return 0.5 * (bracket.first + bracket.second);
}

/// Log of the load that just reaches the sinkage zu of an earlier pass again. Below the range of loads it turns
/// smoothly into a constant, log 4 under the range: no block has to go on to no load at all.
double edge_load(const TableSpec& s, double slip, double zu) {
  const double c = std::log(4.0), first = std::log(s.load.lower);
  double x = -1e9;
  if (zu > 0) {
    ForceCase f = case_at(s, slip, angle_reaching(s, slip, zu));
    f.unloading_sinkage = zu;
    const ForceResult r = forces(f, s.method, law_tolerance(s));
    if (r.status == ForceStatus::ok && r.wrench.Fz > 0) x = std::log(r.wrench.Fz) - first;
  }
  return first + (x < 0 ? -c * (1 - std::exp(x / c)) : x);
}

/// Point of the R3 sequence (Roberts 2018): evenly spread for any count, the same in every build.
std::array<double, 3> spread(std::size_t i) {
  static constexpr double g[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  std::array<double, 3> p;
  for (int k = 0; k < 3; ++k) {
    const double x = 0.5 + g[k] * static_cast<double>(i + 1);
    p[static_cast<std::size_t>(k)] = x - std::floor(x);
  }
  return p;
}

using Request = std::array<double, 3>;  // slip, load, unloading sinkage

}  // namespace

ForceStatus table_values(const TableSpec& s, double slip, double load, double zu, TableValues& out) {
  LoadCase c{s.wheel, s.soil, load, slip, 0, zu};
  const double tolerance = law_tolerance(s);
  const Solution x = solve(c, s.method, tolerance);
  if (x.status != ForceStatus::ok) return x.status;
  // The pressure's share of the drawbar pull is what is left without strength.
  ForceCase smooth{s.wheel, s.soil, x.arc, slip, 0, zu};
  smooth.soil.shear.cohesion = smooth.soil.shear.friction_angle = smooth.soil.tan_phi = 0;
  const ForceResult pressure = forces(smooth, s.method, tolerance);
  if (pressure.status != ForceStatus::ok) return pressure.status;
  out = {x.arc.theta_f, x.wrench.Fx - pressure.wrench.Fx, -pressure.wrench.Fx, -x.wrench.My};
  return ForceStatus::ok;
}

class TableBuilder {
 public:
  TableBuilder(WheelTable& t, int threads, const std::function<void(const WheelTable::Progress&)>& progress)
      : table_(t), d_(*t.data_), threads_(threads), progress_(progress) {}

  void run() {
    for (TableSide& side : d_.sides) {
      if (!side.present) continue;
      if (!d_.virgin()) make_edge(side);
      d_.make_edge_splines(side);
      for (TableZone* zone : {&side.deeper, &side.in_rut}) {
        if (zone == &side.in_rut && !(zone->first < 0)) continue;
        double near_from = 0, near_to = 0;
        if (side.braking) {
          make_turn(side, *zone);
          const auto [least, most] = std::minmax_element(zone->turn.values.begin(), zone->turn.values.end());
          near_from = turn_share * *least;
          near_to = turn_share * *most;
        }
        if (side.braking && side.first < near_to) refine(side, *zone, zone->near);
        if (!side.braking || side.last > near_from) refine(side, *zone, zone->far);
      }
    }
  }

 private:
  WheelTable& table_;
  WheelTable::Data& d_;
  int threads_;
  const std::function<void(const WheelTable::Progress&)>& progress_;

  /// f(i) for all i on the threads, in fixed groups with progress between them.
  void each(std::size_t n, const char* part, const std::function<void(std::size_t)>& f) {
    const std::size_t group = 4096;
    for (std::size_t i = 0; i < n; i += group) {
      const std::size_t count = std::min(group, n - i), chunk = 64;
      parallel_for(static_cast<int>((count + chunk - 1) / chunk), threads_, [&](int k) {
        const std::size_t from = i + static_cast<std::size_t>(k) * chunk;
        for (std::size_t m = from; m < std::min(from + chunk, i + count); ++m) f(m);
      });
      if (progress_) progress_({part, i + count, n});
    }
  }

  std::vector<TableValues> evaluate(const std::vector<Request>& at, const char* part) {
    std::vector<TableValues> out(at.size());
    each(at.size(), part, [&](std::size_t i) {
      const ForceStatus status = table_values(d_.spec, at[i][0], at[i][1], at[i][2], out[i]);
      if (status != ForceStatus::ok) no_equilibrium(at[i][0], at[i][1], at[i][2], status);
    });
    return out;
  }

  bool one_slip(const TableSide& s) const { return !(s.last > s.first); }
  bool one_load() const { return !(d_.load_last > d_.load_first); }

  /// The edge, and how far either side of it the zones go.
  void make_edge(TableSide& side) {
    TableSheet& e = side.edge;
    const double top = d_.spec.unloading_sinkage.upper;
    e.n = {one_slip(side) && !side.braking ? 1 : edge_slips, edge_depths};
    e.values.resize(static_cast<std::size_t>(e.n[0]) * e.n[1]);
    const auto zu_at = [&](int b) { return top * b / (e.n[1] - 1); };
    each(e.values.size(), "edge of the rut", [&](std::size_t i) {
      const int a = static_cast<int>(i) / e.n[1], b = static_cast<int>(i) % e.n[1];
      const double t = side.edge_first + grid_place({e.n[0], 1, 1}, a, 0, 0)[0] * (side.edge_last - side.edge_first);
      e.values[i] = edge_load(d_.spec, side.braking ? braking_slip(d_.spec, t) : t, zu_at(b));
    });
    // The rut's zone begins where no load of the range is below the edge; the other ends where every load is.
    int first = e.n[1] - 1, last = 0;
    double largest = d_.load_first;
    for (int b = 0; b < e.n[1]; ++b)
      for (int a = 0; a < e.n[0]; ++a) {
        const double x = e.values[static_cast<std::size_t>(a) * e.n[1] + b];
        largest = std::max(largest, x);
        if (x > d_.load_first) first = std::min(first, b);
        if (x < d_.load_last) last = std::max(last, b);
      }
    side.deeper.zu_last = zu_at(std::min(last + 1, e.n[1] - 1));
    side.in_rut.zu_first = zu_at(std::max(first - 1, 0));
    side.in_rut.zu_last = top;
    side.in_rut.first = largest > d_.load_first ? d_.load_first - largest - 0.01 : 0;
  }

  void make_turn(const TableSide& side, TableZone& zone) {
    TableSheet& s = zone.turn;
    s.n = {one_load() && &zone == &side.deeper && d_.virgin() ? 1 : turn_grid, d_.virgin() ? 1 : turn_grid};
    s.values.assign(static_cast<std::size_t>(s.n[0]) * s.n[1], 0.0);
    s.make_spline();
    each(s.values.size(), "entry angle", [&](std::size_t i) {
      const int a = static_cast<int>(i) / s.n[1], b = static_cast<int>(i) % s.n[1];
      const Request q = d_.at(side, zone, true, grid_place({1, s.n[0], s.n[1]}, 0, a, b));
      TableValues v;
      const ForceStatus status = table_values(d_.spec, braking_slip(d_.spec, 0), q[1], q[2], v);
      if (status != ForceStatus::ok) no_equilibrium(0, q[1], q[2], status);
      s.values[i] = std::min(v[0], 0.99 / turn_share);
    });
    s.make_spline();
  }

  void fill(const TableSide& side, const TableZone& zone, TableBlock& block) {
    std::vector<Request> points;
    for (int i = 0; i < block.n[0]; ++i)
      for (int j = 0; j < block.n[1]; ++j)
        for (int k = 0; k < block.n[2]; ++k)
          points.push_back(d_.at(side, zone, &block == &zone.near, grid_place(block.n, i, j, k)));
    block.values = evaluate(points, "grid");
    d_.make_spline(side, zone, block);
  }

  /// Largest error of all outputs, each in the measure of TableSpec::error_bound.
  double error(const TableBlock& block, const std::array<double, 3>& p, const Request& q,
               const TableValues& exact) const {
    const Four x = WheelTable::Data::interpolate({&block, p[0], p[1], p[2]});
    const double load = q[1], thrust = x[1] - exact[1] / load, resistance = x[2] - exact[2] / load;
    const double h = sinkage_of(d_.radius, exact[0]);
    return std::max({std::abs(thrust), std::abs(resistance), std::abs(thrust - resistance),
                     std::abs(x[3] - exact[3] / (load * d_.radius)), std::abs(x[0] - exact[0]) / exact[0],
                     std::abs(sinkage_of(d_.radius, x[0]) - h) / h});
  }

  struct Check {
    double worst = 0;
    std::vector<std::array<double, 3>> places;  ///< the worst ones
  };
  Check errors_at(const TableSide& side, const TableZone& zone, const TableBlock& block,
                  const std::vector<std::array<double, 3>>& places, const char* part) {
    std::vector<Request> points;
    std::vector<std::array<double, 3>> inside;
    for (const auto& p : places) {
      const Request q = d_.at(side, zone, &block == &zone.near, p);
      // Beyond what may be asked the blocks need not be right.
      if (!d_.spec.slip.contains(q[0]) || !d_.spec.load.contains(q[1])) continue;
      points.push_back(q);
      inside.push_back(p);
    }
    const std::vector<TableValues> exact = evaluate(points, part);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < points.size(); ++i) order.emplace_back(error(block, inside[i], points[i], exact[i]), i);
    std::sort(order.rbegin(), order.rend());
    Check c;
    if (!order.empty()) c.worst = order[0].first;
    for (std::size_t i = 0; i < std::min<std::size_t>(order.size(), 60); ++i)
      c.places.push_back(inside[order[i].second]);
    return c;
  }

  /// Error of one axis alone: half way between points of it, on points of the others.
  double axis_error(const TableSide& side, const TableZone& zone, const TableBlock& block, std::size_t axis,
                    const std::vector<std::array<double, 3>>& suspects) {
    if (block.n[axis] == 1) return 0;
    std::vector<std::array<double, 3>> places;
    const auto add = [&](std::array<double, 3> p) {
      for (std::size_t k = 0; k < 3; ++k) {
        const int cells = block.n[k] - 1;
        if (cells == 0) continue;
        p[k] = k == axis ? (std::min(std::floor(p[k] * cells), cells - 1.0) + 0.5) / cells
                         : std::round(p[k] * cells) / cells;
      }
      places.push_back(p);
    };
    for (std::size_t i = 0; i < axis_samples; ++i) add(spread(i));
    for (const auto& p : suspects) add(p);
    return errors_at(side, zone, block, places, "check of one axis").worst;
  }

  void refine(const TableSide& side, const TableZone& zone, TableBlock& block) {
    block.n = {one_slip(side) && !side.braking ? 1 : 9, one_load() && d_.virgin() ? 1 : 7, d_.virgin() ? 1 : 7};
    std::vector<std::array<double, 3>> suspects;
    for (;;) {
      fill(side, zone, block);
      std::array<double, 3> e;
      for (std::size_t k = 0; k < 3; ++k) e[k] = axis_error(side, zone, block, k, suspects);
      const double bound = d_.spec.error_bound, target = per_axis * bound;
      double overall = 0;
      if (std::max({e[0], e[1], e[2]}) <= 2 * target) {
        std::vector<std::array<double, 3>> places;
        for (std::size_t i = 0; i < check_samples; ++i) places.push_back(spread(i));
        for (const auto& p : suspects) places.push_back(p);
        Check c = errors_at(side, zone, block, places, "check");
        overall = c.worst;
        if (overall <= aim * bound) {
          d_.error_found = std::max(d_.error_found, overall);
          return;
        }
        suspects = c.places;
      }
      bool finer = false;
      const double largest = std::max({e[0], e[1], e[2]});
      for (std::size_t k = 0; k < 3; ++k) {
        if (block.n[k] == 1 || (e[k] <= target && !(overall > 0 && e[k] >= 0.5 * largest))) continue;
        block.n[k] = static_cast<int>(std::ceil(block.n[k] * std::clamp(std::pow(e[k] / target, 0.25), 1.15, 1.9)));
        finer = true;
      }
      const std::size_t size = static_cast<std::size_t>(block.n[0]) * block.n[1] * block.n[2];
      if (!finer || size > d_.spec.largest_grid)
        throw TableError("the error bound " + text(bound) + " needs a grid of more than " +
                         std::to_string(d_.spec.largest_grid) + " points where the wheel is " +
                         (side.braking ? "braking" : "driving") + "; allow a larger error or narrow the ranges");
    }
  }
};

WheelTable WheelTable::build(const TableSpec& spec, int threads, const std::function<void(const Progress&)>& progress) {
  const auto need = [](bool ok, const char* what) {
    if (!ok) throw std::invalid_argument(what);
  };
  const TableRange s = spec.slip, l = spec.load, z = spec.unloading_sinkage;
  need(s.lower >= -1 && s.upper <= 1 && s.lower <= s.upper, "slip: a range inside -1..1 is wanted");
  need(l.lower > 0 && l.upper >= l.lower && std::isfinite(l.upper), "load: a range above 0 is wanted");
  need(z.lower >= 0 && z.upper >= z.lower && std::isfinite(z.upper), "unloading sinkage: a range from 0 up is wanted");
  need(z.upper == 0 || spec.soil.ko > 0 || spec.soil.Au > 0, "unloading sinkage: the soil has no unloading slope");
  need(spec.error_bound >= 1e-5 && spec.error_bound <= 0.1, "error bound: 1e-5 to 0.1 is wanted");
  WheelTable t(std::make_unique<Data>());
  t.data_->spec = spec;
  t.data_->set_ranges();
  TableBuilder(t, threads, progress).run();
  return t;
}

}  // namespace grouser::bekker
