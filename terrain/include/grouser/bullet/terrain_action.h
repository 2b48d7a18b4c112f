#pragma once
// Soil for a user's own Bullet world. About ten lines:
//
//   std::shared_ptr<grouser::Terrain> soil = grouser::load_terrain("terrain.yaml");
//   grouser::bullet::TerrainAction action(world, soil);
//   action.add_wheel(*wheel_body, gear, "front_left");   // once per wheel
//   world.addAction(&action);
//
// Header-only: it follows the precision (BT_USE_DOUBLE_PRECISION) of the program that includes it. Theory, order of a Bullet step, traps
// and limits: README.md beside this file.
#include <BulletDynamics/Dynamics/btActionInterface.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <LinearMath/btIDebugDraw.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "grouser/bullet/axes.h"
#include "grouser/bullet/host_body.h"
#include "grouser/bullet/implicit_step.h"
#include "grouser/bullet/mobility.h"
#include "grouser/terrain/terrain.h"

namespace grouser::bullet {

struct Options {
  UpAxis up = UpAxis::z;
  /// Use the model's linearisation (eq 1 of implicit_step.h). false: the model's impulse as it is, refused above dt * omega = 1.
  bool implicit = true;
  /// Steps between two looks at the joints (eq 2 of mobility.h); >= 1. Bodies turn little in 8 steps, and W only has to be near the truth.
  int mobility_refresh = 8;
  /// Receives each warning once; default: std::clog.
  std::function<void(const std::string&)> warn;
};

/// What the adapter adds to the terrain's ledger [J], since the start. With V the velocity after a solve:
///   terrain energy().work_on_bodies   sum of J_model . V_n                    (the model's impulse, at the velocity it was computed for)
///   implicit_correction               sum of (J_applied - J_model) . (V_n + V_n+1)/2
///   integration                       sum of J_model . ((V_n + V_n+1)/2 - V_n)
/// The three add up to the mechanical work the soil has done on Bullet's bodies, exact for the kinetic energy of the velocities after a
/// solve (`twist()`, not the body's velocity after stepSimulation, which already holds the impulse of the coming step).
/// An impulse acts in the next solve: until then its model work stands in `integration` with opposite sign.
struct AdapterEnergy {
  double implicit_correction = 0, integration = 0;
};

/// Steps a terrain with the motion of its wheels after each (sub)step of Bullet and applies the impulses.
///
/// Lives at least as long as the world uses it, and must be removed from the world (removeAction) before it dies. One thread.
/// @throws std::runtime_error from stepSimulation: wheel, stiffness, dt and remedy when dt * omega > 1 without a linearisation; wheel and
///         dt when a model's linearisation makes eq 1 singular. TerrainError from the terrain passes through.
class TerrainAction : public btActionInterface {
 public:
  TerrainAction(btDiscreteDynamicsWorld& world, std::shared_ptr<Terrain> terrain, Options options = {})
      : world_(world),
        terrain_(std::move(terrain)),
        options_(std::move(options)),
        axes_(options_.up),
        mobility_(world, axes_, options_.mobility_refresh) {
    if (!terrain_) throw std::invalid_argument("TerrainAction needs a terrain, got a null pointer");
    if (options_.mobility_refresh < 1) throw std::invalid_argument("Options::mobility_refresh must be at least 1");
    time_ = terrain_->time();
  }
  TerrainAction(const TerrainAction&) = delete;
  TerrainAction& operator=(const TerrainAction&) = delete;

  /// Before the first step. X_BG: gear frame (y = spin axis, origin = wheel centre) in Bullet's body frame.
  /// @throws TerrainError after the first step, or for a gear that the model cannot carry. Returns the wheel's index.
  int add_wheel(btRigidBody& body, RunningGear gear, std::string name,
                const btTransform& X_BG = btTransform::getIdentity()) {
    return add(HostBody(body), std::move(gear), std::move(name), X_BG);
  }
  /// link = -1 is the base.
  int add_wheel(btMultiBody& body, int link, RunningGear gear, std::string name,
                const btTransform& X_BG = btTransform::getIdentity()) {
    if (link < -1 || link >= body.getNumLinks())
      throw std::invalid_argument("wheel '" + name + "': the multibody has no link " + std::to_string(link));
    return add(HostBody(body, link), std::move(gear), std::move(name), X_BG);
  }

  int wheels() const { return static_cast<int>(wheels_.size()); }
  const std::string& name(int wheel) const { return terrain_->bodies().at(static_cast<std::size_t>(wheel)).name; }
  /// The model's answer in the last step: its own impulse, linearisation and contact report.
  const BodyResult& result(int wheel) const { return results_.at(static_cast<std::size_t>(wheel)); }
  /// Impulse really applied in the last step [N s, N m s], W.
  Wrench applied(int wheel) const {
    const Vec6& J = wheels_.at(static_cast<std::size_t>(wheel)).applied;
    return {J.head<3>(), J.tail<3>()};
  }
  /// Pose and velocity after the last solve, before the impulse of the coming step was added; W.
  const Pose& pose(int wheel) const { return wheels_.at(static_cast<std::size_t>(wheel)).X_WB; }
  const Twist& twist(int wheel) const { return wheels_.at(static_cast<std::size_t>(wheel)).V_WB; }
  const AdapterEnergy& energy() const { return energy_; }
  /// Contacts that eq 1 ended early because ground does not pull.
  std::int64_t releases() const { return releases_; }
  /// Steps in which the host was found to have moved a wheel.
  std::int64_t teleports() const { return teleports_; }
  double time() const { return time_; }
  /// Circular frequency of a wheel's contact across the surface, sqrt(-K_zz W_zz) [rad/s], root mean square over the steps in contact so
  /// far; 0 without a linearisation. Bounces are resolved while dt times it is small against 1; eq 1 damps them above.
  double contact_rate(int wheel) const {
    const Wheel& w = wheels_.at(static_cast<std::size_t>(wheel));
    return w.in_contact > 0 ? std::sqrt(w.rate_squared / static_cast<double>(w.in_contact)) : 0.0;
  }
  double terrain_seconds() const { return terrain_seconds_; }
  Terrain& terrain() const { return *terrain_; }

  /// Call after setting a wheel's velocity by hand (a moved pose is noticed without): forgets the last step's reactions.
  void reset_wheel(int wheel) { wheels_.at(static_cast<std::size_t>(wheel)).fresh = true; }

  /// Everything that the next step depends on, and the terrain. Bullet's own state is the host's to keep.
  /// @throws StateError when the wheels differ.
  void traverse(State& s) {
    const auto group = s.group("adapter");
    std::int64_t n = wheels();
    s.field("wheels", n);
    if (n != wheels())
      throw StateError("state has " + std::to_string(n) + " wheels, the adapter " + std::to_string(wheels()));
    s.field("time", time_);
    s.field("implicit_correction", energy_.implicit_correction);
    s.field("integration", energy_.integration);
    s.field("releases", releases_);
    s.field("teleports", teleports_);
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      const auto wheel_group = s.group(terrain_->bodies()[i].name);
      Wheel& w = wheels_[i];
      s.field("pose", w.X_WB);
      s.field("twist", w.V_WB);
      s.field("applied", w.applied);
      s.field("model_impulse", w.model);
      s.field("expected_change", w.expected);
      s.field("fresh", w.fresh);
      s.field("warned", w.warned);
      s.field("probed_force", w.probed_force);
      s.field("rate_squared", w.rate_squared);
      s.field("in_contact", w.in_contact);
    }
    mobility_.traverse(s, hosts_);
    terrain_->traverse(s);
  }

  void updateAction(btCollisionWorld* /*world*/, btScalar step) override {
    if (wheels_.empty()) return;
    const auto dt = static_cast<double>(step);
    const std::vector<WheelGroup>& groups = mobility_.update(hosts_, dt);
    for (const WheelGroup& g : groups)
      for (std::size_t k = 0; k < g.wheels.size(); ++k) read_motion(g.wheels[k], hub_block(g, k), dt);
    warn_held_twice();

    const auto begin = std::chrono::steady_clock::now();
    terrain_->step(time_, dt, motions_, results_);
    terrain_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    time_ += dt;

    const bool correct = !terrain_->capabilities().integrates_wheel;
    for (const WheelGroup& g : groups) answer(g, dt, correct);
  }

  /// Soil force on each wheel, 1 m per kN, at the contact point.
  void debugDraw(btIDebugDraw* drawer) override {
    if (!drawer) return;
    for (const BodyResult& r : results_)
      if (r.report.in_contact)
        drawer->drawLine(axes_.from_W(r.report.point_W), axes_.from_W(r.report.point_W + 1e-3 * r.report.force_W),
                         btVector3(1, btScalar(0.6), 0));
  }

 private:
  struct Wheel {
    Pose X_WB;
    Twist V_WB;                   ///< after the last solve
    Vec6 applied = Vec6::Zero();  ///< impulse given for the coming step
    Vec6 model = Vec6::Zero();    ///< the model's impulse
    Vec6 expected =
        Vec6::Zero();        ///< W J: change of twist that the impulses of the group should make in the coming solve
    Vec6 dv = Vec6::Zero();  ///< change of twist by everything but soil, from the last step
    bool fresh = true;       ///< no last step to learn from
    bool warned = false;
    double probed_force = 0;
    double rate_squared = 0;      ///< sum of -K_zz W_zz over the steps in contact
    std::int64_t in_contact = 0;  ///< their number
  };

  static Vec6 vector(const Twist& V) {
    Vec6 x;
    x << V.v, V.w;
    return x;
  }
  static Mat6 hub_block(const WheelGroup& g, std::size_t k) {
    const auto i = 6 * static_cast<Eigen::Index>(k);
    return g.W.block<6, 6>(i, i);
  }

  int add(HostBody host, RunningGear gear, std::string name, const btTransform& X_BG) {
    const int index = terrain_->add_body({std::move(name), std::move(gear), Axes::pose(X_BG)});
    Wheel w;
    w.X_WB = host.pose_W(axes_);
    w.V_WB = host.twist_W(axes_);
    wheels_.push_back(w);
    hosts_.push_back(host);
    motions_.emplace_back();
    results_.emplace_back();
    return index;
  }

  /// True when the pose now is not where Bullet's velocity brings it: the host has set it.
  bool moved_by_host(const Wheel& w, std::size_t i, const Pose& X, const Twist& V, double dt) const {
    const double reach = 0.1 * terrain_->bodies()[i].gear.outer_radius() + dt * V.v.norm();
    return (X.p - w.X_WB.p - dt * V.v).norm() > reach || X.q.angularDistance(w.X_WB.q) > 0.5 + 2 * dt * V.w.norm();
  }

  void read_motion(std::size_t i, const Mat6& W, double dt) {
    Wheel& w = wheels_[i];
    const HostBody& host = hosts_[i];
    host.keep_awake();
    const Pose X = host.pose_W(axes_);
    const Twist V = host.twist_W(axes_);
    BodyMotion& m = motions_[i];
    m.X_WB_begin = w.X_WB;
    if (moved_by_host(w, i, X, V, dt)) {
      m.X_WB_begin = X;
      w.fresh = true;
      ++teleports_;
    }
    m.X_WB_end = X;
    m.V_WB_end = V;
    if (w.fresh) {
      w.dv.setZero();
      if (W(2, 2) > 0) w.dv.head<3>() = dt * axes_.to_W(world_.getGravity());
      energy_.integration += w.model.dot(vector(w.V_WB));  // an impulse that no solve has used is taken back
    } else {
      const Vec6 mean = 0.5 * (vector(w.V_WB) + vector(V));
      w.dv = vector(V) - vector(w.V_WB) - w.expected;
      energy_.implicit_correction += (w.applied - w.model).dot(mean);
      energy_.integration += w.model.dot(mean);
    }
    m.hub.reset();
    if (W(2, 2) > 0) {
      HubDynamics hub;
      hub.mass = 1.0 / W(2, 2);
      hub.inertia_W = host.own_inertia_W(axes_);
      hub.non_soil.f = hub.mass / dt * w.dv.head<3>();
      hub.non_soil.t = hub.inertia_W * w.dv.tail<3>() / dt;
      m.hub = hub;
    }
    w.X_WB = X;
    w.V_WB = V;
    w.fresh = false;
  }

  void answer(const WheelGroup& g, double dt, bool correct) {
    std::vector<WheelStep> steps(g.wheels.size());
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const std::size_t i = g.wheels[k];
      const BodyResult& r = results_[i];
      WheelStep& s = steps[k];
      s.raw << r.impulse, r.angular_impulse;
      s.impulse = s.raw;
      s.v = vector(wheels_[i].V_WB);
      s.dv = wheels_[i].dv;
      const Mat6 W = hub_block(g, k);
      if (!correct || W.isZero()) continue;
      if (r.linearisation && options_.implicit) {
        s.linearised = true;
        s.K = r.linearisation->dF_dx;
        s.D = r.linearisation->dF_dv;
        if (s.K(2, 2) < 0) {
          wheels_[i].rate_squared -= s.K(2, 2) * W(2, 2);
          ++wheels_[i].in_contact;
        }
      } else if (r.linearisation) {
        refuse_above_one(i, r.linearisation->dF_dx, r.linearisation->dF_dv, W, dt, "set Options::implicit = true");
      } else if (r.report.in_contact) {
        probe(i, W, dt);
      }
    }
    if (!implicit_impulses(steps, g.W, dt)) throw std::runtime_error(singular_message(g, dt));

    Eigen::VectorXd J(6 * static_cast<Eigen::Index>(steps.size()));
    for (std::size_t k = 0; k < steps.size(); ++k) J.segment<6>(6 * static_cast<Eigen::Index>(k)) = steps[k].impulse;
    const Eigen::VectorXd expected = g.W * J;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const std::size_t i = g.wheels[k];
      Wheel& w = wheels_[i];
      w.applied = steps[k].impulse;
      w.model = steps[k].raw;
      w.expected = expected.segment<6>(6 * static_cast<Eigen::Index>(k));
      releases_ += steps[k].released;
      energy_.integration -= w.model.dot(steps[k].v);
      hosts_[i].apply(axes_, w.applied.head<3>(), w.applied.tail<3>(), g.multi ? &g.rows[k] : nullptr);
    }
  }

  void refuse_above_one(std::size_t i, const Mat6& K, const Mat6& D, const Mat6& W, double dt,
                        const char* remedy) const {
    const double ratio = explicit_step_ratio(K, D, W, dt);
    if (ratio <= 1) return;
    throw std::runtime_error(
        "wheel '" + terrain_->bodies()[i].name + "' on " + terrain_->id() + ": stiffness " + number(-K(2, 2)) +
        " N/m and damping " + number(-D(2, 2)) + " N s/m on " + number(1 / W(2, 2)) + " kg at dt = " + number(dt) +
        " s give dt * omega = " + number(ratio) + "; explicit impulses are unstable above 1: " + remedy +
        " or use dt <= " + number(dt / ratio) + " s");
  }

  /// A model without linearisation: stiffness and damping by differences of preview(), whenever the force has grown by half.
  void probe(std::size_t i, const Mat6& W, double dt) {
    if (!terrain_->capabilities().continuous) return;
    const double force = results_[i].impulse.norm() / dt;
    if (force <= 1.5 * wheels_[i].probed_force) return;
    wheels_[i].probed_force = force;
    std::vector<BodyMotion> motions = motions_;
    for (BodyMotion& m : motions) m.X_WB_begin = m.X_WB_end;
    std::vector<BodyResult> results(results_.size());
    const auto wrench = [&](const BodyMotion& trial) {
      motions[i] = trial;
      terrain_->preview(time_, dt, motions, results);
      Vec6 f;
      f << results[i].impulse, results[i].angular_impulse;
      return Vec6(f / dt);
    };
    const BodyMotion here = motions[i];
    const Vec6 F = wrench(here);
    Mat6 K, D;
    for (int c = 0; c < 6; ++c) {
      constexpr double h = 1e-6;  // [m], [rad], [m/s], [rad/s]
      const Vec3 step = h * Vec3::Unit(c % 3);
      BodyMotion x = here, v = here;
      if (c < 3) {
        x.X_WB_end.p += step;
        v.V_WB_end.v += step;
      } else {
        x.X_WB_end.q = Quat(Eigen::AngleAxisd(h, Eigen::Vector3d(Vec3::Unit(c % 3)))) * x.X_WB_end.q;
        v.V_WB_end.w += step;
      }
      x.X_WB_begin = x.X_WB_end;
      K.col(c) = (wrench(x) - F) / h;
      D.col(c) = (wrench(v) - F) / h;
    }
    refuse_above_one(i, K, D, W, dt, "use a model that linearises its contact");
  }

  void warn_held_twice() {
    const btDispatcher* dispatcher = world_.getDispatcher();
    for (std::size_t i = 0; i < wheels_.size(); ++i) {
      if (wheels_[i].warned) continue;
      const btCollisionObject* own = hosts_[i].collision_object();
      for (int k = 0; own && k < dispatcher->getNumManifolds(); ++k) {
        const btPersistentManifold* m = const_cast<btDispatcher*>(dispatcher)->getManifoldByIndexInternal(k);
        if (m->getNumContacts() == 0 || (m->getBody0() != own && m->getBody1() != own)) continue;
        const btCollisionObject* other = m->getBody0() == own ? m->getBody1() : m->getBody0();
        if (!other->isStaticOrKinematicObject() || !own->hasContactResponse() || !other->hasContactResponse()) continue;
        bool touching = false;
        for (int c = 0; c < m->getNumContacts(); ++c) touching = touching || m->getContactPoint(c).getDistance() <= 0;
        if (!touching) continue;
        wheels_[i].warned = true;
        warn("wheel '" + terrain_->bodies()[i].name +
             "' also collides with a static shape: it is held twice, by the soil and by Bullet's contact solver. Take "
             "the ground "
             "shape out of the wheel's collision mask, or give the wheel no collision shape");
        break;
      }
    }
  }

  void warn(const std::string& text) const {
    if (options_.warn)
      options_.warn(text);
    else
      std::clog << "grouser: " << text << '\n';
  }

  std::string singular_message(const WheelGroup& g, double dt) const {
    std::string names;
    for (const std::size_t i : g.wheels) names += (names.empty() ? "'" : ", '") + terrain_->bodies()[i].name + "'";
    return terrain_->id() + ": the contact linearisation of wheel " + names + " at t = " + number(time_) +
           " s is anti-restoring faster than dt = " + number(dt) + " s can follow (or not finite); use a smaller dt";
  }
  static std::string number(double x) {
    char buf[32];
    std::snprintf(buf, sizeof buf, "%.4g", x);
    return buf;
  }

  btDiscreteDynamicsWorld& world_;
  std::shared_ptr<Terrain> terrain_;
  Options options_;
  Axes axes_;
  Mobility mobility_;
  std::vector<HostBody> hosts_;
  std::vector<Wheel> wheels_;
  std::vector<BodyMotion> motions_;
  std::vector<BodyResult> results_;
  AdapterEnergy energy_;
  std::int64_t releases_ = 0, teleports_ = 0;
  double time_ = 0, terrain_seconds_ = 0;
};

}  // namespace grouser::bullet
