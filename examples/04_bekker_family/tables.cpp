// Figs 2.8 to 2.11: entry angle, thrust, resistance and unloading sinkage from a lookup table, and the table's error at points off its
// grid against the equilibrium solver. `family_tables RESULTS WORK [--again]`
#include <algorithm>
#include <cmath>
#include <random>

#include "grouser/bekker/table.h"
#include "rig_case.h"
#include "store.h"

namespace {

using namespace family;
using namespace grouser::bekker;

constexpr double degree = 3.14159265358979323846 / 180;

void curves(const WheelTable& table, const std::filesystem::path& folder) {
  std::vector<Cells> rows;
  const auto add = [&](const char* curve, double load, double zu) {
    for (int i = 0; i <= 90; ++i) {
      const double slip = 0.01 * i;
      TablePoint p;
      if (table.query(slip, load, zu, p) != TableStatus::ok)
        throw std::runtime_error("a point of the figure is outside the table");
      rows.push_back({{"curve", curve},
                      {"load_N", text(load)},
                      {"earlier_unloading_sinkage_mm", text(1e3 * zu)},
                      {"slip", text(slip)},
                      {"theta_f_deg", text(p.entry_angle / degree)},
                      {"thrust_N", text(p.thrust)},
                      {"resistance_N", text(p.resistance)},
                      {"drawbar_N", text(p.drawbar())},
                      {"torque_Nm", text(p.torque)},
                      {"sinkage_mm", text(1e3 * p.sinkage)},
                      {"unloading_sinkage_mm", text(1e3 * p.unloading_sinkage)}});
    }
  };
  for (const double load : {20.0, 50.0, 100.0, 150.0, 200.0}) add("load", load, 0);
  for (const double zu : {0.0, 10e-3, 20e-3, 25e-3, 30e-3, 40e-3}) add("unloading", 100, zu);
  write_csv(folder / "tables.csv",
            {"smooth wheel r = b = 0.1 m on loose air-dried sand (Table 2.1); curve load: virgin soil; curve "
             "unloading: 100 N",
             "table hash " + table.hash_text()},
            rows);
}

void errors(const WheelTable& table, const std::filesystem::path& folder) {
  const TableSpec& s = table.spec();
  std::mt19937_64 random(1);
  const auto in = [&](const TableRange& r) {
    return r.lower + (r.upper - r.lower) * std::generate_canonical<double, 53>(random);
  };
  constexpr int points = 10000;
  std::vector<double> e[5];
  for (int i = 0; i < points; ++i) {
    LoadCase c;
    c.wheel = s.wheel;
    c.soil = s.soil;
    c.slip = in(s.slip);
    c.load = in(s.load);
    c.unloading_sinkage = in(s.unloading_sinkage);
    const Solution q = solve(c, Method::nonlinear, 1e-9);
    TablePoint p;
    if (q.status != ForceStatus::ok || table.query(c.slip, c.load, c.unloading_sinkage, p) != TableStatus::ok)
      throw std::runtime_error("a random point has no solution or is outside the table");
    e[0].push_back(std::abs(p.entry_angle / q.arc.theta_f - 1));
    e[1].push_back(std::abs(p.drawbar() - q.wrench.Fx) / c.load);
    e[2].push_back(std::abs(p.torque + q.wrench.My) / (c.load * s.wheel.outer_radius()));
    e[3].push_back(std::abs(p.sinkage / q.sinkage - 1));
    e[4].push_back(std::abs(p.unloading_sinkage / q.unloading_sinkage - 1));
  }
  std::vector<Cells> rows;
  const char* names[] = {"entry angle", "drawbar pull over load", "torque over load times radius", "sinkage",
                         "unloading sinkage left"};
  for (int k = 0; k < 5; ++k) {
    std::sort(e[k].begin(), e[k].end());
    rows.push_back({{"quantity", names[k]},
                    {"median", text(e[k][points / 2], 3)},
                    {"99_percent", text(e[k][points * 99 / 100], 3)},
                    {"largest", text(e[k].back(), 3)},
                    {"bound", text(s.error_bound, 3)},
                    {"inside", e[k].back() <= s.error_bound ? "yes" : "no"}});
  }
  write_csv(folder / "table_errors.csv",
            {"10,000 random points inside the ranges of table.yaml against solve() at 1e-9, mt19937_64 seed 1"}, rows);
}

void study(const Arguments& a) {
  const WheelTable table = WheelTable::build(load_table_spec("examples/04_bekker_family/table.yaml"));
  std::filesystem::create_directories(a.work);
  table.write(a.work / "table.h5", "1");
  curves(table, a.results);
  errors(table, a.results);
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
