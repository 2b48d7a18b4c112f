#include "dem_run.h"

#include <fmt/core.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>

#include "dem_grains.h"
#include "dem_table.h"
#include "grouser/terrain/checkpoint.h"
#include "grouser/terrain/recorder.h"
#include "grouser/terrain/state_stream.h"
#include "whole_file.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Large arrays that are freed go back to the system at once, small ones after saving: else the largest memory is that of
/// reading, saving and writing together (100 bytes a grain more).
void keep_no_memory() {
#if defined(__GLIBC__)
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  malloc_trim(0);
#endif
}

double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

class Run {
 public:
  Run(DemCase& c, const DemRunOptions& o) : case_(c), options_(o), solver_(c.solver, std::move(c.grains)) {
    for (const DemBody& b : c.bodies) {
      const int n = solver_.add_body(b.settings);
      try {
        for (const DemBody::Surface& s : b.surfaces) add(n, s);
      } catch (const dem::GrainError& e) {
        throw dem::GrainError(fmt::format("{}; body {} is '{}'", e.what(), n, b.name), e.grains);
      }
    }
    forces_.columns = {"time_s"};
    for (const DemBody& b : c.bodies)
      for (const char* q : {"fx_N", "fy_N", "fz_N", "tx_Nm", "ty_Nm", "tz_Nm", "x_m", "y_m", "z_m", "vx_m_s", "vy_m_s",
                            "vz_m_s", "contacts"})
        forces_.columns.push_back(b.name + "_" + q);
    if (c.solver.ledger)
      energy_.columns = {"time_s",
                         "kinetic_J",
                         "normal_spring_J",
                         "tangential_spring_J",
                         "rolling_spring_J",
                         "normal_damping_J",
                         "tangential_damping_J",
                         "rolling_damping_J",
                         "sliding_J",
                         "rolling_slip_J",
                         "stiffness_change_J",
                         "gravity_J",
                         "bodies_J",
                         "start_J",
                         "residual_J"};
    // Steps at which something happens: outputs, changes of motion, the end.
    const auto step_of = [&](double t) { return std::lround(t / c.solver.dt); };
    last_step_ = std::max(1L, step_of(c.duration));
    for (double k = 1; k * c.output_every < c.duration; ++k) {
      const long at = step_of(k * c.output_every);
      if (at > (outputs_.empty() ? 0 : outputs_.back()) && at < last_step_) outputs_.push_back(at);
    }
    outputs_.push_back(last_step_);
    for (std::size_t b = 0; b < c.bodies.size(); ++b)
      for (std::size_t k = 0; k < c.bodies[b].schedule.size(); ++k)
        events_.push_back({step_of(c.bodies[b].schedule[k].from), static_cast<int>(b), k});
    std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) { return a.step < b.step; });
    impulse_.assign(c.bodies.size(), Vec3::Zero());
  }

  DemRunResult go() {
    const auto begin = Clock::now();
    continue_from_checkpoint();
    DemRunResult r;
    auto saved = Clock::now();
    try {
      while (step_ < last_step_) {
        const long target = outputs_[next_output_];
        while (step_ < target) {
          while (next_event_ < events_.size() && events_[next_event_].step <= step_) apply(events_[next_event_++]);
          const long until = next_event_ < events_.size() ? std::min(target, events_[next_event_].step) : target;
          // With an adaptive step these are steps of the clock, as long as the first one.
          if (case_.solver.adapt > 0)
            solver_.step_for(static_cast<double>(until) * case_.solver.dt - solver_.time());
          else
            solver_.step(until - step_);
          step_ = until;
        }
        output();
        ++next_output_;
        if (options_.progress) options_.progress(solver_.time(), case_.duration);
        if (step_ < last_step_ && since(saved) > options_.checkpoint_every) {
          save();
          saved = Clock::now();
        }
      }
      save();
    } catch (const dem::GrainError& e) {
      r.stopped = grain_error(case_.grain_files, e).diagnostics().front().message;
    } catch (const dem::DemError& e) {
      r.stopped = e.what();
    }
    write(r.stopped.empty());
    keep_no_memory();
    r.forces = forces_;
    r.energy = energy_;
    r.counters = solver_.counters();
    r.stable_step = solver_.stable_step();
    r.wall = since(begin);
    StateStream state;
    solver_.traverse(state.state());
    state.finish();
    r.hash = state.hash();
    return r;
  }

 private:
  struct Event {
    long step;
    int body;
    std::size_t motion;
  };

  void add(int body, const DemBody::Surface& s) {
    using Kind = DemBody::Surface::Kind;
    switch (s.kind) {
      case Kind::plane:
        solver_.add_plane(body, s.point, s.normal, s.material);
        break;
      case Kind::mesh:
        solver_.add_mesh(body, s.mesh, s.material, s.solid);
        break;
      case Kind::cylinder:
        solver_.add_cylinder(body, s.radius, s.half_width, s.material);
        break;
      case Kind::spheres:
        solver_.add_spheres(body, s.centres, s.radii, s.material);
        break;
    }
  }

  void apply(const Event& e) {
    const DemBody& b = case_.bodies[static_cast<std::size_t>(e.body)];
    const DemMotion& m = b.schedule[e.motion];
    Twist V = m.V;
    if (b.settings.free && e.step > 0) {
      // Free directions keep the velocity that they have.
      const Twist now = solver_.twist(e.body);
      for (int k = 0; k < 3; ++k) {
        if (!b.settings.locked[static_cast<std::size_t>(k)]) V.v[k] = now.v[k];
        if (!b.settings.locked[static_cast<std::size_t>(3 + k)]) V.w[k] = now.w[k];
      }
    }
    solver_.set_motion(e.body, V);
    if (m.has_load) solver_.set_load(e.body, m.force, m.torque);
  }

  /// Forces: mean since the last output; torques, poses and velocities: now.
  void output() {
    const double span = solver_.time() - last_output_;
    std::vector<double> row{solver_.time()};
    for (std::size_t b = 0; b < case_.bodies.size(); ++b) {
      const int n = static_cast<int>(b);
      const dem::SurfaceReport report = solver_.body(n);
      const Vec3 f = (report.impulse - impulse_[b]) / span;
      const Pose X = solver_.pose(n);
      const Twist V = solver_.twist(n);
      for (const Vec3& v : {f, report.torque, X.p, V.v})
        for (int k = 0; k < 3; ++k) row.push_back(v[k]);
      row.push_back(report.contacts);
      impulse_[b] = report.impulse;
    }
    last_output_ = solver_.time();
    forces_.rows.push_back(std::move(row));
    if (!case_.solver.ledger) return;
    const dem::Ledger l = solver_.ledger();
    energy_.rows.push_back({solver_.time(), l.kinetic, l.normal_spring, l.tangential_spring, l.rolling_spring,
                            l.normal_damping, l.tangential_damping, l.rolling_damping, l.sliding, l.rolling_slip,
                            l.tangential_change + l.rolling_change, l.gravity, l.bodies, l.start, l.residual()});
  }

  void traverse(State& s) {
    s.field("step", step_);
    s.field("next_output", next_output_);
    s.field("next_event", next_event_);
    s.field("last_output", last_output_);
    for (Vec3& v : impulse_) s.field("impulse", v);
    forces_.traverse(s, "forces");
    energy_.traverse(s, "energy");
    const auto g = s.group("solver");
    solver_.traverse(s);
  }

  fs::path checkpoint() const { return options_.out / "checkpoint.h5"; }
  void save() {
    Checkpoint now;
    now.scenario = case_.inputs;
    now.version = GROUSER_VERSION;
    now.time = solver_.time();
    now.frames = forces_.rows.size();
    write_checkpoint(checkpoint(), now, [this](State& s) { traverse(s); });
    keep_no_memory();
  }
  void continue_from_checkpoint() {
    if (!fs::exists(checkpoint())) return;
    Checkpoint saved = read_checkpoint(checkpoint());
    if (saved.scenario != case_.inputs || saved.version != GROUSER_VERSION)
      throw ResultsError(checkpoint().string() +
                         ": is of another input or version; use --overwrite, or another folder with --out");
    traverse(saved.state);
    saved.state.finish();
  }

  void write(bool finished) {
    write_whole_file(options_.out / "forces.csv", csv_text(forces_));
    if (case_.solver.ledger) write_whole_file(options_.out / "energy.csv", csv_text(energy_));
    // A state that is no longer finite is of no use.
    if (!finished) return;
    const std::vector<dem::GrainState> grains = solver_.grains();
    write_grains_csv(options_.out / "grains.csv", grains, case_.materials);
    if (case_.contacts)
      write_contacts_csv(options_.out / "contacts.csv", grains, case_.solver.domain, case_.solver.materials);
  }

  const DemCase& case_;
  const DemRunOptions& options_;
  dem::Solver solver_;
  dem::Table forces_, energy_;
  std::vector<long> outputs_;
  std::vector<Event> events_;
  std::vector<Vec3> impulse_;
  long step_ = 0, last_step_ = 0;
  std::size_t next_output_ = 0, next_event_ = 0;
  double last_output_ = 0;
};

}  // namespace

DemRunResult run_dem(DemCase& c, const DemRunOptions& o) {
  keep_no_memory();
  return Run(c, o).go();
}

}  // namespace grouser::app
