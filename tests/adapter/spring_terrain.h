#pragma once
// The simplest soil there is, so that every expected value is known: a one-sided spring-damper on the body's origin, and if asked for a
// stick spring along x and y and a torsional one on the spin. Undisturbed surface z = 0.
#include "grouser/terrain/terrain.h"

namespace grouser {

struct SpringSoil {
  double k = 0, c = 0;    ///< [N/m], [N s/m] normal
  double kt = 0, ct = 0;  ///< [N/m], [N s/m] tangential, bound to the origin
  bool linearises = true;
  bool anti_restoring = false;  ///< reports its stiffness with the wrong sign
};

class SpringTerrain final : public Terrain {
 public:
  explicit SpringTerrain(SpringSoil s) : Terrain(flat_ground()), s_(s) {}
  std::string id() const override { return "test.spring"; }
  Capabilities capabilities() const override {
    Capabilities c;
    c.linearises = s_.linearises;
    return c;
  }
  std::vector<BodyMotion> seen;  ///< motions of the last step, for tests of what the adapter hands over

 protected:
  void do_step(const StepContext& c, std::span<const BodyMotion> m, std::span<BodyResult> r) override {
    if (c.commit) seen.assign(m.begin(), m.end());
    for (std::size_t i = 0; i < m.size(); ++i) {
      r[i] = {};
      const Vec3 &p = m[i].X_WB_end.p, &v = m[i].V_WB_end.v;
      if (p.z() >= 0) continue;
      const Vec3 f(-s_.kt * p.x() - s_.ct * v.x(), -s_.kt * p.y() - s_.ct * v.y(), -s_.k * p.z() - s_.c * v.z());
      r[i].impulse = c.dt * f;
      r[i].report.in_contact = true;
      r[i].report.sinkage = -p.z();
      r[i].report.force_W = f;
      r[i].report.point_W = p;
      if (!s_.linearises) continue;
      Linearisation L;
      const double sign = s_.anti_restoring ? -1 : 1;
      L.dF_dx.diagonal().head<3>() = -sign * Vec3(s_.kt, s_.kt, s_.k);
      L.dF_dv.diagonal().head<3>() = -Vec3(s_.ct, s_.ct, s_.c);
      r[i].linearisation = L;
    }
  }
  void do_traverse(State&) override {}

 private:
  SpringSoil s_;
};

}  // namespace grouser
