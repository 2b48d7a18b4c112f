#include "grouser/terrain/terrain.h"

#include <cmath>
#include <cstdio>

#include "grouser/terrain/config.h"
#include "grouser/terrain/parallel.h"

namespace grouser {

namespace {
std::string at(double t) {
  char buf[48];
  std::snprintf(buf, sizeof buf, " at t = %.6f s", t);
  return buf;
}
bool finite(const Pose& X) { return X.p.allFinite() && X.q.coeffs().allFinite(); }
bool unit(const Quat& q) { return std::abs(q.squaredNorm() - 1.0) < 1e-5; }
}  // namespace

int Terrain::add_body(BodySpec body) {
  if (started_)
    throw TerrainError("add_body('" + body.name + "') after the first step: add every wheel before stepping");
  do_add_body(body);
  bodies_.push_back(std::move(body));
  return static_cast<int>(bodies_.size()) - 1;
}

std::optional<SimplifiedGear> Terrain::simplified_gear(int body) const {
  const RunningGear& gear = bodies_.at(static_cast<std::size_t>(body)).gear;
  if (capabilities().lugs || std::holds_alternative<SmoothCylinder>(gear.shape)) return std::nullopt;
  char as[80];
  std::snprintf(as, sizeof as, "smooth cylinder of radius %.6g mm", 1e3 * gear.outer_radius());
  return SimplifiedGear{as, "model " + id() + " does not resolve lugs or meshes"};
}

void Terrain::check_motions(double t, double dt, std::span<const BodyMotion> m, std::span<BodyResult> r) const {
  if (!(dt > 0) || !std::isfinite(dt))
    throw TerrainError("dt must be positive and finite, got " + std::to_string(dt) + at(t));
  if (!std::isfinite(t)) throw TerrainError("t is not finite");
  if (started_ && std::abs(t - time_) > 1e-9 * std::max(1.0, std::abs(time_)) + 1e-6 * dt)
    throw TerrainError("time must be contiguous: the last step ended" + at(time_) + ", this one begins" + at(t));
  if (m.size() != bodies_.size() || r.size() != bodies_.size())
    throw TerrainError("step got " + std::to_string(m.size()) + " motions and " + std::to_string(r.size()) +
                       " results for " + std::to_string(bodies_.size()) + " bodies");
  for (std::size_t i = 0; i < m.size(); ++i) {
    const BodyMotion& b = m[i];
    if (!finite(b.X_WB_begin) || !finite(b.X_WB_end) || !b.V_WB_end.v.allFinite() || !b.V_WB_end.w.allFinite())
      throw TerrainError("motion of body '" + bodies_[i].name + "' is not finite" + at(t));
    if (!unit(b.X_WB_begin.q) || !unit(b.X_WB_end.q))
      throw TerrainError("orientation of body '" + bodies_[i].name + "' is not a unit quaternion" + at(t));
    if (b.hub && !(b.hub->mass > 0))
      throw TerrainError("hub mass of body '" + bodies_[i].name + "' must be positive" + at(t));
  }
}

void Terrain::check_results(double t, std::span<const BodyResult> r) const {
  for (std::size_t i = 0; i < r.size(); ++i)
    if (!r[i].impulse.allFinite() || !r[i].angular_impulse.allFinite())
      throw TerrainError(id() + ": impulse on body '" + bodies_[i].name + "' is not finite" + at(t));
}

void Terrain::step(double t, double dt, std::span<const BodyMotion> motions, std::span<BodyResult> results) {
  check_motions(t, dt, motions, results);
  started_ = true;
  do_step({t, dt, true}, motions, results);
  check_results(t, results);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const double w =
        results[i].impulse.dot(motions[i].V_WB_end.v) + results[i].angular_impulse.dot(motions[i].V_WB_end.w);
    energy_.work_on_bodies += w;
    energy_.gross += std::abs(w);
  }
  time_ = t + dt;
}

void Terrain::preview(double t, double dt, std::span<const BodyMotion> motions, std::span<BodyResult> results) {
  check_motions(t, dt, motions, results);
  do_preview({t, dt, false}, motions, results);
  check_results(t, results);
}

void Terrain::do_preview(const StepContext& c, std::span<const BodyMotion> motions, std::span<BodyResult> results) {
  State before;
  traverse(before);
  do_step(c, motions, results);
  before.rewind(State::Mode::load);
  traverse(before);
}

SurfaceSample Terrain::surface(double x, double y) const {
  if (!std::isfinite(x) || !std::isfinite(y)) throw TerrainError("surface(x, y) needs finite coordinates");
  return do_surface(x, y);
}

SurfaceSample Terrain::do_surface(double x, double y) const {
  return {ground_->height(x, y), ground_->normal(x, y), 0.0};
}

double Terrain::field(const std::string& name, double, double) const {
  throw TerrainError(id() + " has no field '" + name + "'");
}

void Terrain::set_effect(const std::string& eid, double amplitude) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    ids.push_back(effects_[i].id);
    if (effects_[i].id != eid) continue;
    if (!std::isfinite(amplitude) || amplitude < effects_[i].lower || amplitude > effects_[i].upper)
      throw TerrainError("effect '" + eid + "' of " + id() + ": amplitude " + std::to_string(amplitude) + " " +
                         effects_[i].unit + " is outside [" + std::to_string(effects_[i].lower) + ", " +
                         std::to_string(effects_[i].upper) + "]");
    effects_[i].amplitude = amplitude;
    do_set_effect(i, amplitude);
    return;
  }
  const auto near = did_you_mean(eid, ids);
  throw TerrainError(id() + " has no effect '" + eid + "'" + (near ? "; did you mean '" + *near + "'?" : ""));
}

void Terrain::traverse(State& s) {
  std::string model = id();
  s.field("model", model);
  if (model != id()) throw StateError("state belongs to terrain '" + model + "', not to '" + id() + "'");
  s.field("time", time_);
  s.field("started", started_);
  s.field("energy/work_on_bodies", energy_.work_on_bodies);
  s.field("energy/stored", energy_.stored);
  s.field("energy/dissipated", energy_.dissipated);
  s.field("energy/external", energy_.external);
  s.field("energy/integration", energy_.integration);
  s.field("energy/gross", energy_.gross);
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    double a = effects_[i].amplitude;
    s.field("effect/" + effects_[i].id, a);
    if (s.loading() && a != effects_[i].amplitude) {
      effects_[i].amplitude = a;
      do_set_effect(i, a);
    }
  }
  do_traverse(s);
}

void Terrain::set_threads(int n) {
  if (n < 1) throw TerrainError("set_threads needs at least 1, got " + std::to_string(n));
  threads_ = n;
}

void Terrain::parallel_for(int n, const std::function<void(int)>& f) { grouser::parallel_for(n, threads_, f); }

}  // namespace grouser
