#include "grouser/vehicle/ode.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cmath>
#include <cstdio>
#include <exception>

namespace grouser::vehicle {

struct Ode::Impl {
  SUNContext context = nullptr;
  void* cvode = nullptr;
  N_Vector y = nullptr, absolute = nullptr;
  SUNMatrix jacobian = nullptr;
  SUNLinearSolver linear = nullptr;
  double t = 0;
  long evaluations_of_f = 0;
  std::size_t n = 0;
  Rhs f;
  Roots g;
  std::vector<int> crossings;
  std::string last_message;
  std::exception_ptr thrown;

  ~Impl() {
    if (cvode) CVodeFree(&cvode);
    if (linear) SUNLinSolFree(linear);
    if (jacobian) SUNMatDestroy(jacobian);
    if (y) N_VDestroy(y);
    if (absolute) N_VDestroy(absolute);
    if (context) SUNContext_Free(&context);
  }

  // CVODE is C: an exception must not cross it, so it is kept and rethrown by advance().
  static int call_f(double t, N_Vector y, N_Vector dy, void* self) {
    auto& me = *static_cast<Impl*>(self);
    ++me.evaluations_of_f;
    try {
      me.f(t, {N_VGetArrayPointer(y), me.n}, {N_VGetArrayPointer(dy), me.n});
      return 0;
    } catch (...) {
      me.thrown = std::current_exception();
      return -1;
    }
  }
  static int call_g(double t, N_Vector y, double* g, void* self) {
    auto& me = *static_cast<Impl*>(self);
    try {
      me.g(t, {N_VGetArrayPointer(y), me.n}, {g, me.crossings.size()});
      return 0;
    } catch (...) {
      me.thrown = std::current_exception();
      return -1;
    }
  }
  static void on_error(int, const char*, const char*, char* message, void* self) {
    static_cast<Impl*>(self)->last_message = message;
  }

  [[noreturn]] void fail(const char* call, int flag) {
    if (thrown) {
      const std::exception_ptr e = thrown;
      thrown = nullptr;
      std::rethrow_exception(e);
    }
    char text[160];
    std::snprintf(text, sizeof text, "CVODE: %s failed with %d at t = %.9g s: ", call, flag, t);
    throw OdeError(text + last_message);
  }
  void check(const char* call, int flag) {
    if (flag < 0) fail(call, flag);
  }
};

Ode::Ode(double t0, std::vector<double> y0, Rhs f, OdeOptions o) : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  if (o.absolute.empty()) o.absolute = {1e-10};
  if (y0.empty()) throw OdeError("CVODE: the state is empty");
  if (!(o.relative > 0) || !(o.max_step > 0)) throw OdeError("CVODE: relative tolerance and max_step must be positive");
  if (o.absolute.size() != 1 && o.absolute.size() != y0.size())
    throw OdeError("CVODE: " + std::to_string(o.absolute.size()) + " absolute tolerances for " +
                   std::to_string(y0.size()) + " components");
  for (double a : o.absolute)
    if (!(a > 0)) throw OdeError("CVODE: every absolute tolerance must be positive");
  m.n = y0.size();
  m.t = t0;
  m.f = std::move(f);
  const auto n = static_cast<sunindextype>(m.n);
  if (SUNContext_Create(nullptr, &m.context) != 0) throw OdeError("CVODE: no context");
  m.y = N_VNew_Serial(n, m.context);
  m.absolute = N_VNew_Serial(n, m.context);
  m.jacobian = SUNDenseMatrix(n, n, m.context);
  m.linear = m.y && m.jacobian ? SUNLinSol_Dense(m.y, m.jacobian, m.context) : nullptr;
  m.cvode = CVodeCreate(CV_BDF, m.context);
  if (!m.y || !m.absolute || !m.linear || !m.cvode) throw OdeError("CVODE: out of memory");
  for (std::size_t i = 0; i < m.n; ++i) {
    N_VGetArrayPointer(m.y)[i] = y0[i];
    N_VGetArrayPointer(m.absolute)[i] = o.absolute.size() == 1 ? o.absolute[0] : o.absolute[i];
  }
  CVodeSetErrHandlerFn(m.cvode, &Impl::on_error, &m);
  m.check("CVodeInit", CVodeInit(m.cvode, &Impl::call_f, t0, m.y));
  CVodeSetUserData(m.cvode, &m);
  m.check("CVodeSVtolerances", CVodeSVtolerances(m.cvode, o.relative, m.absolute));
  m.check("CVodeSetLinearSolver", CVodeSetLinearSolver(m.cvode, m.linear, m.jacobian));
  CVodeSetMaxNumSteps(m.cvode, o.max_steps);
  if (std::isfinite(o.max_step)) CVodeSetMaxStep(m.cvode, o.max_step);
}

Ode::~Ode() = default;
Ode::Ode(Ode&&) noexcept = default;

void Ode::watch(int n, Roots g) {
  impl_->g = std::move(g);
  impl_->crossings.assign(static_cast<std::size_t>(n), 0);
  impl_->check("CVodeRootInit", CVodeRootInit(impl_->cvode, n, n > 0 ? &Impl::call_g : nullptr));
}

Ode::Stop Ode::advance(double t_end) {
  Impl& m = *impl_;
  if (!(t_end > m.t))
    throw OdeError("CVODE: asked to advance to t = " + std::to_string(t_end) + " s, which is not ahead of " +
                   std::to_string(m.t) + " s");
  m.check("CVodeSetStopTime", CVodeSetStopTime(m.cvode, t_end));
  const int flag = CVode(m.cvode, t_end, m.y, &m.t, CV_NORMAL);
  m.check("CVode", flag);
  if (flag != CV_ROOT_RETURN) return Stop::end;
  CVodeGetRootInfo(m.cvode, m.crossings.data());
  return Stop::root;
}

double Ode::time() const { return impl_->t; }
std::span<const double> Ode::state() const { return {N_VGetArrayPointer(impl_->y), impl_->n}; }
const std::vector<int>& Ode::crossings() const { return impl_->crossings; }

void Ode::restart(double t, std::span<const double> y) {
  Impl& m = *impl_;
  if (y.size() != m.n) throw OdeError("CVODE: restart with another number of components");
  // y may be this object's own state: copy within the same array is fine.
  for (std::size_t i = 0; i < m.n; ++i) N_VGetArrayPointer(m.y)[i] = y[i];
  m.t = t;
  m.check("CVodeReInit", CVodeReInit(m.cvode, t, m.y));
}

long Ode::steps() const {
  long s = 0;
  CVodeGetNumSteps(impl_->cvode, &s);
  return s;
}
long Ode::evaluations() const { return impl_->evaluations_of_f; }

}  // namespace grouser::vehicle
