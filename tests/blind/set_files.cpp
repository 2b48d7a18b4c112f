#include "set_files.h"

#include <fmt/core.h>

namespace blind {

double slip_in_column(double slip, const ColumnStyle& style, double radius) {
  const double kappa = speed_ratio(slip) * radius / style.slip_radius;
  return style.rim ? 1.0 - kappa : slip_of_ratio(kappa);
}

std::string csv_text(const std::vector<PlannedRun>& runs, const std::vector<Eigen::Vector3d>& y,
                     const Eigen::Vector3d& stated_sd, const ColumnStyle& style, const Wheel& wheel) {
  std::string out =
      "slip,slip_definition,slip_radius_m,load_N,omega_rad_s,pass,order,batch,replicate,"
      "drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,torque_sd_Nm,sinkage_sd_m\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PlannedRun& p = runs[i];
    out += fmt::format("{:.9g},{},{:g},{:g},{:g},{},{},{},{},{:.7g},{:.7g},{:.7g},{:g},{:g},{:g}\n",
                       slip_in_column(p.run.slip, style, wheel.radius), style.rim ? "rim" : "larger", style.slip_radius,
                       p.run.load, p.run.omega, p.run.pass, p.order, p.batch, p.replicate, y[i][0], y[i][1], y[i][2],
                       stated_sd[0], stated_sd[1], stated_sd[2]);
  }
  return out;
}

std::string case_text(const Wheel& wheel, const Priors& priors) {
  const Soil& m = priors.centre;
  const SoilVector& sd = priors.sd;
  return fmt::format(
      "model: bekker.steady\n"
      "wheel: {{radius: {} m, width: {} m, mass: 3.2 kg}}\n"
      "soil:\n"
      "  pressure: {{law: k_ref, reference_width: 0.16 m, k: {{value: {:g} kPa, ln_sd: {:.2f}}}, n: {{value: {:g}, sd: "
      "{:g}}}}}\n"
      "  shear: {{type: A, c: {{value: {:g} Pa, sd: {:g} Pa}}, phi: {{value: {:g} rad, sd: {:g} rad}}, K: {{value: "
      "{:g} mm, ln_sd: {:.1f}}}}}\n"
      "  angles: {{a0: {{value: {:g}, sd: {:g}}}, a1: {{value: {:g}, sd: {:g}}}}}\n"
      "  density: {{value: {:g} kg/m^3}}\n"
      "effects: all\n",
      wheel.radius, wheel.width, m.k / 1e3, sd[0], m.n, sd[1], m.c, sd[2], m.phi, sd[3], m.K * 1e3, sd[4], m.a0, sd[5],
      m.a1, sd[6], wheel.density);
}

}  // namespace blind
