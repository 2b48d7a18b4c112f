// The MIT wheel on Mojave Martian Simulant, soil tests only: every Bekker variant next to the measured values, nothing tuned.
#include <cmath>

#include "grouser/terrain/csv.h"
#include "rig_case.h"
#include "store.h"

namespace {

using namespace family;

constexpr double slips[] = {-0.7, -0.5, -0.3, -0.1, 0.0, 0.1, 0.3, 0.5, 0.7};

struct Variant {
  const char *name, *model, *options;
};
constexpr Variant variants[] = {{"steady nonlinear", "bekker.steady", ""},
                                {"steady quadratic", "bekker.steady", "method: quadratic"},
                                {"steady linear", "bekker.steady", "method: linear"},
                                {"soil_node wong", "bekker.soil_node", "closure: wong"},
                                {"soil_node local", "bekker.soil_node", "closure: local"}};

void study(const Arguments& a) {
  Store store(a.results / "models.csv",
              {"MIT wheel, 115 N, 17 deg/s, Tables 4.1 and 4.6, slip (r w - v)/(r w); mean and standard deviation over "
               "the last 20 % of 0.7 m"},
              a.again);
  for (const Variant& v : variants)
    for (const double slip : slips) {
      RigInput in;
      in.model = v.model;
      in.options = v.options;
      in.slip = slip;
      store.rows({{"variant", v.name}, {"slip", text(slip)}}, hash_of(in), [&] {
        const auto r = run(in, a.work / "models").row;
        return std::vector<Cells>{{{"drawbar_N", text(r.drawbar_pull.mean)},
                                   {"drawbar_sd_N", text(r.drawbar_pull.sd, 3)},
                                   {"torque_Nm", text(r.driving_torque.mean)},
                                   {"torque_sd_Nm", text(r.driving_torque.sd, 3)},
                                   {"sinkage_mm", text(1e3 * r.sinkage_profile.mean)},
                                   {"sinkage_sd_mm", text(1e3 * r.sinkage_profile.sd, 3)},
                                   {"stationary", r.stationary ? "1" : "0"},
                                   {"wall_s_per_s", text(r.wall_s / r.simulated_s, 3)}}};
      });
    }
  store.finish();

  // Why closure local differs: what of the plastic depth springs back carries load behind the lowest point.
  Store rebound(a.results / "rebound.csv",
                {"closure local at slip 0.3 over its option unloading_rebound (default 0.02); Mojave has no measured "
                 "unloading slope"},
                a.again);
  for (const double share : {0.01, 0.03, 0.1, 0.3, 1.0}) {
    RigInput in;
    in.model = "bekker.soil_node";
    in.options = "closure: local, unloading_rebound: " + text(share);
    in.slip = 0.3;
    rebound.rows({{"unloading_rebound", text(share)}}, hash_of(in), [&] {
      const auto r = run(in, a.work / "models").row;
      return std::vector<Cells>{{{"drawbar_N", text(r.drawbar_pull.mean, 4)},
                                 {"torque_Nm", text(r.driving_torque.mean, 4)},
                                 {"sinkage_mm", text(1e3 * r.sinkage_profile.mean, 4)}}};
    });
  }
  rebound.finish();
}

}  // namespace

int main(int argc, char** argv) { return family::main_of(argc, argv, study); }
