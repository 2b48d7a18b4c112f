#include "soil_test_next.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "chance.h"
#include "shares.h"

namespace grouser::diagnosis {
namespace {

constexpr double rest_way = 0.66e-3;  // [m] sheared in the time of the rest
constexpr std::size_t shown = 4;

struct Choice {
  SoilTestCondition condition;
  int repeats = 0;
  double chance = 0, cost = 0;
};

std::vector<Choice> possible(const SoilTestFits& fits) {
  std::set<double> pressures{2000, 6000, 18000}, shear_speeds{1e-4, 6.6e-4, 2e-3, 6.6e-3, 2e-2},
      plate_speeds{2e-3, 1e-2, 5e-2};
  std::array<std::set<double>, 2> had;
  std::set<double> had_pressures;
  for (const SoilTestValues& v : fits.values()) {
    const bool shear = v.condition.kind == SoilTestKind::shear;
    had[shear ? 0 : 1].insert(v.condition.speed);
    (shear ? shear_speeds : plate_speeds).insert(v.condition.speed);
    if (shear) had_pressures.insert(v.condition.normal_stress), pressures.insert(v.condition.normal_stress);
  }
  std::vector<Choice> out;
  for (const double p : pressures)
    for (const double v : shear_speeds) {
      Choice c;
      c.condition.kind = SoilTestKind::shear, c.condition.normal_stress = p, c.condition.speed = v;
      c.condition.rest = rest_way / v;
      c.cost = (had_pressures.count(p) ? 0 : 2) + (had[0].count(v) ? 0 : 2);
      out.push_back(c);
    }
  for (const double v : plate_speeds) {
    Choice c;
    c.condition.kind = SoilTestKind::plate, c.condition.speed = v, c.cost = had[1].count(v) ? 0 : 2;
    out.push_back(c);
  }
  return out;
}

/// Mean and spread over a member's draws. False: outside the stored runs.
bool say(const SoilTestFits& fits, const SoilTestMember& m, const SoilTestCondition& c, Eigen::VectorXd& mean,
         Eigen::MatrixXd& spread) {
  const Eigen::MatrixXd& x = m.posterior->draws;
  std::vector<Eigen::VectorXd> y;
  Eigen::MatrixXd error, sum_error;
  for (Eigen::Index k = 0; k < x.cols(); ++k) {
    y.push_back(fits.predict(*m.account, x.col(k), c, &error));
    if (y.back().size() == 0) {
      y.pop_back();
      continue;
    }
    sum_error = y.size() == 1 ? error : Eigen::MatrixXd(sum_error + error);
  }
  const double n = static_cast<double>(y.size());
  if (n < 0.95 * static_cast<double>(x.cols())) return false;
  mean = Eigen::VectorXd::Zero(y[0].size());
  for (const Eigen::VectorXd& v : y) mean += v / n;
  spread = sum_error / n;
  for (const Eigen::VectorXd& v : y) spread += (v - mean) * (v - mean).transpose() / n;
  return true;
}

}  // namespace

std::vector<NextExperiment> next_soil_tests(const SoilTestFits& fits, const std::vector<SoilTestMember>& members) {
  if (members.size() < 2) return {};
  std::vector<double> ln_prior;
  for (const SoilTestMember& m : members) ln_prior.push_back(m.ln_prior);
  std::vector<Choice> choices;
  for (Choice c : possible(fits)) {
    std::vector<Eigen::VectorXd> mean(members.size());
    std::vector<Eigen::MatrixXd> spread(members.size());
    bool good = true;
    for (std::size_t i = 0; i < members.size() && good; ++i)
      good = say(fits, members[i], c.condition, mean[i], spread[i]);
    if (!good) continue;
    for (const int n : {2, 4, 8}) {
      std::vector<Eigen::MatrixXd> covariance = spread;
      for (Eigen::MatrixXd& C : covariance)
        C += fits.repeat_scatter(c.condition.kind) / n + fits.fixed_scatter(c.condition.kind);
      c.repeats = n;
      c.chance = chance_to_decide(mean, covariance, ln_prior, decisive,
                                  [](std::size_t m, std::size_t truth) { return m == truth; });
      if (c.chance >= enough) break;
    }
    c.cost += c.repeats;
    choices.push_back(c);
  }
  std::stable_sort(choices.begin(), choices.end(), [](const Choice& a, const Choice& b) {
    const bool x = a.chance >= enough, y = b.chance >= enough;
    if (x != y) return x;
    if (x && a.cost != b.cost) return a.cost < b.cost;
    return a.chance > b.chance;
  });
  std::vector<NextExperiment> out;
  for (std::size_t i = 0; i < std::min(shown, choices.size()); ++i) {
    const Choice& c = choices[i];
    NextExperiment e;
    e.condition = {{"normal_stress_Pa", c.condition.normal_stress}, {"speed_mm_s", c.condition.speed * 1e3}};
    if (c.condition.kind == SoilTestKind::shear) e.condition["rest_s"] = c.condition.rest;
    for (const SoilTestMember& m : members) e.decides.push_back(m.account->id);
    e.chance = c.chance, e.cost = c.cost, e.runs = c.repeats;
    out.push_back(std::move(e));
  }
  return out;
}

}  // namespace grouser::diagnosis
