#include "profile.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>

namespace grouser::diagnosis {
namespace {

constexpr int iterations = 40, smallest_part = 8;
constexpr double close_enough = 0.02;

/// The candidate with one amplitude held, refitted along that amplitude.
class HeldRefit {
 public:
  HeldRefit(const Search& s, const Candidate& c, const Fit& f, std::size_t term)
      : s_(s), held_(c), best_(f), at_(s.series().soil_parameters() + static_cast<Eigen::Index>(term)) {
    held_.terms.erase(held_.terms.begin() + static_cast<std::ptrdiff_t>(term));
    held_.held.push_back({c.terms[term].input, 0});
    if (c.terms[term].sd > 0) precision_ = 1 / (c.terms[term].sd * c.terms[term].sd);
    const Eigen::MatrixXd V = s.covariance(f);
    sd_ = std::sqrt(std::max(V(at_, at_), 1e-300));
    turn_ = without(V.col(at_)) / std::max(V(at_, at_), 1e-300);
    begin();
  }
  double sd() const { return sd_; }
  double value() const { return best_.x[at_]; }
  /// Back to the fit itself: the other side.
  void begin() { from_ = {value(), without(best_.x), best_.theta}; }

  /// Root of the rise of the objective at amplitude `a`; NaN where the model has no answer.
  /// Begins where the last one ended; where that has no answer, or rises far more than the slope foretells, with smaller steps and from other places.
  double rise(double a) {
    Fit best = at(a, from_.x + turn_ * (a - from_.a), from_.theta);
    const double foretold = std::abs(a - value()) / sd_;
    if (!best.ok || root(best, a) > 1.5 * foretold + 0.5) {
      keep(at(a, from_.x, from_.theta), a, best);
      keep(at(a, without(best_.x), best_.theta), a, best);
      for (int parts = 2; parts <= smallest_part && !best.ok; parts *= 2) keep(in_parts(a, parts), a, best);
    }
    const Series& series = s_.series();
    if (series.layout().size() < 150) {  // few rows have many minima
      Eigen::VectorXd x = from_.x;
      x.head(series.soil_parameters()) = series.prior_mean();
      keep(at(a, x, best_.theta), a, best);
      for (int i = 0; i < series.soil_parameters(); ++i)
        for (const double side : {-1.0, 1.0}) {
          x = from_.x;
          x[i] = series.parameter(i).mean + side * series.parameter(i).sd;
          keep(at(a, x, from_.theta), a, best);
        }
    }
    if (!best.ok) return std::numeric_limits<double>::quiet_NaN();
    from_ = {a, best.x, best.theta};
    return root(best, a);
  }

 private:
  struct Point {
    double a = 0;
    Eigen::VectorXd x;
    std::vector<double> theta;
  };
  Eigen::VectorXd without(const Eigen::VectorXd& x) const {
    Eigen::VectorXd y(x.size() - 1);
    y << x.head(at_), x.tail(x.size() - 1 - at_);
    return y;
  }
  Fit at(double a, const Eigen::VectorXd& start, const std::vector<double>& theta) {
    held_.held.back().value = a;
    return s_.series().fit(held_, s_.whitener(), start, theta, iterations);
  }
  Fit in_parts(double a, int parts) {
    Point p = from_;
    Fit f;
    for (int i = 1; i <= parts; ++i) {
      const double next = from_.a + (a - from_.a) * i / parts;
      f = at(next, p.x, p.theta);
      if (!f.ok) return f;
      p = {next, f.x, f.theta};
    }
    return f;
  }
  double root(const Fit& f, double a) const {
    return std::sqrt(std::max(f.objective() + precision_ * a * a - best_.objective(), 0.0));
  }
  void keep(Fit f, double a, Fit& best) const {
    if (f.ok && (!best.ok || root(f, a) < root(best, a))) best = std::move(f);
  }

  const Search& s_;
  Candidate held_;
  const Fit& best_;
  Eigen::Index at_;
  double precision_ = 0, sd_ = 0;
  Eigen::VectorXd turn_;
  Point from_;
};

}  // namespace

std::array<double, 2> profile_interval(const Search& s, const Candidate& c, const Fit& f, std::size_t term) {
  HeldRefit held(s, c, f, term);
  const double best = held.value();
  const double t = boost::math::quantile(boost::math::students_t(s.noise_dof(static_cast<double>(f.x.size()))), 0.95);
  std::array<double, 2> ends{};
  for (const int side : {0, 1}) {
    held.begin();
    const double sign = side == 0 ? -1 : 1, bound = side == 0 ? c.terms[term].lower : c.terms[term].upper;
    double low = 0, low_rise = 0, high = t * held.sd(), high_rise = 0;  // distances from the best
    double room = std::max(sign * (bound - best), 0.0);
    bool closed = false;
    for (int k = 0; k < 10 && !closed && room > 0; ++k) {
      const double reach = std::min(high, room);
      const double z = held.rise(best + sign * reach);
      if (std::isnan(z)) {  // no wheel carries the load there: physics ends before the bound does
        room = reach;
        high = 0.5 * (low + reach);
        continue;
      }
      if (z >= t || reach >= room) {
        high = reach, high_rise = z, closed = true;
      } else {
        low = reach, low_rise = z;
        high = reach * std::clamp(1.05 * t / std::max(z, 0.1), 1.2, 3.0);
      }
    }
    auto& end = ends[static_cast<std::size_t>(side)];
    if (!closed || high_rise < t) {
      end = best + sign * (closed ? room : low);
      continue;
    }
    for (int k = 0; k < 6 && std::abs(high_rise - t) > close_enough; ++k) {
      const double x = low + (high - low) * (t - low_rise) / (high_rise - low_rise), z = held.rise(best + sign * x);
      if (std::isnan(z)) break;
      (z >= t || std::abs(z - t) < close_enough ? high : low) = x;
      (z >= t || std::abs(z - t) < close_enough ? high_rise : low_rise) = z;
    }
    end = best + sign * high;
  }
  return ends;
}

}  // namespace grouser::diagnosis
