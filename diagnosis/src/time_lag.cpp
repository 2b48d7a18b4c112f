#include "time_lag.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>

namespace grouser::diagnosis {

int dynamic_columns(const TimeDynamics& d, int channels) {
  return (d.sigma > 0 ? 1 : 0) + (d.tau > 0 ? 1 : 0) + (d.delay > 0 ? 1 : 0) + (d.lugs > 0 ? 2 * channels : 0) +
         static_cast<int>(d.shape.size());
}

namespace {

/// The chain of T1 to T3 as a linear system; each channel has the states a, L_1..L_K, b as far as they are on.
class Chain {
 public:
  Chain(const TimeTrack& track, const TimeDynamics& d, bool free_start)
      : track_(track), d_(d), channels_(track.channels), free_start_(free_start) {
    relax_ = d.sigma > 0, filter_ = d.tau > 0;
    shapes_ = static_cast<int>(d.shape_scales.size());
    per_channel_ = (relax_ ? 1 : 0) + shapes_ + (filter_ ? 1 : 0);
    int next = track.parameters + (free_start ? channels_ : 0);
    if (relax_) sigma_column_ = next++;
    if (filter_) tau_column_ = next++;
    if (d.delay > 0) delay_column_ = next++;
    if (d.lugs > 0) ripple_column_ = next, next += 2 * channels_;
    shape_column_ = next;
    columns_ = next + shapes_;
    row_.resize(track.target.cols());
    slope_.resize(track.target.cols());
  }

  int states() const { return channels_ * per_channel_; }
  int columns() const { return columns_; }

  /// State and its slopes at the first row.
  void start(const std::vector<double>& given, double* y, std::vector<double>& s) const {
    s.assign(static_cast<std::size_t>(states() * columns_), 0.0);
    for (int c = 0; c < channels_; ++c)
      for (int k = 0; k < per_channel_; ++k) {
        const int i = c * per_channel_ + k;
        y[i] = free_start_ ? given[static_cast<std::size_t>(c)] : track_.target(0, c);
        if (free_start_)
          s[static_cast<std::size_t>((track_.parameters + c) * states() + i)] = 1;
        else
          for (int p = 0; p < track_.parameters; ++p)
            s[static_cast<std::size_t>(p * states() + i)] = target_slope(track_.target.row(0), p, c);
      }
  }

  void rates(double t, const double* y, double* dy) {
    at(t);
    for (int c = 0; c < channels_; ++c) {
      const double* s = y + c * per_channel_;
      double* ds = dy + c * per_channel_;
      int k = 0;
      double a = row_[c];
      if (relax_) ds[0] = speed_ / d_.sigma * (row_[c] - s[0]), a = s[0], k = 1;
      double base = a;
      for (int m = 0; m < shapes_; ++m) {
        ds[k + m] = rate_of(m) * (a - s[k + m]);
        base += d_.shape[static_cast<std::size_t>(m)] * (s[k + m] - a);
      }
      if (filter_) ds[k + shapes_] = (base + ripple(c) - s[k + shapes_]) / d_.tau;
    }
  }

  void jacobian(double t, SUNMatrix J) {
    at(t);
    SUNMatZero(J);
    for (int c = 0; c < channels_; ++c) {
      const int i = c * per_channel_;
      int k = i;
      if (relax_) SM_ELEMENT_D(J, i, i) = -speed_ / d_.sigma, k = i + 1;
      double left = 1;
      for (int m = 0; m < shapes_; ++m) {
        if (relax_) SM_ELEMENT_D(J, k + m, i) = rate_of(m);
        SM_ELEMENT_D(J, k + m, k + m) = -rate_of(m);
        left -= d_.shape[static_cast<std::size_t>(m)];
      }
      if (!filter_) continue;
      const int b = k + shapes_;
      SM_ELEMENT_D(J, b, b) = -1 / d_.tau;
      if (relax_) SM_ELEMENT_D(J, b, i) = left / d_.tau;
      for (int m = 0; m < shapes_; ++m) SM_ELEMENT_D(J, b, k + m) = d_.shape[static_cast<std::size_t>(m)] / d_.tau;
    }
  }

  void sensitivities(double t, const double* y, N_Vector* s, N_Vector* ds) {
    at(t);
    for (int p = 0; p < columns_; ++p)
      for (int c = 0; c < channels_; ++c)
        column_rate(p, c, y + c * per_channel_, N_VGetArrayPointer(s[p]) + c * per_channel_,
                    N_VGetArrayPointer(ds[p]) + c * per_channel_);
  }

  /// Shown value of each channel at t, with states y; slopes(c) by columns; rate: its derivative by time.
  void shown(double t, const double* y, const std::vector<const double*>& s, double* value, double* rate,
             Eigen::MatrixXd* slopes, int first_row) {
    at(t);
    for (int c = 0; c < channels_; ++c) {
      const double* q = y ? y + c * per_channel_ : nullptr;
      int k = 0;
      double a = row_[c], da = slope_[c];
      if (relax_) a = q[0], da = speed_ / d_.sigma * (row_[c] - q[0]), k = 1;
      double base = a, dbase = da;
      for (int m = 0; m < shapes_; ++m) {
        const double h = d_.shape[static_cast<std::size_t>(m)];
        base += h * (q[k + m] - a), dbase += h * (rate_of(m) * (a - q[k + m]) - da);
      }
      value[c] = filter_ ? q[k + shapes_] : base + ripple(c);
      rate[c] = filter_ ? (base + ripple(c) - value[c]) / d_.tau : dbase + ripple_rate(c);
      if (!slopes) continue;
      for (int p = 0; p < columns_; ++p) {
        const double* sp = s.empty() ? nullptr : s[static_cast<std::size_t>(p)] + c * per_channel_;
        double v;
        if (filter_) {
          v = sp[k + shapes_];
        } else {
          const double own = relax_ ? sp[0] : target_slope(row_, p, c);
          v = own + ripple_slope(p, c);
          for (int m = 0; m < shapes_; ++m) {
            v += d_.shape[static_cast<std::size_t>(m)] * (sp[k + m] - own);
            if (p == shape_column_ + m) v += q[k + m] - a;
          }
        }
        if (p == delay_column_) v = -d_.delay * rate[c];
        (*slopes)(first_row + c, p) = v;
      }
    }
  }

 private:
  double rate_of(int m) const {
    return (d_.shape_over_travel ? speed_ : 1.0) / d_.shape_scales[static_cast<std::size_t>(m)];
  }
  template <class Row>
  double target_slope(const Row& row, int p, int c) const {
    return p < track_.parameters ? row[channels_ * (1 + p) + c] : 0.0;
  }
  double ripple(int c) const {
    if (d_.lugs == 0) return 0;
    return d_.ripple[static_cast<std::size_t>(2 * c)] * std::sin(d_.lugs * turn_) +
           d_.ripple[static_cast<std::size_t>(2 * c + 1)] * std::cos(d_.lugs * turn_);
  }
  double ripple_rate(int c) const {
    if (d_.lugs == 0) return 0;
    return d_.lugs * turn_rate_ *
           (d_.ripple[static_cast<std::size_t>(2 * c)] * std::cos(d_.lugs * turn_) -
            d_.ripple[static_cast<std::size_t>(2 * c + 1)] * std::sin(d_.lugs * turn_));
  }
  double ripple_slope(int p, int c) const {
    if (d_.lugs == 0) return 0;
    if (p == ripple_column_ + 2 * c) return std::sin(d_.lugs * turn_);
    return p == ripple_column_ + 2 * c + 1 ? std::cos(d_.lugs * turn_) : 0.0;
  }

  void column_rate(int p, int c, const double* y, const double* s, double* ds) const {
    int k = 0;
    double own = target_slope(row_, p, c), a = row_[c];
    if (relax_) {
      const double q = speed_ / d_.sigma;
      ds[0] = q * (own - s[0]);
      if (p == sigma_column_) ds[0] -= q * (row_[c] - y[0]);
      own = s[0], a = y[0], k = 1;
    }
    double base = a, dbase = own;
    for (int m = 0; m < shapes_; ++m) {
      const double h = d_.shape[static_cast<std::size_t>(m)];
      ds[k + m] = rate_of(m) * (own - s[k + m]);
      base += h * (y[k + m] - a), dbase += h * (s[k + m] - own);
      if (p == shape_column_ + m) dbase += y[k + m] - a;
    }
    if (!filter_) return;
    const int b = k + shapes_;
    ds[b] = (dbase + ripple_slope(p, c) - s[b]) / d_.tau;
    if (p == tau_column_) ds[b] -= (base + ripple(c) - y[b]) / d_.tau;
  }

  /// Everything that drives, at t; beyond the ends as at them.
  void at(double t) {
    const auto& x = track_.t;
    const std::size_t n = x.size();
    if (!(t >= x[hint_]) || (hint_ + 1 < n && t >= x[hint_ + 1]))
      hint_ = t <= x[0]
                  ? 0
                  : std::min(static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), t) - x.begin()) - 1, n - 2);
    const double dt = x[hint_ + 1] - x[hint_], f = std::clamp((t - x[hint_]) / dt, 0.0, 1.0);
    const bool inside = t >= x[0] && t <= x[n - 1];
    const auto i = static_cast<Eigen::Index>(hint_);
    row_ = (1 - f) * track_.target.row(i) + f * track_.target.row(i + 1);
    slope_ = (track_.target.row(i + 1) - track_.target.row(i)) * (inside ? 1 / dt : 0.0);
    speed_ = (1 - f) * track_.speed[hint_] + f * track_.speed[hint_ + 1];
    turn_ = (1 - f) * track_.turn[hint_] + f * track_.turn[hint_ + 1];
    turn_rate_ = inside ? (track_.turn[hint_ + 1] - track_.turn[hint_]) / dt : 0;
  }

  const TimeTrack& track_;
  const TimeDynamics& d_;
  int channels_, per_channel_ = 0, shapes_ = 0, columns_ = 0;
  int sigma_column_ = -1, tau_column_ = -1, delay_column_ = -1, ripple_column_ = -1, shape_column_ = -1;
  bool relax_, filter_, free_start_;
  std::size_t hint_ = 0;
  Eigen::RowVectorXd row_, slope_;
  double speed_ = 0, turn_ = 0, turn_rate_ = 0;
};

int call_rates(double t, N_Vector y, N_Vector dy, void* chain) {
  static_cast<Chain*>(chain)->rates(t, N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
  return 0;
}
int call_jacobian(double t, N_Vector, N_Vector, SUNMatrix J, void* chain, N_Vector, N_Vector, N_Vector) {
  static_cast<Chain*>(chain)->jacobian(t, J);
  return 0;
}
int call_sensitivities(int, double t, N_Vector y, N_Vector, N_Vector* s, N_Vector* ds, void* chain, N_Vector,
                       N_Vector) {
  static_cast<Chain*>(chain)->sensitivities(t, N_VGetArrayPointer(y), s, ds);
  return 0;
}
void be_quiet(int, const char*, const char*, char*, void*) {}

/// What CVODES allocates.
struct Solver {
  SUNContext context = nullptr;
  void* memory = nullptr;
  N_Vector y = nullptr, absolute = nullptr;
  N_Vector* s = nullptr;
  int columns = 0;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  Solver() = default;
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;
  ~Solver() {
    if (memory) CVodeFree(&memory);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
    if (s) N_VDestroyVectorArray(s, columns);
    if (y) N_VDestroy(y);
    if (absolute) N_VDestroy(absolute);
    if (context) SUNContext_Free(&context);
  }
  bool begin(Chain& chain, const TimeTrack& track, const std::vector<double>& start, bool slopes) {
    const int n = chain.states();
    if (SUNContext_Create(nullptr, &context) != 0) return false;
    y = N_VNew_Serial(n, context), absolute = N_VNew_Serial(n, context);
    matrix = SUNDenseMatrix(n, n, context);
    linear = SUNLinSol_Dense(y, matrix, context);
    memory = CVodeCreate(CV_BDF, context);
    std::vector<double> first;
    chain.start(start, N_VGetArrayPointer(y), first);
    for (int i = 0; i < n; ++i) {
      const int c = i / (n / track.channels);
      double size = track.target.col(c).cwiseAbs().maxCoeff();
      if (!start.empty()) size = std::max(size, std::abs(start[static_cast<std::size_t>(c)]));
      N_VGetArrayPointer(absolute)[i] = 1e-6 * std::max(size, 1e-12);
    }
    bool good = CVodeInit(memory, call_rates, track.t[0], y) == CV_SUCCESS;
    CVodeSetErrHandlerFn(memory, be_quiet, nullptr);
    good = good && CVodeSetUserData(memory, &chain) == CV_SUCCESS &&
           CVodeSVtolerances(memory, 1e-5, absolute) == CV_SUCCESS &&
           CVodeSetLinearSolver(memory, linear, matrix) == CV_SUCCESS &&
           CVodeSetJacFn(memory, call_jacobian) == CV_SUCCESS && CVodeSetMaxNumSteps(memory, 100000) == CV_SUCCESS &&
           CVodeSetMaxStep(memory, 4 * track.spacing) == CV_SUCCESS;
    if (!good || !slopes) return good;
    columns = chain.columns();
    s = N_VCloneVectorArray(columns, y);
    for (int p = 0; p < columns; ++p) std::copy_n(first.begin() + p * n, n, N_VGetArrayPointer(s[p]));
    return CVodeSensInit(memory, columns, CV_STAGGERED, call_sensitivities, s) == CV_SUCCESS &&
           CVodeSensEEtolerances(memory) == CV_SUCCESS;
  }
};

}  // namespace

bool respond(const TimeTrack& track, const TimeDynamics& d, const std::vector<double>& start, bool slopes,
             TimeResponse& out) {
  const bool free_start = !start.empty();
  Chain chain(track, d, free_start);
  const auto rows = static_cast<Eigen::Index>(track.rows.size());
  out.y.resize(rows, track.channels);
  if (slopes) out.slopes.setZero(rows * track.channels, chain.columns());
  std::array<double, channel_count> rate{};
  Solver solver;
  const bool states = chain.states() > 0;
  if (states && !solver.begin(chain, track, start, slopes)) return false;
  double reached = track.t[0];
  std::vector<const double*> s;
  for (int p = 0; p < solver.columns; ++p) s.push_back(N_VGetArrayPointer(solver.s[p]));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = track.rows[static_cast<std::size_t>(i)] - d.delay;
    if (states && t > track.t[0]) {
      if (CVode(solver.memory, t, solver.y, &reached, CV_NORMAL) < 0) return false;
      if (slopes && CVodeGetSens(solver.memory, &reached, solver.s) != CV_SUCCESS) return false;
    }
    chain.shown(t, states ? N_VGetArrayPointer(solver.y) : nullptr, s, &out.y(i, 0), rate.data(),
                slopes ? &out.slopes : nullptr, static_cast<int>(i) * track.channels);
    // Before the first row nothing moves.
    if (slopes && d.delay > 0 && t <= track.t[0])
      for (int c = 0; c < track.channels; ++c) {
        const int column =
            track.parameters + (free_start ? track.channels : 0) + (d.sigma > 0 ? 1 : 0) + (d.tau > 0 ? 1 : 0);
        out.slopes(i * track.channels + c, column) = 0;
      }
  }
  return out.y.allFinite();
}

}  // namespace grouser::diagnosis
