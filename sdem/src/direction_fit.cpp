#include "grouser/sdem/direction_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>
#include <numeric>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

namespace grouser::sdem {

namespace {

constexpr double kStep = 1e-3;  ///< [s]
constexpr double kGravity = 9.81;
constexpr double kWindow = 25e-3;  ///< [m] of the way
constexpr double kFirst = 40e-3;   ///< [m] of the way before the first window: a wheel has built its pile by then
// What windows of two packings differ by.
constexpr double kSdHeight = 0.7e-3, kSdShare = 0.15, kSdTorque = 0.1, kSdLog = 0.4, kSdProfile = 2e-3;
constexpr double kHeld = 2;        ///< forces of a held wheel jump: spreads are so many times larger
constexpr double kKnee = 2;        ///< residuals beyond grow like the root
constexpr double kSettled = 0.35;  ///< share of a way after which means are taken
constexpr int kEach = 6;           ///< coefficients of each of F_L, mu, tau
constexpr int kPressed = 24;       ///< samples of a pressed run

/// A run as the fit needs it.
struct Way {
  std::size_t run = 0;
  double load = 0;
  bool press = false;
  std::vector<double> t, x, z, vx, vz, spin, fx, fz, torque;
  std::vector<bool> free;
  std::vector<double> behind, ahead;  ///< profile less fresh soil by sample, NaN where none was taken [m]
};

double mean_between(const std::vector<double>& d, const std::vector<double>& place, double a, double b) {
  double sum = 0;
  int n = 0;
  for (std::size_t i = 0; i < d.size(); ++i)
    if (std::isfinite(d[i]) && place[i] > a && place[i] < b) {
      sum += d[i];
      ++n;
    }
  return n > 0 ? sum / n : std::nan("");
}

constexpr double kBehindFrom = -70e-3, kBehindTo = -40e-3, kAheadFrom = 25e-3, kAheadTo = 45e-3;

Way way_of(std::size_t run, const TrainingPlan& p, const TrainingRun& r, const TrainingRecord& record) {
  Way w;
  w.run = run;
  w.load = r.load;
  w.press = r.kind == TrainingRun::Kind::press;
  const auto wide = [](const std::vector<float>& v) { return std::vector<double>(v.begin(), v.end()); };
  w.t = wide(record.time);
  w.x = wide(record.x);
  w.z = wide(record.z);
  w.vx = wide(record.vx);
  w.vz = wide(record.vz);
  w.spin = wide(record.spin);
  w.fx = wide(record.fx);
  w.fz = wide(record.fz);
  w.torque = wide(record.torque);
  for (const float f : record.free) w.free.push_back(f > 0.5F);
  w.behind.assign(w.t.size(), std::nan(""));
  w.ahead = w.behind;
  std::map<std::int64_t, double> fresh;
  for (std::size_t k = 0; k < record.profile_sample.size(); ++k) {
    std::vector<double> change, place;
    const auto sample = static_cast<std::size_t>(std::max<std::int64_t>(0, record.profile_sample[k] - 1));
    if (sample >= w.t.size()) continue;
    for (int i = 0; i < TrainingRecord::kColumns; ++i) {
      const double h = record.profile[k * TrainingRecord::kColumns + static_cast<std::size_t>(i)];
      if (!std::isfinite(h)) continue;
      const std::int64_t column = record.profile_column[k] + i;
      const auto [at, first] = fresh.try_emplace(column, h);
      change.push_back(h - at->second);
      place.push_back((static_cast<double>(column) + 0.5) * p.column - w.x[sample]);
    }
    w.behind[sample] = mean_between(change, place, kBehindFrom, kBehindTo);
    w.ahead[sample] = mean_between(change, place, kAheadFrom, kAheadTo);
  }
  return w;
}

struct Trace {
  std::vector<double> z, fx, fz, torque, b, depth, tilt, behind, ahead;
  std::shared_ptr<const DirectionWheel> wheel;
};

/// The law over the way of a run.
Trace drive(const Way& w, const Ground& ground, const std::shared_ptr<const Direction>& law,
            const DirectionSettings& settings) {
  Trace out;
  const auto kept = std::make_shared<DirectionWheel>(law, settings);
  DirectionWheel& wheel = *kept;
  const auto height = [&](double s) { return ground.height(s, 0); };
  const double k = std::exp(law->at(Coefficient::ln_k)), m = w.load / kGravity;
  double x = w.x[0] - w.vx[0] * 5e-3, z = w.z[0] - w.vz[0] * 5e-3, t = std::max(0.0, w.t[0] - 5e-3), vz = 0, fz = 0;
  for (std::size_t i = 0; i < w.t.size(); ++i) {
    const double span = w.t[i] - t;
    const int n = std::max(1, static_cast<int>(std::lround(span / kStep)));
    const double h = span / n;
    double sx = 0, sz = 0, st = 0;
    const double up = (w.z[i] - z) / span, along = (w.x[i] - x) / span;
    PlaneForce f;
    for (int j = 0; j < n; ++j) {
      if (w.free[i])
        vz = (m * vz + h * (fz - w.load)) / (m + k * h * h);
      else
        vz = up;
      f = wheel.step({x, z, x + along * h, z + vz * h, w.spin[i] * law->radius * h, 0, h}, height);
      x += along * h;
      z += vz * h;
      fz = f.fz;
      sx += f.fs;
      sz += f.fz;
      st += f.torque;
    }
    t = w.t[i];
    out.z.push_back(z);
    out.fx.push_back(sx / n);
    out.fz.push_back(sz / n);
    out.torque.push_back(st / n);
    out.b.push_back(f.b);
    out.depth.push_back(f.depth);
    out.tilt.push_back(f.tilt);
    const auto change = [&](double asked, double from, double to) {
      if (!std::isfinite(asked)) return std::nan("");
      double sum = 0;
      int count = 0;
      for (double d = from; d < to; d += 3e-3)
        if (const double a = wheel.surface(x + d) - height(x + d); std::isfinite(a)) {
          sum += a;
          ++count;
        }
      return count > 0 ? sum / count : std::nan("");
    };
    out.behind.push_back(change(w.behind[i], kBehindFrom, kBehindTo));
    out.ahead.push_back(change(w.ahead[i], kAheadFrom, kAheadTo));
  }
  out.wheel = kept;
  return out;
}

void windows_of(const Way& w, const Ground& ground, double radius, const Trace& t, std::vector<FitWindow>& out) {
  if (w.press) return;
  double begin = 1e300;
  for (std::size_t i = 0; i < w.t.size(); ++i)
    if (std::abs(w.vx[i]) > 1e-3) {
      begin = w.x[i] + kFirst;
      break;
    }
  for (std::size_t i = 0; i < w.t.size();) {
    if (w.x[i] < begin) {
      ++i;
      continue;
    }
    const double slip = 1 - w.vx[i] / std::max(1e-9, std::abs(w.spin[i]) * radius);
    FitWindow f;
    f.run = w.run;
    f.free = w.free[i];
    std::array<int, 6> n{};
    std::size_t j = i;
    const auto add = [&](std::size_t k, double grains, double law) {
      if (!std::isfinite(grains) || !std::isfinite(law)) return;
      f.grains[k] += grains;
      f.law[k] += law;
      ++n[k];
    };
    int all = 0;
    for (; j < w.t.size() && w.x[j] < w.x[i] + kWindow; ++j) {
      // One slip in a window.
      if (std::abs(1 - w.vx[j] / std::max(1e-9, std::abs(w.spin[j]) * radius) - slip) > 0.05) break;
      const double h = ground.height(w.x[j], 0) + radius;
      add(0, w.z[j] - h, t.z[j] - h);
      add(1, w.fx[j], t.fx[j]);
      add(2, w.fz[j], t.fz[j]);
      add(3, -w.torque[j], t.torque[j]);
      add(4, w.behind[j], t.behind[j]);
      add(5, w.ahead[j], t.ahead[j]);
      f.b += t.b[j];
      f.depth += t.depth[j];
      f.deepest = std::max(f.deepest, t.depth[j]);
      f.tilt += t.tilt[j];
      ++all;
    }
    const bool whole = j > i && w.x[std::min(j, w.t.size() - 1)] - w.x[i] > 0.6 * kWindow;
    if (whole) {
      for (std::size_t k = 0; k < 6; ++k) {
        f.grains[k] = n[k] > 0 ? f.grains[k] / n[k] : std::nan("");
        f.law[k] = n[k] > 0 ? f.law[k] / n[k] : std::nan("");
      }
      f.b /= all;
      f.depth /= all;
      f.tilt /= all;
      f.x = 0.5 * (w.x[i] + w.x[j - 1]);
      f.slip = slip;
      out.push_back(f);
    }
    i = std::max(j, i + 1);
  }
}

double bent(double r) {
  const double a = std::abs(r);
  return a <= kKnee ? r : std::copysign(std::sqrt(2 * kKnee * a - kKnee * kKnee), r);
}

class Problem {
 public:
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  Problem(const TrainingPlan& p, const std::vector<TrainingRun>& runs, const std::vector<TrainingRecord>& records,
          const Direction& law, const FitSettings& settings)
      : runs_(runs), law_(law), settings_(settings) {
    for (std::size_t k = 0; k < runs.size(); ++k)
      if (!records[k].time.empty()) ways_.push_back(way_of(k, p, runs[k], records[k]));
    for (std::size_t k = 0; k < kCoefficients; ++k)
      if (coefficient_infos()[k].prior > 0) free_.push_back(k);
    values_ = static_cast<int>(residuals(start()).size());
  }
  int inputs() const { return static_cast<int>(free_.size()); }
  int values() const { return values_; }
  Eigen::VectorXd start() const {
    Eigen::VectorXd x(inputs());
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const CoefficientInfo& i = coefficient_infos()[free_[k]];
      x[static_cast<Eigen::Index>(k)] = (law_.c[free_[k]] - i.start) / i.prior;
    }
    return x;
  }
  const std::vector<Way>& ways() const { return ways_; }
  const TrainingRun& run_of(const Way& w) const { return runs_[w.run]; }

  /// Coefficients from differences to their starts over priors.
  Direction law_at(const Eigen::VectorXd& x) const {
    Direction d = law_;
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const CoefficientInfo& i = coefficient_infos()[free_[k]];
      d.c[free_[k]] = i.start + i.prior * x[static_cast<Eigen::Index>(k)];
    }
    return d;
  }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
    const std::vector<double> r = residuals(x);
    for (Eigen::Index i = 0; i < f.size(); ++i)
      f[i] = i < static_cast<Eigen::Index>(r.size()) ? r[static_cast<std::size_t>(i)] : 0;
    return 0;
  }

  std::vector<double> residuals(const Eigen::VectorXd& x) const {
    const auto law = std::make_shared<const Direction>(law_at(x));
    std::vector<double> out;
    const auto put = [&](double difference, double sd) {
      out.push_back(std::isfinite(difference) ? bent(difference / sd) : 0.0);
    };
    std::vector<FitWindow> windows;
    for (const Way& w : ways_) {
      const Ground& ground = *runs_[w.run].ground;
      const Trace t = drive(w, ground, law, settings_.wheel);
      if (w.press) {
        for (int k = 0; k < kPressed; ++k) {
          const std::size_t i = (w.t.size() - 1) * static_cast<std::size_t>(k) / (kPressed - 1);
          put(t.fz[i] - w.fz[i], 0.5 * std::max(w.fz[i], 3.0));
        }
        continue;
      }
      windows.clear();
      windows_of(w, ground, law->radius, t, windows);
      for (const FitWindow& f : windows) {
        const double load = f.free ? w.load : std::max(f.grains[2], 2.0);
        if (f.free)
          put(f.law[0] - f.grains[0], kSdHeight);
        else
          put(std::log(std::max(f.law[2], 0.5) / std::max(f.grains[2], 0.5)), kSdLog);
        // Held: forces of the law are those at its own normal force; ratios are compared.
        const double scale = f.free ? 1 : std::max(f.grains[2], 0.5) / std::max(f.law[2], 0.5);
        const double held = f.free ? 1 : kHeld;
        put(f.law[1] * scale - f.grains[1], held * kSdShare * load);
        put((f.law[3] * scale - f.grains[3]) / law->radius, held * kSdTorque * load);
        put(f.law[4] - f.grains[4], kSdProfile);
        put(f.law[5] - f.grains[5], kSdProfile);
      }
    }
    for (Eigen::Index k = 0; k < x.size(); ++k) out.push_back(x[k]);
    return out;
  }

 private:
  const std::vector<TrainingRun>& runs_;
  Direction law_;
  FitSettings settings_;
  std::vector<Way> ways_;
  std::vector<std::size_t> free_;
  int values_ = 0;
};

double deviation(const std::vector<double>& v) {
  if (v.size() < 2) return 0;
  double mean = 0, sum = 0;
  for (const double x : v) mean += x / static_cast<double>(v.size());
  for (const double x : v) sum += (x - mean) * (x - mean);
  return std::sqrt(sum / static_cast<double>(v.size() - 1));
}

/// Less the straight line through it: where a wheel drifts over the whole way, no grain moved it.
void remove_trend(std::vector<double>& v) {
  const auto n = static_cast<double>(v.size());
  if (v.size() < 3) return;
  const double middle = (n - 1) / 2;
  double mean = 0, slope = 0;
  for (std::size_t i = 0; i < v.size(); ++i) mean += v[i] / n;
  for (std::size_t i = 0; i < v.size(); ++i) slope += (static_cast<double>(i) - middle) * v[i];
  slope /= n * (n * n - 1) / 12;
  for (std::size_t i = 0; i < v.size(); ++i) v[i] -= mean + slope * (static_cast<double>(i) - middle);
}

/// Lag [samples] at which the autocorrelation falls to a half; 0 where it does not within the series.
double half_lag(const std::vector<double>& v) {
  double mean = 0;
  for (const double x : v) mean += x / static_cast<double>(v.size());
  double before = 1, all = 0;
  for (const double x : v) all += (x - mean) * (x - mean);
  for (std::size_t lag = 1; lag < v.size() / 2; ++lag) {
    double sum = 0;
    for (std::size_t i = lag; i < v.size(); ++i) sum += (v[i] - mean) * (v[i - lag] - mean);
    const double now = sum / all;
    if (now < 0.5) return static_cast<double>(lag) - (0.5 - now) / (before - now);
    before = now;
  }
  return 0;
}

constexpr std::uint64_t kSeeds = 4;  ///< of the law for each run of grains
constexpr double kDeepest = 5e-3;    ///< amplitude of the noise of depth [m]

/// Fluctuations of free level runs: standard deviations in time of height, Fx, torque and Fz over their load, grains and law.
struct Fluctuation {
  std::array<double, 4> grains{}, law{};
  /// ln of the ways over which half of it is forgotten, law over grains: height, Fx.
  std::array<double, 2> longer{};
  double joint = 0;
  struct Run {
    double b = 0, height = 0, fx = 0;  ///< ln of the deviations of height and Fx, law over grains
    std::array<double, 3> means{};     ///< of the law: height [m], Fx and torque over load (and radius)
  };
  std::vector<Run> each;
  int runs = 0;
};
Fluctuation fluctuation(const Problem& p, const std::shared_ptr<const Direction>& law,
                        const DirectionSettings& settings) {
  Fluctuation out;
  for (const Way& w : p.ways()) {
    if (w.press || w.load <= 0 || p.run_of(w).slips.size() > 1 || p.run_of(w).rest > 0 ||
        p.run_of(w).ground->describe() != flat_ground()->describe())
      continue;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      DirectionSettings own = settings;
      own.seed = kSeeds * w.run + seed;
      const Trace t = drive(w, *p.run_of(w).ground, law, own);
      std::array<std::vector<double>, 4> a, b;
      const double from = w.x.front() + 0.4 * (w.x.back() - w.x.front());
      for (std::size_t i = 0; i < w.t.size(); ++i) {
        if (!w.free[i] || w.x[i] < from) continue;
        a[0].push_back(w.z[i]);
        a[1].push_back(w.fx[i] / w.load);
        a[2].push_back(-w.torque[i] / w.load / law->radius);
        a[3].push_back(w.fz[i] / w.load);
        b[0].push_back(t.z[i]);
        b[1].push_back(t.fx[i] / w.load);
        b[2].push_back(t.torque[i] / w.load / law->radius);
        b[3].push_back(t.fz[i] / w.load);
      }
      if (a[0].size() < 50) continue;
      const auto mean = [](const std::vector<double>& v) {
        return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
      };
      const std::array<double, 3> means{mean(b[0]), mean(b[1]), mean(b[2])};
      for (std::size_t k = 0; k < 4; ++k) {
        remove_trend(a[k]);
        remove_trend(b[k]);
        out.grains[k] += deviation(a[k]);
        out.law[k] += deviation(b[k]);
      }
      const auto ratio = [&](std::size_t k, double least) {
        return std::log(std::max(least, deviation(b[k])) / std::max(least, deviation(a[k])));
      };
      out.each.push_back({law->b_of(1 - p.run_of(w).slips[0], 1), ratio(0, 1e-5), ratio(1, 1e-3), means});
      double mx = 0, mt = 0, c = 0;
      for (std::size_t i = 0; i < a[1].size(); ++i) {
        mx += a[1][i] / static_cast<double>(a[1].size());
        mt += a[2][i] / static_cast<double>(a[1].size());
      }
      for (std::size_t i = 0; i < a[1].size(); ++i)
        c += (a[1][i] - mx) * (a[2][i] - mt) / static_cast<double>(a[1].size());
      out.joint += c / std::max(1e-12, deviation(a[1]) * deviation(a[2]));
      for (std::size_t k = 0; k < 2; ++k) {
        const double of_grains = half_lag(a[k]), of_law = half_lag(b[k]);
        if (of_grains > 0 && of_law > 0) out.longer[k] += std::log(of_law / of_grains);
      }
      ++out.runs;
    }
  }
  for (std::size_t k = 0; k < 4; ++k) {
    out.grains[k] /= std::max(1, out.runs);
    out.law[k] /= std::max(1, out.runs);
  }
  for (double& x : out.longer) x /= std::max(1, out.runs);
  out.joint /= std::max(1, out.runs);
  return out;
}

/// Amplitudes and lengths of the grain noise with which the law fluctuates as the grains do, and the shifts that keep its means.
void set_noise(const Problem& p, Direction& law, const DirectionSettings& wheel, std::array<double, 4>& ratio) {
  law.grain = {0.7e-3, 0.15, 0.08};
  law.grain_length = Direction{}.grain_length;
  DirectionSettings noisy = wheel;
  noisy.grain_noise = 1;
  DirectionSettings still = wheel;
  still.grain_noise = 0;
  const Fluctuation quiet = fluctuation(p, std::make_shared<const Direction>(law), still);
  law.grain_shift = {};
  constexpr int kTurns = 8;
  for (int turn = 0;; ++turn) {
    const Fluctuation f = fluctuation(p, std::make_shared<const Direction>(law), noisy);
    if (f.runs == 0) return;
    law.grain_joint = std::clamp(f.joint, 0.0, 0.95);
    for (std::size_t k = 0; k < 4; ++k) ratio[k] = f.law[k] / std::max(1e-12, f.grains[k]);
    if (turn + 1 == kTurns) return;
    // ln ratio of Fx = c + slope b + curve b^2, of height c + turn tanh + rise b, shifts c + c1 tanh over the runs, least squares.
    Eigen::MatrixXd a(static_cast<Eigen::Index>(f.each.size()), 3), c(a.rows(), 3), off(a.rows(), 3);
    Eigen::VectorXd y(a.rows()), z(a.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      const Fluctuation::Run &r = f.each[static_cast<std::size_t>(i)], &q = quiet.each[static_cast<std::size_t>(i)];
      a.row(i) << 1, r.b, r.b * r.b;
      c.row(i) << 1, law.turned(r.b, 2), r.b;
      for (Eigen::Index k = 0; k < 3; ++k)
        off(i, k) = r.means[static_cast<std::size_t>(k)] - q.means[static_cast<std::size_t>(k)];
      z[i] = r.height;
      y[i] = r.fx;
    }
    const Eigen::VectorXd x = a.colPivHouseholderQr().solve(y), u = c.colPivHouseholderQr().solve(z);
    const Eigen::MatrixXd v = c.leftCols(2).colPivHouseholderQr().solve(off);
    const auto less = [](double& to, double by) { to = std::clamp(to - by, -2.0, 2.0); };
    less(law.grain_turn, u[1]);
    less(law.grain_rise, u[2]);
    less(law.grain_slope, x[1]);
    less(law.grain_curve, x[2]);
    for (Eigen::Index k = 0; k < 3; ++k)
      for (Eigen::Index m = 0; m < 2; ++m)
        law.grain_shift[static_cast<std::size_t>(k)][static_cast<std::size_t>(m)] -= v(m, k);
    for (std::size_t k = 0; k < 2; ++k)
      law.grain_length[k] = std::clamp(law.grain_length[k] * std::exp(-f.longer[k]), 2e-3, 40e-3);
    for (std::size_t k = 0; k < 3; ++k)
      law.grain[k] = std::clamp(law.grain[k] / std::max(0.2, ratio[k]), 0.0, k == 0 ? kDeepest : 1.5);
  }
}

/// Spread between runs of means, and the cloud of states.
void set_spread(const std::vector<FitWindow>& windows, const std::vector<TrainingRun>& runs, Direction& law) {
  std::map<std::pair<std::size_t, long>, std::array<double, 4>> sums;
  for (const FitWindow& w : windows) {
    const TrainingRun& r = runs[w.run];
    if (!w.free || !std::isfinite(w.grains[0])) continue;
    if (r.slips.size() == 1 && w.x < r.start + kSettled * r.distance) continue;
    auto& s = sums[{w.run, std::lround(10 * w.slip)}];
    s[0] += w.law[0] - w.grains[0];
    s[1] += (w.grains[1] - w.law[1]) / r.load;
    s[2] += (w.grains[3] - w.law[3]) / r.load / law.radius;
    s[3] += 1;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    double sum = 0;
    int n = 0;
    for (const auto& [run, s] : sums) {
      sum += (s[k] / s[3]) * (s[k] / s[3]);
      ++n;
    }
    // The law was fitted to these: degrees of freedom are less by its coefficients for each.
    law.spread[k] = n > kEach ? std::sqrt(sum / (n - kEach)) : 0;
  }
  law.deepest = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  int n = 0;
  for (const FitWindow& w : windows) {
    if (!(w.depth > 0)) continue;
    law.deepest = std::max(law.deepest, w.deepest);
    const Eigen::Vector3d x(w.b, std::log(std::max(w.depth, 1e-6) / Direction::kDepth), w.tilt);
    mean += x;
    second += x * x.transpose();
    ++n;
  }
  if (n < 5) return;
  mean /= n;
  const Eigen::Matrix3d inverse = (second / n - mean * mean.transpose() + 1e-4 * Eigen::Matrix3d::Identity()).inverse();
  for (int i = 0; i < 3; ++i) {
    law.centre[static_cast<std::size_t>(i)] = mean[i];
    for (int j = 0; j < 3; ++j) law.inverse[static_cast<std::size_t>(3 * i + j)] = inverse(i, j);
  }
}

}  // namespace

FitReport fit(const TrainingPlan& p, const std::vector<TrainingRun>& runs, const std::vector<TrainingRecord>& records,
              Direction& law, const FitSettings& settings, const std::function<void(int, double)>& progress) {
  Problem problem(p, runs, records, law, settings);
  FitReport report;
  Eigen::VectorXd x = problem.start(), f(problem.values());
  problem(x, f);
  report.cost_before = 0.5 * f.squaredNorm();
  Eigen::NumericalDiff<Problem> numeric(problem, 1e-5);
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Problem>> lm(numeric);
  lm.parameters.maxfev = settings.evaluations;
  lm.parameters.ftol = 2e-4;
  lm.parameters.xtol = 1e-4;
  lm.parameters.factor = 1;
  auto status = settings.evaluations > 0 ? lm.minimizeInit(x) : Eigen::LevenbergMarquardtSpace::UserAsked;
  while (status == Eigen::LevenbergMarquardtSpace::Running || status == Eigen::LevenbergMarquardtSpace::NotStarted) {
    status = lm.minimizeOneStep(x);
    if (progress) progress(static_cast<int>(lm.nfev), 0.5 * lm.fnorm * lm.fnorm);
    if (lm.iter > 60) break;
  }
  report.evaluations = static_cast<int>(lm.nfev);
  problem(x, f);
  report.cost_after = 0.5 * f.squaredNorm();
  if (settings.evaluations > 0) law = problem.law_at(x);
  const auto fitted = std::make_shared<const Direction>(law);
  for (const Way& w : problem.ways())
    windows_of(w, *runs[w.run].ground, law.radius, drive(w, *runs[w.run].ground, fitted, settings.wheel),
               report.windows);
  set_spread(report.windows, runs, law);
  set_noise(problem, law, settings.wheel, report.sd_ratio);
  return report;
}

Comparison compare(const TrainingPlan& p, const TrainingRun& r, const TrainingRecord& record, const Direction& law,
                   const DirectionSettings& settings, double share) {
  const Way w = way_of(0, p, r, record);
  const auto shared = std::make_shared<const Direction>(law);
  const std::clock_t begin = std::clock();
  const Trace t = drive(w, *r.ground, shared, settings);
  Comparison c;
  c.law_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  c.seconds = w.t.back() - w.t.front();
  c.load = r.load;
  c.slip = r.slips.empty() ? 0 : r.slips.back();
  c.x_to = w.x.back();
  c.x_from = w.x.back() - share * r.distance;
  std::array<std::vector<double>, 8> v;
  for (std::size_t i = 0; i < w.t.size(); ++i) {
    if (w.x[i] < c.x_from) continue;
    const double h = r.ground->height(w.x[i], 0) + p.radius;
    const std::array<double, 8> now{w.z[i] - h, w.fx[i], -w.torque[i], w.fz[i],
                                    t.z[i] - h, t.fx[i], t.torque[i],  t.fz[i]};
    for (std::size_t k = 0; k < now.size(); ++k) v[k].push_back(now[k]);
  }
  for (std::size_t k = 0; k < 4; ++k) {
    for (const double x : v[k]) c.grains[k] += x / static_cast<double>(v[k].size());
    for (const double x : v[k + 4]) c.law[k] += x / static_cast<double>(v[k].size());
    c.grains_sd[k] = deviation(v[k]);
    c.law_sd[k] = deviation(v[k + 4]);
  }
  std::map<std::int64_t, std::pair<double, double>> seen;
  for (std::size_t k = 0; k < record.profile_sample.size(); ++k)
    for (int i = 0; i < TrainingRecord::kColumns; ++i) {
      const double h = record.profile[k * TrainingRecord::kColumns + static_cast<std::size_t>(i)];
      if (!std::isfinite(h)) continue;
      seen.try_emplace(record.profile_column[k] + i, h, h).first->second.second = h;
    }
  double sum = 0;
  int n = 0;
  for (const auto& [column, h] : seen) {
    const double x = (static_cast<double>(column) + 0.5) * p.column;
    if (x > w.x.back() - 40e-3 || x < r.start + 20e-3) continue;
    const double surface = t.wheel->surface(x);
    if (!std::isfinite(surface)) continue;
    const double off = surface - r.ground->height(x, 0) - (h.second - h.first);
    sum += off * off;
    ++n;
  }
  c.profile_rms = n > 0 ? std::sqrt(sum / n) : std::nan("");
  const Rut& rut = t.wheel->rut();
  double fresh = 0;
  for (std::size_t i = 0; i < rut.size(); ++i)
    fresh += r.ground->height(rut.place(i), 0) + law.at(Coefficient::surface);
  c.drift = rut.volume() - fresh * rut.column();
  c.outside =
      t.wheel->steps() > 0 ? static_cast<double>(t.wheel->outside()) / static_cast<double>(t.wheel->steps()) : 0;
  return c;
}

}  // namespace grouser::sdem
