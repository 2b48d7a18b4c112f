// Sections 4.3.2.2, Figs 4.9 and 4.10: bekker.soil_node against the steady wheel on flat ground over node spacing and time step.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "grouser/bekker/wheel_forces.h"
#include "grouser/terrain/loaders.h"
#include "rig_case.h"
#include "store.h"

namespace {

using namespace family;

constexpr double slips[] = {-0.7, -0.5, -0.3, -0.1, 0.0, 0.1, 0.3, 0.5, 0.7};  // Table 4.5
constexpr double few[] = {-0.3, 0.0, 0.3};                                     // of the time steps, which cost most
constexpr double moderate[] = {-0.7, -0.5, -0.3, -0.1, 0.0, 0.1};              // of the finest spacing
constexpr double spacings[] = {10, 6.6, 3.3, 1.65};                            // [mm]
constexpr double steps[] = {2, 1, 0.5, 0.25};                                  // [ms]
constexpr double load = 115, radius = 0.13, width = 0.16;

struct Steady {
  double sinkage, drawbar, torque;  // [mm, N, N m]
};

/// The steady law itself, by its own equilibrium solver: no time, no nodes.
Steady steady(double rim_slip) {
  using namespace grouser;
  const Soil soil = load_soil_file("examples/soils/mojave_martian_simulant.yaml");
  const bekker::WheelSize wheel{.radius = radius, .width = width};
  const auto law = bekker::SoilLaw::of(*soil.bekker, width);
  const auto e = bekker::shear_state(1 - rim_slip);
  const auto q = bekker::steady_equilibrium(wheel, law, load, e, {.points = 40});
  return {1e3 * q.sinkage, q.forces.Fx, -q.forces.My};
}

struct Grid {
  double spacing, step;
  std::span<const double> slips;
};

std::vector<Grid> grids() {
  std::vector<Grid> out;
  for (const double s : spacings) out.push_back({s, 1, s < 2 ? std::span<const double>(moderate) : slips});
  for (const double t : steps)
    if (t != 1) out.push_back({3.3, t, few});
  return out;
}

void study(const Arguments& a) {
  Store store(a.results / "convergence.csv",
              {"MIT wheel (r 0.13 m, b 0.16 m), 115 N, 17 deg/s, Tables 4.1 and 4.6; slip (r w - v)/(r w)",
               "mean over the last 20 % of 0.7 m; sinkage below the undisturbed ground (eq 3.7); errors against the "
               "steady law's own equilibrium, of its value",
               "cost: wall time of one core of a shared machine, the smallest column to trust"},
              a.again);
  std::map<std::string, std::vector<std::vector<Cells>>> by_closure;  // [grid][slip]
  for (const std::string closure : {"local", "wong"}) {
    for (const Grid& g : grids()) {
      auto& rows = by_closure[closure].emplace_back();
      for (const double slip : g.slips) {
        RigInput in;
        in.model = "bekker.soil_node";
        in.options = "closure: " + closure + ", spacing: " + text(g.spacing) + " mm";
        in.slip = slip;
        in.time_step = text(g.step) + " ms";
        const Cells key{
            {"closure", closure}, {"spacing_mm", text(g.spacing)}, {"step_ms", text(g.step)}, {"slip", text(slip)}};
        rows.push_back(
            store
                .rows(key, hash_of(in),
                      [&] {
                        const auto r = run(in, a.work / "convergence").row;
                        const Steady s = steady(slip);
                        const auto percent = [](double x, double ref) {
                          return text(100 * (x - ref) / std::abs(ref), 4);
                        };
                        const double z = 1e3 * r.sinkage_profile.mean, F = r.drawbar_pull.mean,
                                     T = r.driving_torque.mean;
                        return std::vector<Cells>{
                            {{"sinkage_mm", text(z)},
                             {"sinkage_sd_mm", text(1e3 * r.sinkage_profile.sd, 3)},
                             {"drawbar_N", text(F)},
                             {"drawbar_sd_N", text(r.drawbar_pull.sd, 3)},
                             {"torque_Nm", text(T)},
                             {"torque_sd_Nm", text(r.driving_torque.sd, 3)},
                             {"steady_sinkage_mm", text(s.sinkage)},
                             {"steady_drawbar_N", text(s.drawbar)},
                             {"steady_torque_Nm", text(s.torque)},
                             {"sinkage_error_pct", percent(z, s.sinkage)},
                             {"drawbar_error_pct", percent(F, s.drawbar)},
                             {"torque_error_pct", percent(T, s.torque)},
                             {"stationary", r.stationary ? "1" : "0"},
                             {"wall_s_per_s", text(r.wall_s / r.simulated_s, 3)},
                             {"terrain_us_per_step", text(1e6 * r.terrain_s / (r.simulated_s / (1e-3 * g.step)), 3)}}};
                      })
                .at(0));
      }
    }
  }
  store.finish();

  // Over the slips of a grid: largest error, and the observed order from three grids with a ratio of about two.
  std::vector<Cells> out;
  for (const auto& [closure, grid_rows] : by_closure) {
    for (std::size_t g = 0; g < grid_rows.size(); ++g) {
      Cells row{{"closure", closure},
                {"spacing_mm", cell(grid_rows[g][0], "spacing_mm")},
                {"step_ms", cell(grid_rows[g][0], "step_ms")}};
      double cost = 1e300, us = 1e300;
      for (const Cells& r : grid_rows[g]) {
        cost = std::min(cost, number(r, "wall_s_per_s"));
        us = std::min(us, number(r, "terrain_us_per_step"));
      }
      for (const char* what : {"sinkage", "drawbar", "torque"}) {
        double worst = 0, sum = 0;
        for (const Cells& r : grid_rows[g]) {
          const double e = std::abs(number(r, std::string(what) + "_error_pct"));
          worst = std::max(worst, e);
          sum += e / static_cast<double>(grid_rows[g].size());
        }
        row.emplace_back(std::string(what) + "_largest_error_pct", text(worst, 3));
        row.emplace_back(std::string(what) + "_mean_error_pct", text(sum, 3));
      }
      // Change to the finest grid of the same study, in the norm over the slips.
      row.emplace_back("wall_s_per_s", text(cost, 3));
      row.emplace_back("terrain_us_per_step", text(us, 3));
      out.push_back(std::move(row));
    }
  }
  write_csv(
      a.results / "convergence_summary.csv",
      {"over nine slips; -0.7 to 0.1 at 1.65 mm; -0.3, 0, 0.3 at time steps other than 1 ms; cost: smallest of them"},
      out);

  std::vector<Cells> orders;
  for (const auto& [closure, rows] : by_closure) {
    // grids(): spacings 10, 6.6, 3.3, 1.65 at 1 ms, then steps 2, 0.5, 0.25 at 3.3 mm.
    const std::pair<const char*, std::array<std::size_t, 3>> triples[] = {{"node spacing 6.6, 3.3, 1.65 mm", {1, 2, 3}},
                                                                          {"time step 2, 1, 0.5 ms", {4, 2, 5}},
                                                                          {"time step 1, 0.5, 0.25 ms", {2, 5, 6}}};
    for (const auto& [name, g] : triples) {
      Cells row{{"closure", closure}, {"refined", name}};
      for (const char* column : {"sinkage_mm", "drawbar_N", "torque_Nm"}) {
        // The slips that all three grids have.
        double coarse = 0, fine = 0, n = 0;
        const auto at = [&](std::size_t grid, const std::string& slip) {
          for (const Cells& r : rows[grid])
            if (cell(r, "slip") == slip) return number(r, column);
          return std::numeric_limits<double>::quiet_NaN();
        };
        for (const Cells& r : rows[g[2]]) {
          const std::string& slip = cell(r, "slip");
          coarse += std::pow(at(g[0], slip) - at(g[1], slip), 2);
          fine += std::pow(at(g[1], slip) - at(g[2], slip), 2);
          ++n;
        }
        row.emplace_back(std::string(column) + "_rms_change", text(std::sqrt(fine / n), 3));
        row.emplace_back(std::string(column) + "_order", text(0.5 * std::log2(coarse / fine), 3));
      }
      orders.push_back(std::move(row));
    }
  }
  write_csv(
      a.results / "convergence_order.csv",
      {"rms over the slips (-0.7 to 0.1 for the spacing, -0.3, 0 and 0.3 for the time step) of the change by the last "
       "halving, and the observed order log2 of the ratio of "
       "the last two changes"},
      orders);
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
