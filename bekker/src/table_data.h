#pragma once
// Inside of a WheelTable: two sides (braking, driving) of two blocks each, and the map between what is asked and the
// blocks' axes.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "grouser/bekker/table.h"
#include "lanes.h"
#include "table_spline.h"

namespace grouser::bekker {

/// theta_f, thrust, resistance, torque: one grid point's values, and the channels of a block.
using TableValues = std::array<double, 4>;

/// Uniform grid over the unit cube; the spline holds theta_f [rad], thrust/load, resistance/load, torque/(load r_s).
struct TableBlock {
  std::array<int, 3> n{0, 0, 0};    ///< points per axis: slip, load, unloading sinkage; 0 = not there
  std::vector<TableValues> values;  ///< [n0][n1][n2] in SI
  std::vector<float> spline;
  bool present() const { return n[0] > 0; }

  struct View {
    const float* c = nullptr;  ///< of `spline`
    std::size_t row = 0, plane = 0;
    SplineAxis a, b, d;
  } view;
};

/// Place of a grid point in the unit cube.
inline std::array<double, 3> grid_place(const std::array<int, 3>& n, double i, double j, double k) {
  const auto of = [](int count, double x) { return count > 1 ? x / (count - 1) : 0; };
  return {of(n[0], i), of(n[1], j), of(n[2], k)};
}

/// Function over the unit square.
struct TableSheet {
  std::array<int, 2> n{0, 0};
  std::vector<double> values;
  std::vector<float> spline;

  struct View {
    const float* c = nullptr;
    std::size_t row = 0;
    SplineAxis a, b;
  } view;

  [[gnu::always_inline]] double at(const SplineWeights& a, const SplineWeights& b) const {
    return static_cast<double>(spline_sum(view.c + a.first * view.row + b.first, view.row, a.w, b.w));
  }
  [[gnu::always_inline]] double at(double u, double v) const {
    return at(SplineWeights(u, view.a), SplineWeights(v, view.b));
  }
  void make_spline();
};

/// (x - first) * scale is the place of x between two ends as 0..1; 0 where they are the same.
struct TableScale {
  double first = 0, scale = 0;
  TableScale() = default;
  TableScale(double a, double b) : first(a), scale(b > a ? 1 / (b - a) : 0) {}
  [[gnu::always_inline]] double operator()(double x) const { return (x - first) * scale; }
};

/// Loads above the edge (the wheel goes deeper than the earlier pass) or below it (it stays in the rut).
struct TableZone {
  double zu_first = 0, zu_last = 0;  ///< [m] axis 2
  double first = 0;  ///< in the rut: log of load over edge load where axis 1 begins, < 0; 0: no such zone
  TableSheet
      turn;  ///< braking: theta_f without slip over axes 1 and 2; the shear turns over at slips that go with its square
  TableBlock near;  ///< braking only: root of -slip from 0 to turn_share times turn
  TableBlock far;   ///< beyond; driving: all
  TableScale zu_scale;
  double load_scale = 0;  ///< in the rut: -1/first
};
inline constexpr double turn_share = 0.6;

struct TableSide {
  bool present = false, braking = false;
  double first = 0, last = 0;            ///< slip, or the root of -slip
  double edge_first = 0, edge_last = 0;  ///< of `edge`; braking: from 0 to at least the end of the near blocks
  TableSheet edge;  ///< log of the edge load over slip and unloading sinkage; absent in a table of virgin soil
  TableSheet span;  ///< 1/(log of the load at the end of `deeper` - edge), made from the edge
  TableZone deeper, in_rut;
  TableScale slip_scale, edge_scale;
};

/// Slip of the root t of -slip. theta_m by eq 2.13 jumps at slip 0: the braking side ends in the limit from below.
inline double braking_slip(const TableSpec& s, double t) {
  constexpr double just_below = -1e-300;
  return s.soil.theta_m_law == ThetaMLaw::wong_braking ? std::min(-t * t, just_below) : -t * t;
}

/// A place in the unit cube of a block.
struct TablePlace {
  const TableBlock* block;
  double u, v, w;
};

struct WheelTable::Data {
  TableSpec spec;
  double radius = 0;                     ///< r_s [m]
  double load_first = 0, load_last = 0;  ///< log of the range
  std::array<TableSide, 2> sides;        ///< driving, braking
  const TableSide* driving = &sides[0];
  const TableSide* braking = &sides[1];
  TableScale zu_scale;    ///< of the edges
  double load_scale = 0;  ///< of virgin soil
  double error_found = 0;
  std::string version;

  [[gnu::always_inline]] bool virgin() const { return spec.unloading_sinkage.upper <= 0; }
  [[gnu::always_inline]] const TableSide& side(double slip) const {
    return (slip >= 0 && driving->present) || !braking->present ? *driving : *braking;
  }
  struct Edge {
    double from, span;  ///< log of the edge load; 1/(log of the load at the end of `deeper` - from)
  };
  /// t: slip or the root of -slip. Virgin soil: the range of loads.
  [[gnu::always_inline]] Edge edge(const TableSide& s, double t, double zu) const {
    if (virgin()) return {load_first, load_scale};
    const SplineWeights a(s.edge_scale(t), s.edge.view.a), b(zu_scale(zu), s.edge.view.b);
    return {s.edge.at(a, b), s.span.at(a, b)};
  }
  /// a + max(b - a, 0) made smooth over `width`: never less than b, nor than a.
  [[gnu::always_inline]] static double beyond(double a, double b, double width) {
    const double x = b - a;
    return a + 0.5 * (x + __builtin_sqrt(x * x + width * width));
  }
  /// Where a slip, load and unloading sinkage inside the ranges lie.
  [[gnu::always_inline]] TablePlace find(double slip, double load, double zu) const {
    const TableSide& s = side(slip);
    const double t = s.braking ? __builtin_sqrt(slip < 0 ? -slip : 0.0) : slip, log_load = log_of(splat(load))[0];
    const Edge e = edge(s, t, zu);
    const double beyond_edge = log_load - e.from;
    const bool rut = beyond_edge < 0 && s.in_rut.first < 0;
    const TableZone& z = rut ? s.in_rut : s.deeper;
    const double v = rut ? 1 + beyond_edge * z.load_scale : beyond_edge * e.span;
    const double w = z.zu_scale(zu);
    if (!s.braking) return {&z.far, s.slip_scale(t), v, w};
    const double turn = turn_share * z.turn.at(v, w);
    if (t < turn && z.near.view.c) return {&z.near, t / turn, v, w};
    return {&z.far, (t - turn) / (beyond(turn, s.last, 0.05) - turn), v, w};
  }
  /// The reverse: slip, load and unloading sinkage at a place of a block of this zone.
  std::array<double, 3> at(const TableSide& side, const TableZone& zone, bool near,
                           const std::array<double, 3>& p) const;
  /// Channels of a block.
  [[gnu::always_inline]] static Four interpolate(const TablePlace& p) {
    const TableBlock::View& x = p.block->view;
    const SplineWeights a(p.u, x.a), b(p.v, x.b), d(p.w, x.d);
    return spline_sum(x.c + a.first * x.plane + b.first * x.row + 4 * d.first, x.plane, x.row, a.w, b.w, d.w);
  }

  void set_ranges();
  /// After the edge and the ends of the zones are known: what find() needs of them.
  void make_edge_splines(TableSide& side) const;
  void make_spline(const TableSide& side, const TableZone& zone, TableBlock& block) const;
  std::uint64_t hash() const;
};

/// What the table holds, computed by solve() and forces(). The status is solve()'s.
ForceStatus table_values(const TableSpec& spec, double slip, double load, double zu, TableValues& out);
double sinkage_of(double radius, double theta_f);

}  // namespace grouser::bekker
