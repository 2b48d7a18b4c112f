#include "refit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace blind {
namespace {

constexpr double kFurthest = 12.0;

// Bounds of the scaled soil, then of the amplitude.
struct Box {
  Eigen::VectorXd low, high;
};

Box box_of(const Priors& priors, std::optional<Id> extra) {
  const int p = kSoilParameters + (extra ? 1 : 0);
  Box box{Eigen::VectorXd::Constant(p, -kFurthest), Eigen::VectorXd::Constant(p, kFurthest)};
  box.low[2] = std::max(box.low[2], -priors.centre.c / priors.sd[2]);
  box.low[5] = (0.01 - priors.centre.a0) / priors.sd[5];
  box.high[5] = (0.9 - priors.centre.a0) / priors.sd[5];
  if (extra) std::tie(box.low[kSoilParameters], box.high[kSoilParameters]) = bounds(*extra);
  return box;
}

struct Linear {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;  // of half the cost
  double chi2 = 0, penalty = 0;
  double cost() const { return chi2 + penalty; }
};

class Problem {
 public:
  Problem(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& rows, const Amplitudes& x,
          std::optional<Id> extra)
      : wheel_(wheel), priors_(priors), rows_(rows), x_(x), extra_(extra), entry_(rows.size(), 0.5) {}

  Eigen::Index size() const { return kSoilParameters + (extra_ ? 1 : 0); }

  Amplitudes amplitudes(const Eigen::VectorXd& p) const {
    Amplitudes x = x_;
    if (extra_) x[*extra_] = p[kSoilParameters];
    return x;
  }

  Linear linearise(const Eigen::VectorXd& p) {
    Linear out{Eigen::MatrixXd::Zero(size(), size()), Eigen::VectorXd::Zero(size())};
    const Amplitudes x = amplitudes(p);
    const SoilVector u = p.head<kSoilParameters>();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Slopes s = slopes(wheel_, priors_, u, x, rows_[i].run, extra_, entry_[i]);
      entry_[i] = s.entry;
      const Eigen::Vector3d left = s.y - rows_[i].y;
      const Eigen::Matrix<double, 3, Eigen::Dynamic> weighted = rows_[i].weight * s.by;
      out.hessian += s.by.transpose() * weighted;
      out.gradient += weighted.transpose() * left;
      out.chi2 += left.dot(rows_[i].weight * left);
    }
    out.penalty = u.squaredNorm();
    out.hessian.topLeftCorner<kSoilParameters, kSoilParameters>() +=
        Eigen::MatrixXd::Identity(kSoilParameters, kSoilParameters);
    out.gradient.head<kSoilParameters>() += u;
    return out;
  }

  // chi2 + |u|^2; infinite where there is no wheel.
  double cost(const Eigen::VectorXd& p) {
    const Amplitudes x = amplitudes(p);
    const Soil soil = soil_of(priors_, p.head<kSoilParameters>());
    double out = p.head<kSoilParameters>().squaredNorm();
    try {
      for (std::size_t i = 0; i < rows_.size(); ++i) {
        const double entry = entry_angle(wheel_, soil, x, rows_[i].run, entry_[i]);
        const Eigen::Vector3d left = vector_of(at_entry(wheel_, soil, x, rows_[i].run, entry).y) - rows_[i].y;
        out += left.dot(rows_[i].weight * left);
      }
    } catch (const std::runtime_error&) {
      return std::numeric_limits<double>::infinity();
    }
    return out;
  }

 private:
  const Wheel& wheel_;
  const Priors& priors_;
  const std::vector<Observation>& rows_;
  Amplitudes x_;
  std::optional<Id> extra_;
  std::vector<double> entry_;
};

// Step with damping; parameters at a bound that push outwards stay there.
Eigen::VectorXd damped_step(const Linear& at, const Eigen::VectorXd& p, const Box& box, double damping) {
  Eigen::MatrixXd h = at.hessian;
  Eigen::VectorXd g = at.gradient;
  h.diagonal() *= 1.0 + damping;
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const bool held = (p[i] <= box.low[i] && g[i] > 0) || (p[i] >= box.high[i] && g[i] < 0);
    if (!held) continue;
    h.row(i).setZero();
    h.col(i).setZero();
    h(i, i) = 1.0;
    g[i] = 0.0;
  }
  const Eigen::VectorXd moved = p - h.ldlt().solve(g);
  return moved.cwiseMax(box.low).cwiseMin(box.high);
}

}  // namespace

SoilVector scaled(const Priors& priors, const Soil& soil) {
  const Soil& m = priors.centre;
  SoilVector u;
  u << std::log(soil.k / m.k), soil.n - m.n, soil.c - m.c, soil.phi - m.phi, std::log(soil.K / m.K), soil.a0 - m.a0,
      soil.a1 - m.a1;
  return u.cwiseQuotient(priors.sd);
}

Soil soil_of(const Priors& priors, const SoilVector& u) {
  const Soil& m = priors.centre;
  const SoilVector v = u.cwiseProduct(priors.sd);
  return {m.k * std::exp(v[0]), m.n + v[1], std::max(m.c + v[2], 0.0), m.phi + v[3], m.K * std::exp(v[4]),
          m.a0 + v[5],          m.a1 + v[6]};
}

Eigen::Vector3d vector_of(const Channels& y) { return {y.drawbar, y.torque, y.sinkage}; }

std::vector<Observation> grouped(const std::vector<Observation>& rows, unsigned uses) {
  using Key = std::tuple<double, double, double, int, double, double, double>;
  std::map<Key, std::vector<const Observation*>> cells;
  for (const Observation& o : rows) {
    const Condition& r = o.run;
    cells[{r.slip, r.load, uses & uses_speed ? r.omega : 0.0, uses & uses_pass ? r.pass : 0,
           uses & uses_order ? r.order_share : 0.0, r.ln_k_shift, r.phi_shift}]
        .push_back(&o);
  }
  std::vector<Observation> out;
  for (auto& [key, members] : cells) {
    // A fixed order of the sum, whatever the order of the rows.
    std::sort(members.begin(), members.end(), [](const Observation* a, const Observation* b) {
      return std::tie(a->y[0], a->y[1], a->y[2]) < std::tie(b->y[0], b->y[1], b->y[2]);
    });
    Observation sum{members.front()->run, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
    for (const Observation* o : members) {
      sum.weight += o->weight;
      sum.y += o->weight * o->y;
    }
    sum.y = sum.weight.ldlt().solve(sum.y).eval();
    out.push_back(sum);
  }
  return out;
}

Slopes slopes(const Wheel& wheel, const Priors& priors, const SoilVector& u, const Amplitudes& x, const Condition& run,
              std::optional<Id> extra, double guess) {
  const Soil soil = soil_of(priors, u);
  Slopes out;
  out.entry = entry_angle(wheel, soil, x, run, guess);
  const AtEntry base = at_entry(wheel, soil, x, run, out.entry);
  const double turn = 1e-6;
  const AtEntry turned = at_entry(wheel, soil, x, run, out.entry + turn);
  out.y = vector_of(base.y);
  const Eigen::Vector3d by_entry = (vector_of(turned.y) - out.y) / turn;
  const double stiffness = (turned.excess - base.excess) / turn;
  const int columns = kSoilParameters + (extra ? 1 : 0);
  out.by.resize(3, columns);
  for (int p = 0; p < columns; ++p) {
    double step = 1e-5;
    AtEntry moved{};
    if (p < kSoilParameters) {
      SoilVector v = u;
      v[p] += step;
      moved = at_entry(wheel, soil_of(priors, v), x, run, out.entry);
    } else {
      Amplitudes more = x;
      step = 1e-5 * effect(*extra).typical;
      more[*extra] += step;
      moved = at_entry(wheel, soil, more, run, out.entry);
    }
    const double entry_shift = -(moved.excess - base.excess) / step / stiffness;
    out.by.col(p) = (vector_of(moved.y) - out.y) / step + by_entry * entry_shift;
  }
  return out;
}

std::pair<double, double> bounds(Id id) {
  const Effect& e = effect(id);
  return {e.signs == 1 ? 0.0 : -e.high, e.signs == -1 ? 0.0 : e.high};
}

Refit refit(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& rows, const SoilVector& start,
            const Amplitudes& x, std::optional<Id> extra) {
  Problem problem(wheel, priors, rows, x, extra);
  const Box box = box_of(priors, extra);
  Eigen::VectorXd p(problem.size());
  p.head<kSoilParameters>() = start;
  if (extra) p[kSoilParameters] = x[*extra];
  p = p.cwiseMax(box.low).cwiseMin(box.high);
  Linear at = problem.linearise(p);
  double damping = 1e-3;
  int iteration = 0;
  for (; iteration < 60; ++iteration) {
    const Eigen::VectorXd next = damped_step(at, p, box, damping);
    const double cost = problem.cost(next);
    if (!(cost <= at.cost())) {
      damping = std::max(damping * 8.0, 1e-4);
      if (damping > 1e8) break;
      continue;
    }
    const double gained = at.cost() - cost;
    p = next;
    at = problem.linearise(p);
    damping = std::max(damping / 10.0, 1e-9);
    if (gained < 1e-5 + 1e-7 * at.cost()) break;
  }
  return {p.head<kSoilParameters>(), problem.amplitudes(p), at.chi2, at.penalty, iteration};
}

double unabsorbed(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noise_free,
                  const SoilVector& truth) {
  const std::vector<Observation> rows = grouped(noise_free, uses_none);
  // What averaging over runs of one nominal condition leaves out is never absorbed.
  double within = 0;
  for (const Observation& o : noise_free) within += o.y.dot(o.weight * o.y);
  for (const Observation& o : rows) within -= o.y.dot(o.weight * o.y);
  const Refit a = refit(wheel, priors, rows, truth), b = refit(wheel, priors, rows, SoilVector::Zero());
  const Refit& best = a.chi2 + a.penalty <= b.chi2 + b.penalty ? a : b;
  return std::sqrt(std::max(best.chi2 + within, 0.0));
}

}  // namespace blind
