#include "impact_reference.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_nonlinearsolver.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <cmath>
#include <stdexcept>

namespace {

// y: x (3) of 1 against 0, v0 (3), v1 (3), w0 (3), w1 (3), s (3)
constexpr int kSize = 18;

struct Law {
  Impact c;
  double m[2], I[2], reff, meff, E, G, beta;
  explicit Law(const Impact& i) : c(i) {
    for (int k = 0; k < 2; ++k) {
      m[k] = 4.0 / 3 * M_PI * std::pow(c.r[k], 3) * c.density;
      I[k] = 2.0 / 5 * m[k] * c.r[k] * c.r[k];
    }
    reff = c.r[0] * c.r[1] / (c.r[0] + c.r[1]);
    meff = c.fixed_target ? m[0] : m[0] * m[1] / (m[0] + m[1]);
    E = c.young / (2 * (1 - c.poisson * c.poisson));
    G = c.young / (4 * (2 - c.poisson) * (1 + c.poisson));
    const double l = std::log(c.restitution);
    beta = l / std::sqrt(l * l + M_PI * M_PI);
  }
  double gap(const double* y) const { return std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]) - c.r[0] - c.r[1]; }
  void rates(const double* y, double* d) const {
    const double length = std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
    double n[3], rel[3], vn = 0;
    for (int k = 0; k < 3; ++k) {
      n[k] = y[k] / length;
      rel[k] = y[6 + k] - y[3 + k];  // v1 - v0
      d[k] = rel[k];
      vn += rel[k] * n[k];
    }
    const double overlap = std::fmax(c.r[0] + c.r[1] - length, 0.0), a = std::sqrt(reff * overlap);
    const double kn = 4.0 / 3 * E * a, kt = 8 * G * a;
    const double gn = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(1.5 * kn * meff);
    const double gt = -2 * std::sqrt(5.0 / 6) * beta * std::sqrt(kt * meff);
    // Surface velocity of 0 against 1 at the contact, arms to the middle of the overlap.
    const double c0 = c.r[0] - overlap / 2, c1 = c.r[1] - overlap / 2;
    const double W[3] = {c0 * y[9] + c1 * y[12], c0 * y[10] + c1 * y[13], c0 * y[11] + c1 * y[14]};
    const double u[3] = {-rel[0] + vn * n[0] + W[1] * n[2] - W[2] * n[1],
                         -rel[1] + vn * n[1] + W[2] * n[0] - W[0] * n[2],
                         -rel[2] + vn * n[2] + W[0] * n[1] - W[1] * n[0]};
    double turn[3], sn = 0;  // dn/dt
    for (int k = 0; k < 3; ++k) {
      turn[k] = (rel[k] - vn * n[k]) / length;
      sn += turn[k] * y[15 + k];
    }
    const double fn = kn * overlap - gn * vn;
    double f[3], ft[3];
    for (int k = 0; k < 3; ++k) {
      ft[k] = c.tangential ? -(kt * y[15 + k] + gt * u[k]) : 0;
      f[k] = -fn * n[k] + ft[k];
      d[15 + k] = c.tangential ? u[k] - sn * n[k] : 0;
      d[3 + k] = f[k] / m[0];
      d[6 + k] = c.fixed_target ? 0 : -f[k] / m[1];
    }
    const double t[3] = {n[1] * ft[2] - n[2] * ft[1], n[2] * ft[0] - n[0] * ft[2], n[0] * ft[1] - n[1] * ft[0]};
    for (int k = 0; k < 3; ++k) {
      d[9 + k] = c0 * t[k] / I[0];
      d[12 + k] = c.fixed_target ? 0 : c1 * t[k] / I[1];
    }
  }
};

int rates(double, N_Vector y, N_Vector d, void* law) {
  static_cast<Law*>(law)->rates(N_VGetArrayPointer(y), N_VGetArrayPointer(d));
  return 0;
}
int gap(double, N_Vector y, double* g, void* law) {
  *g = static_cast<Law*>(law)->gap(N_VGetArrayPointer(y));
  return 0;
}
void require(int flag) {
  if (flag < 0) throw std::runtime_error("CVODE failed: " + std::to_string(flag));
}

}  // namespace

Outcome solve_impact(const Impact& c, double rtol) {
  Law law(c);
  SUNContext context;
  require(SUNContext_Create(nullptr, &context));
  N_Vector y = N_VNew_Serial(kSize, context);
  double* p = N_VGetArrayPointer(y);
  for (int k = 0; k < kSize; ++k) p[k] = 0;
  // Just in touch: the first overlap is far below anything that matters.
  const double start = (law.c.r[0] + law.c.r[1]) * (1 - 1e-15);
  for (int k = 0; k < 3; ++k) {
    p[k] = start * c.axis[static_cast<std::size_t>(k)];
    for (int i = 0; i < 2; ++i) {
      p[3 + 3 * i + k] = c.v[i][static_cast<std::size_t>(k)];
      p[9 + 3 * i + k] = c.w[i][static_cast<std::size_t>(k)];
    }
  }
  void* solver = CVodeCreate(CV_ADAMS, context);
  require(CVodeInit(solver, rates, 0, y));
  require(CVodeSStolerances(solver, rtol, 1e-18));
  require(CVodeSetUserData(solver, &law));
  require(CVodeSetMaxNumSteps(solver, 10000000));
  SUNNonlinearSolver fixed = SUNNonlinSol_FixedPoint(y, 0, context);
  require(CVodeSetNonlinearSolver(solver, fixed));
  require(CVodeSetMaxStep(solver, 1e-6));
  require(CVodeRootInit(solver, 1, gap));
  const int out[1] = {1};
  require(CVodeSetRootDirection(solver, const_cast<int*>(out)));
  double t = 0;
  const int flag = CVode(solver, 1, y, &t, CV_NORMAL);
  require(flag);
  if (flag != CV_ROOT_RETURN) throw std::runtime_error("the spheres did not part");
  Outcome o{};
  o.time = t;
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 3; ++k) {
      o.v[i][static_cast<std::size_t>(k)] = p[3 + 3 * i + k];
      o.w[i][static_cast<std::size_t>(k)] = p[9 + 3 * i + k];
    }
  SUNNonlinSolFree(fixed);
  CVodeFree(&solver);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return o;
}
