#include "grouser/dem/soil_config.h"

#include <array>

namespace grouser::dem {

namespace {

/// Keys of a map that may leave out what is known already.
class Reader {
 public:
  Reader(ConfigNode node, bool partial) : node_(std::move(node)), partial_(partial) {}
  void value(const char* key, double& x, const char* unit, Range range, bool optional = false) const {
    if (partial_ || optional)
      x = node_.quantity_or(key, x, unit, range);
    else
      x = node_.quantity(key, unit, range);
  }
  template <class E, std::size_t N>
  void one_of(const char* key, E& x, const std::array<std::pair<const char*, E>, N>& names, bool optional) const {
    std::vector<std::string> allowed;
    std::string now;
    for (const auto& [name, e] : names) {
      allowed.push_back(name);
      if (e == x) now = name;
    }
    const std::string chosen = partial_ || optional ? node_.choice_or(key, now, allowed) : node_.choice(key, allowed);
    for (const auto& [name, e] : names)
      if (chosen == name) x = e;
  }
  bool wanted(const char* key) const { return !partial_ || node_.has(key); }
  const ConfigNode& node() const { return node_; }

 private:
  ConfigNode node_;
  bool partial_;
};

constexpr std::array<std::pair<const char*, ContactModel>, 2> models{
    {{"hertz-ch4", ContactModel::hertz_ch4}, {"hertz-ch3", ContactModel::hertz_ch3}}};
constexpr std::array<std::pair<const char*, RollingCoefficient>, 3> rolling_laws{
    {{"constant", RollingCoefficient::constant},
     {"rate", RollingCoefficient::rate},
     {"rate_without_spin", RollingCoefficient::rate_without_spin}}};
constexpr std::array<std::pair<const char*, Cap>, 2> caps{{{"sum", Cap::sum}, {"springs", Cap::springs}}};
constexpr std::array<std::pair<const char*, TangentialStiffness>, 2> stiffnesses{
    {{"mindlin", TangentialStiffness::mindlin}, {"printed", TangentialStiffness::printed}}};
constexpr std::array<std::pair<const char*, Damping>, 2> dampings{
    {{"implicit", Damping::implicit_}, {"explicit", Damping::explicit_}}};
constexpr std::array<std::pair<const char*, Precision>, 2> precisions{
    {{"single", Precision::single}, {"double", Precision::full}}};

const Range friction_range = Range::between(0, 10);
const Range restitution_range{0, 1, true, false};

const char* rolling_unit(RollingCoefficient law) { return law == RollingCoefficient::constant ? "1" : "s^2/m^2"; }

}  // namespace

SoilSettings read_soil(const ConfigNode& node, const SoilSettings* base) {
  SoilSettings s = base ? *base : SoilSettings();
  if (!base) s.bulk_density = 0;
  const Reader in(node, base != nullptr);
  if (in.wanted("diameter")) {
    const std::vector<double> d = node.quantities("diameter", "m", 2, Range::positive());
    if (d.size() == 2) {
      s.smallest = d[0];
      s.largest = d[1];
      if (d[0] > d[1]) node.error_at("diameter", "the smallest diameter comes first");
    }
  }
  in.value("density", s.density, "kg/m^3", Range::positive());
  in.value("bulk_density", s.bulk_density, "kg/m^3", Range::positive(), true);
  Material& m = s.materials.materials[0];
  in.value("young_modulus", m.young, "Pa", Range::positive());
  in.value("poisson_ratio", m.poisson, "1", {0, 0.5, false, true});
  s.materials.materials[1].young = m.young;
  s.materials.materials[1].poisson = m.poisson;
  in.one_of("model", s.law.model, models, true);
  PairProperties& p = s.materials.pair(0, 0);
  in.value("friction", p.friction, "1", friction_range);
  in.value("restitution", p.restitution, "1", restitution_range);
  in.value("cohesion", p.cohesion, "J/m^3", Range::non_negative(), true);
  if (in.wanted("rolling")) {
    const ConfigNode r = node.map("rolling");
    Reader(r, false).one_of("law", s.law.rolling, rolling_laws, false);
    p.rolling = r.quantity("coefficient", rolling_unit(s.law.rolling), Range::non_negative());
    r.finish();
  }
  if (in.wanted("wall")) {
    const ConfigNode w = node.map("wall");
    const Reader wall(w, base != nullptr);
    for (const int a : {0, 1}) {
      PairProperties& q = s.materials.pair(a, 1);
      wall.value("friction", q.friction, "1", friction_range);
      wall.value("restitution", q.restitution, "1", restitution_range);
      wall.value("rolling_coefficient", q.rolling, rolling_unit(s.law.rolling), Range::non_negative(), true);
    }
    w.finish();
  }
  if (s.law.model == ContactModel::hertz_ch3) {
    const Range r = Range::non_negative();
    in.value("normal_stiffness", p.kn, "Pa", Range::positive());
    in.value("shear_stiffness", p.kt, "Pa", r);
    in.value("gamma_n", p.gamma_n, "1/(m s)", r);
    in.value("gamma_t", p.gamma_t, "1/(m s)", r);
    for (const int a : {0, 1}) {
      PairProperties& q = s.materials.pair(a, 1);
      q.kn = p.kn;
      q.kt = p.kt;
      q.gamma_n = p.gamma_n;
      q.gamma_t = p.gamma_t;
    }
  }
  if (node.has("wheel")) {
    // What it does not name is as between two grains.
    const ConfigNode w = node.map("wheel");
    const Reader wheel(w, true);
    PairProperties q = s.wheel.value_or(p);
    wheel.value("friction", q.friction, "1", friction_range);
    wheel.value("restitution", q.restitution, "1", restitution_range);
    wheel.value("rolling_coefficient", q.rolling, rolling_unit(s.law.rolling), Range::non_negative());
    wheel.value("cohesion", q.cohesion, "J/m^3", Range::non_negative());
    w.finish();
    s.wheel = q;
  }
  in.one_of("cap", s.law.cap, caps, true);
  in.one_of("tangential_stiffness", s.law.tangential, stiffnesses, true);
  in.one_of("damping", s.law.damping, dampings, true);
  node.finish();
  return s;
}

void read_law(const ConfigNode& node, LawSettings& law) {
  const Reader in(node, true);
  in.one_of("model", law.model, models, true);
  in.one_of("rolling", law.rolling, rolling_laws, true);
  in.one_of("cap", law.cap, caps, true);
  in.one_of("tangential_stiffness", law.tangential, stiffnesses, true);
  in.one_of("damping", law.damping, dampings, true);
  node.finish();
}

void read_solver(const ConfigNode& node, SoilSettings& soil) {
  if (!node.present()) return;
  const ConfigNode step = node.node("time_step");
  if (step.present() && step.is_scalar() && step.as_text() == "auto") {
    if (soil.law.model != ContactModel::hertz_ch4)
      node.error_at("time_step", "'auto' is known for hertz-ch4 only; give the step in seconds");
    soil.dt_share = node.quantity_or("step_share", kStepShare, "1", {0, 0.5, true, false});
  } else {
    if (node.has("time_step")) soil.dt_share = 0;
    soil.dt = node.quantity_or("time_step", soil.dt, "s", Range::positive());
    if (node.has("step_share")) node.error_at("step_share", "goes with 'time_step: auto' only");
  }
  Reader(node, true).one_of("precision", soil.precision, precisions, true);
  node.finish();
}

}  // namespace grouser::dem
