// Errors of the linear and quadratic closed forms against the integral, Figs 2.13, 2.15 and 2.16:
// `family_closed_form_errors FOLDER`. Uses grouser/bekker/forces.h alone, as a controller would: fill a ForceCase,
// call forces(), read six components.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "grouser/bekker/forces.h"

namespace {

using namespace grouser::bekker;

constexpr double kDegree = 3.14159265358979323846 / 180;

struct NamedSoil {
  const char* name;
  double c, phi, n, K, kc, kphi;  ///< Table 2.2 [Pa, rad, -, m, N/m^(n+1), N/m^(n+2)]
};
constexpr NamedSoil kSoils[] = {{"dry sand", 1000, 0.52, 1.1, 0.025, 900, 1523400},
                                {"sandy loam", 1700, 0.51, 0.7, 0.025, 5300, 1515000},
                                {"clayey soil", 4140, 0.23, 0.5, 0.01, 13200, 692200}};
struct NamedWheel {
  const char* name;
  WheelSize size;  ///< Table 2.3
};
const NamedWheel kWheels[] = {{"S", {0.08, 0.075, 0, 0}}, {"L", {0.08, 0.075, 0.005, 0.1}}};

/// theta_m = theta_f/2, theta_r = 0 (Table 2.4).
ForceCase force_case(const NamedSoil& soil, const WheelSize& wheel, double theta_f) {
  ForceCase c;
  c.wheel = wheel;
  c.soil.modulus = soil.kc / wheel.width + soil.kphi;
  c.soil.n = soil.n;
  c.soil.shear = {grouser::ShearLaw::Type::A, soil.c, soil.phi, soil.K, 0, 1};
  c.soil.tan_phi = std::tan(soil.phi);
  c.arc = {theta_f, 0.5 * theta_f, 0};
  return c;
}

/// The four errors of Fig 2.15: of Fx/Fz and Fy/Fz in percentage points, of Fz and My in %.
using Errors = std::array<double, 4>;
Errors errors(const ForceCase& c, Method method) {
  const WheelWrench t = forces(c, Method::nonlinear, 1e-10).wrench, a = forces(c, method).wrench;
  return {100 * std::abs(a.Fx / a.Fz - t.Fx / t.Fz), 100 * std::abs(a.Fy / a.Fz - t.Fy / t.Fz),
          100 * std::abs(a.Fz / t.Fz - 1), 100 * std::abs(a.My / t.My - 1)};
}

struct Spread {
  Errors mean{}, sd{};
};
/// Over slip 0.1..0.8 and slip angle 0..36 degrees.
template <class Each>
Spread over_grid(ForceCase c, Method method, const Each& each) {
  std::vector<Errors> all;
  for (int i = 1; i <= 8; ++i)
    for (int k = 0; k <= 9; ++k) {
      c.slip = 0.1 * i;
      c.slip_angle = 4 * k * kDegree;
      all.push_back(errors(c, method));
      each(c, all.back());
    }
  Spread s;
  const double n = static_cast<double>(all.size());
  for (int q = 0; q < 4; ++q) {
    for (const Errors& e : all) s.mean[q] += e[q] / n;
    for (const Errors& e : all) s.sd[q] += (e[q] - s.mean[q]) * (e[q] - s.mean[q]) / n;
    s.sd[q] = std::sqrt(s.sd[q]);
  }
  return s;
}

class Csv {
 public:
  Csv(const std::filesystem::path& file, const char* note, const char* header) : out_(std::fopen(file.c_str(), "w")) {
    if (!out_) throw std::runtime_error("cannot write " + file.string());
    std::fprintf(out_, "# %s\n%s\n", note, header);
  }
  Csv(const Csv&) = delete;
  Csv& operator=(const Csv&) = delete;
  ~Csv() { std::fclose(out_); }
  FILE* out() const { return out_; }

 private:
  FILE* out_;
};

const char* name_of(Method m) { return m == Method::linear ? "linear" : "quadratic"; }

void figure_2_15(const std::filesystem::path& folder) {
  const Csv csv(
      folder / "fig_2_15.csv",
      "Errors of the closed forms against the integral: wheel S, sandy loam, theta_f 30 deg, theta_m 15 deg, theta_r 0",
      "method,slip,slip_angle_deg,error_Tx_pp,error_Ty_pp,error_Fz_percent,error_My_percent");
  std::printf("Fig 2.15: mean +- sd     Tx [pp]          Ty [pp]          Fz [%%]           My [%%]\n");
  for (const Method m : {Method::linear, Method::quadratic}) {
    const Spread s =
        over_grid(force_case(kSoils[1], kWheels[0].size, 30 * kDegree), m, [&](const ForceCase& c, const Errors& e) {
          std::fprintf(csv.out(), "%s,%.1f,%.0f,%.5f,%.5f,%.5f,%.5f\n", name_of(m), c.slip, c.slip_angle / kDegree,
                       e[0], e[1], e[2], e[3]);
        });
    std::printf("  %-18s", name_of(m));
    for (int q = 0; q < 4; ++q) std::printf(" %7.3f +- %5.3f", s.mean[q], s.sd[q]);
    std::printf("\n");
  }
}

void figure_2_16(const std::filesystem::path& folder) {
  const Csv csv(folder / "fig_2_16.csv",
                "Mean and standard deviation of the errors over slip 0.1..0.8 and slip angle 0..36 deg; theta_m = "
                "theta_f/2, theta_r = 0",
                "soil,wheel,method,theta_f_deg,error_Tx_pp,error_Tx_sd_pp,error_Ty_pp,error_Ty_sd_pp,error_Fz_percent,"
                "error_Fz_sd_percent,"
                "error_My_percent,error_My_sd_percent");
  for (const NamedSoil& soil : kSoils)
    for (const NamedWheel& wheel : kWheels)
      for (const Method m : {Method::linear, Method::quadratic})
        for (double theta_f = 20; theta_f < 50.5; theta_f += 2.5) {
          const Spread s =
              over_grid(force_case(soil, wheel.size, theta_f * kDegree), m, [](const ForceCase&, const Errors&) {});
          std::fprintf(csv.out(), "%s,%s,%s,%.1f", soil.name, wheel.name, name_of(m), theta_f);
          for (int q = 0; q < 4; ++q) std::fprintf(csv.out(), ",%.5f,%.5f", s.mean[q], s.sd[q]);
          std::fprintf(csv.out(), "\n");
        }
}

/// Wheel L on sandy loam at slip 0.3 and slip angle 10 degrees: the stresses and what eqs 2.17 and 2.20 make of them.
void figure_2_13(const std::filesystem::path& folder) {
  const ForceCase c = force_case(kSoils[1], kWheels[1].size, 40 * kDegree);
  const ContactRange range{c.arc.theta_f, c.arc.theta_m, c.arc.theta_r};
  const ShearState e = shear_state(kappa_of_slip(0.3), 10 * kDegree);
  using Three = std::array<double, 3>;
  const auto at = [&](double theta) {
    const Stress s = stress_at(c.wheel, c.soil, range, e, theta);
    return Three{s.sigma, s.tau_t, s.tau_l};
  };
  // The front branch is cut where the concave tread enters (eq 2.14).
  const double concave = std::acos(c.wheel.outer_radius() * std::cos(range.theta_f) / c.wheel.radius);
  const double cuts[] = {range.theta_r, range.theta_m, concave, range.theta_f};
  const Csv csv(
      folder / "fig_2_13.csv",
      "Stresses on wheel L, sandy loam, theta_f 40 deg (lug tips), theta_m 20 deg, theta_r 0, slip 0.3, slip angle 10 "
      "deg",
      "theta_deg,sigma_nonlinear_kPa,sigma_linear_kPa,sigma_quadratic_kPa,tau_t_nonlinear_kPa,tau_t_linear_kPa,"
      "tau_t_quadratic_kPa,tau_l_nonlinear_kPa,tau_l_linear_kPa,tau_l_quadratic_kPa");
  for (int piece = 0; piece < 3; ++piece) {
    const double a = cuts[piece], b = cuts[piece + 1];
    const Three pa = at(a), pm = at(0.5 * (a + b)), pb = at(b);
    for (int i = 0; i <= 40; ++i) {
      const double x = i / 40.0, theta = a + (b - a) * x;
      const Three p = at(theta);
      std::fprintf(csv.out(), "%.4f", theta / kDegree);
      for (int q = 0; q < 3; ++q) {
        const double line = piece == 0 ? pa[q] + pb[q] * x : pa[q] + (pb[q] - pa[q]) * x;
        const double parabola = pa[q] * (1 - x) * (1 - 2 * x) + 4 * pm[q] * x * (1 - x) + pb[q] * x * (2 * x - 1);
        std::fprintf(csv.out(), ",%.6f,%.6f,%.6f", 1e-3 * p[q], 1e-3 * line, 1e-3 * parabola);
      }
      std::fprintf(csv.out(), "\n");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  try {
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder);
    figure_2_13(folder);
    figure_2_15(folder);
    figure_2_16(folder);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
