// solve_equilibrium: KINSOL behind a C++ face.
#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>

#include "grouser/vehicle/trim.h"

namespace grouser::vehicle {

namespace {

/// One solve. Unknowns and residuals are scaled to order one before KINSOL sees them.
struct Problem {
  const Residual& r;
  const EquilibriumOptions& o;
  std::size_t n;
  std::vector<double> x, f;
  std::string message;
  std::exception_ptr thrown;

  void evaluate(const double* u, double* out) {
    for (std::size_t i = 0; i < n; ++i) x[i] = u[i] * o.x_scale[i];
    r(x, f);
    for (std::size_t i = 0; i < n; ++i) out[i] = f[i] / o.r_scale[i];
  }
  static int call(N_Vector u, N_Vector out, void* self) {
    auto& me = *static_cast<Problem*>(self);
    try {
      me.evaluate(N_VGetArrayPointer(u), N_VGetArrayPointer(out));
      return 0;
    } catch (...) {
      me.thrown = std::current_exception();
      return -1;
    }
  }
  // Central differences over 1e-4 of the scale: KINSOL's own step (1.5e-8) drowns in the rounding of large coordinates.
  static int jacobian(N_Vector u, N_Vector, SUNMatrix J, void* self, N_Vector up, N_Vector low) {
    auto& me = *static_cast<Problem*>(self);
    const double h = 1e-4;
    double* v = N_VGetArrayPointer(u);
    try {
      for (std::size_t j = 0; j < me.n; ++j) {
        const double keep = v[j];
        v[j] = keep + h;
        me.evaluate(v, N_VGetArrayPointer(up));
        v[j] = keep - h;
        me.evaluate(v, N_VGetArrayPointer(low));
        v[j] = keep;
        for (std::size_t i = 0; i < me.n; ++i)
          SM_ELEMENT_D(J, i, j) = (N_VGetArrayPointer(up)[i] - N_VGetArrayPointer(low)[i]) / (2 * h);
      }
      return 0;
    } catch (...) {
      me.thrown = std::current_exception();
      return -1;
    }
  }
  static void on_error(int, const char*, const char*, char* text, void* self) {
    static_cast<Problem*>(self)->message = text;
  }
  static void silent(const char*, const char*, char*, void*) {}
};

/// Owns the C objects of one solve.
struct Memory {
  SUNContext context = nullptr;
  N_Vector u = nullptr, ones = nullptr;
  SUNMatrix J = nullptr;
  SUNLinearSolver linear = nullptr;
  void* kin = nullptr;
  explicit Memory(std::size_t n_unknowns) {
    const auto n = static_cast<sunindextype>(n_unknowns);
    if (SUNContext_Create(nullptr, &context) != 0) throw TrimError("KINSOL: no context");
    u = N_VNew_Serial(n, context);
    ones = N_VNew_Serial(n, context);
    J = SUNDenseMatrix(n, n, context);
    linear = u && J ? SUNLinSol_Dense(u, J, context) : nullptr;
    kin = KINCreate(context);
    if (!u || !ones || !linear || !kin) throw TrimError("KINSOL: out of memory");
    N_VConst(1.0, ones);
  }
  ~Memory() {
    if (kin) KINFree(&kin);
    if (linear) SUNLinSolFree(linear);
    if (J) SUNMatDestroy(J);
    if (ones) N_VDestroy(ones);
    if (u) N_VDestroy(u);
    if (context) SUNContext_Free(&context);
  }
  Memory(const Memory&) = delete;
};

}  // namespace

EquilibriumResult solve_equilibrium(const Residual& r, std::vector<double> x0, const EquilibriumOptions& o) {
  const std::size_t n = x0.size();
  if (n == 0 || o.x_scale.size() != n || o.r_scale.size() != n)
    throw TrimError("solve_equilibrium: x0, x_scale and r_scale must have the same size, at least 1");
  for (std::size_t i = 0; i < n; ++i)
    if (!(o.x_scale[i] > 0) || !(o.r_scale[i] > 0)) throw TrimError("solve_equilibrium: every scale must be positive");

  Problem p{r, o, n, std::vector<double>(n), std::vector<double>(n), "", nullptr};
  Memory m(n);
  for (std::size_t i = 0; i < n; ++i) N_VGetArrayPointer(m.u)[i] = x0[i] / o.x_scale[i];
  KINSetErrHandlerFn(m.kin, &Problem::on_error, &p);
  KINSetInfoHandlerFn(m.kin, &Problem::silent, &p);
  if (KINInit(m.kin, &Problem::call, m.u) < 0) throw TrimError("KINSOL: " + p.message);
  KINSetUserData(m.kin, &p);
  KINSetLinearSolver(m.kin, m.linear, m.J);
  KINSetJacFn(m.kin, &Problem::jacobian);
  KINSetMaxSetupCalls(m.kin, 1);  // a fresh Jacobian in every iteration: contact stiffness changes quickly
  KINSetFuncNormTol(m.kin, o.tolerance);
  KINSetScaledStepTol(m.kin, 1e-14);
  KINSetNumMaxIters(m.kin, o.max_iterations);
  KINSetMaxNewtonStep(m.kin, 1e3);
  const int flag = KINSol(m.kin, m.u, KIN_LINESEARCH, m.ones, m.ones);
  if (p.thrown) std::rethrow_exception(p.thrown);

  EquilibriumResult result;
  long iterations = 0;
  KINGetNumNonlinSolvIters(m.kin, &iterations);
  result.iterations = static_cast<int>(iterations);
  std::vector<double> f(n);
  p.evaluate(N_VGetArrayPointer(m.u), f.data());
  for (double v : f) result.residual = std::max(result.residual, std::abs(v));
  result.x = p.x;
  // The residual decides, not the flag: KINSOL also stops with a warning where rounding ends the line search.
  result.ok = result.residual <= o.tolerance;
  if (!result.ok) {
    char text[96];
    std::snprintf(text, sizeof text, "largest scaled residual %.3g after %ld iterations (KINSOL %d)", result.residual,
                  iterations, flag);
    result.why = text + (p.message.empty() ? "" : ": " + p.message);
  }
  return result;
}

}  // namespace grouser::vehicle
