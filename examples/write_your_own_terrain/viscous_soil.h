#pragma once
// A terrain of your own: one class and one line in a registry. Soil that carries like a spring and drags like syrup:
//
//   f_z = max(0, k d - c v_z),   f_t = -drag d v_t,   t_y = -drag d r^2 w_y        d: depth of the wheel's lowest point [m]
#include <algorithm>

#include "grouser/terrain/registry.h"
#include "grouser/terrain/terrain.h"

struct ViscousSoil final : grouser::Terrain {
  double k, c, drag;  // [N/m], [N s/m], [N s/m^2]

  ViscousSoil(grouser::GroundPtr g, double k_, double c_, double drag_)
      : Terrain(std::move(g)), k(k_), c(c_), drag(drag_) {}
  std::string id() const override { return "example.viscous"; }
  grouser::Capabilities capabilities() const override {
    return {};
  }  // no memory, linearises, force is a function of the motion

 protected:
  // Called with checked arguments. commit is false when somebody only wants to know: then leave state and ledger alone.
  void do_step(const StepContext& ctx, std::span<const grouser::BodyMotion> motions,
               std::span<grouser::BodyResult> results) override {
    for (std::size_t i = 0; i < motions.size(); ++i) {
      grouser::BodyResult& out = results[i] = {};  // zero unless in contact
      const grouser::Pose X_WG = motions[i].X_WB_end * bodies()[i].X_BG;
      const double r = bodies()[i].gear.radius();
      const double depth = std::max(0.0, ground().height(X_WG.p.x(), X_WG.p.y()) + r - X_WG.p.z());

      const grouser::Vec3 v = motions[i].V_WB_end.v;
      const double spring = k * depth,
                   normal = depth > 0 ? std::max(0.0, spring - c * v.z()) : 0;  // ground pushes, never pulls
      const grouser::Vec3 f(-drag * depth * v.x(), -drag * depth * v.y(), normal);
      const double spin = motions[i].V_WB_end.w.y(), torque = -drag * depth * r * r * spin;
      out.impulse = ctx.dt * f;  // about the body's origin, W frame
      out.angular_impulse = {0, ctx.dt * torque, 0};
      out.report.in_contact = depth > 0;
      out.report.sinkage = depth;
      out.report.normal_force = normal;
      out.report.force_W = f;

      // Derivatives of what stands above: with them a stiff soil needs no small time step.
      grouser::Linearisation l;
      if (normal > 0) l.dF_dx(2, 2) = -k;
      if (normal > 0) l.dF_dv(2, 2) = -c;
      l.dF_dv(0, 0) = l.dF_dv(1, 1) = -drag * depth;
      l.dF_dv(4, 4) = -drag * depth * r * r;
      if (depth > 0) out.linearisation = l;

      // Ledger: energy held by springs now, and lost power from the local rates (not from what is left over).
      if (!ctx.commit) continue;
      ledger().stored += 0.5 * k * (depth * depth - last_depth_[i] * last_depth_[i]);
      ledger().dissipated += ctx.dt * ((spring - normal) * v.z() - f.x() * v.x() - f.y() * v.y() - torque * spin);
      last_depth_[i] = depth;
    }
  }
  void do_add_body(const grouser::BodySpec&) override { last_depth_.push_back(0); }
  // Everything do_step reads from the past. One function saves, loads, compares and hashes it.
  void do_traverse(grouser::State& s) override { s.field("last_depth", last_depth_); }

 private:
  std::vector<double> last_depth_;
};
